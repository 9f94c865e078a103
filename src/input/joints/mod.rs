//! Joints of the file.

mod registry;
mod types;

pub use registry::{BoxedError, Registry, Site};

pub(super) use registry::JointType;

use super::advice::RENAMED;
use super::file::{Acts, Analysis, Joint};
use super::names::Names;
use super::parts::{Assembly, function, prescribed_function};
use super::{InputError, InputProblem, Location, plain};
use pullback_elements::beam::Interpolation;
use pullback_elements::joint::AxisError;
use pullback_elements::load::CoordinateForce;
use pullback_elements::model::{ModelBuilder, ModelError, NodeId};
use pullback_elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback_elements::time::{Input, SteadyRotation};
use pullback_manifold::system::Quantity;
use registry::Refusal;

/// Part of an amplitude by which the shape of an imperfection may move a joint along its own coordinate.
const AT_REST: f64 = 1e-6;

/// A joint of the file with its location there.
struct Entry<'a> {
    at: Location<'a>,
    joint: &'a Joint,
    made: &'a JointType,
}

impl Entry<'_> {
    /// A missing key.
    fn missing(&self, key: impl Into<String>) -> InputError {
        let key = key.into();
        let mut earlier = RENAMED.iter().filter(|(_, now)| *now == key);
        if let Some((word, _)) = earlier.find(|(word, _)| self.joint.keys.contains_key(*word)) {
            return self.useless(&[word]);
        }
        self.at.refuse(InputProblem::JointNeeds {
            joint: self.joint.name.clone(),
            kind: self.joint.kind.clone(),
            key,
        })
    }

    /// A key (the last one of a path) that does not apply.
    fn useless(&self, path: &[impl AsRef<str>]) -> InputError {
        let of_coordinates = Acts::KEYS.iter().chain(&["coordinates"]);
        self.refuse(path, of_coordinates.map(|key| (*key).to_owned()))
    }

    /// A key that does not apply, beside those of any joint of the type and others.
    fn refuse(
        &self,
        path: &[impl AsRef<str>],
        others: impl IntoIterator<Item = String>,
    ) -> InputError {
        let key = path.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(".");
        let base = if self.made.along { "lines" } else { "parent" };
        let mut known = self.made.keys();
        let all = ["name", "type", base, "child", "closure", "penalty"];
        known.extend(all.map(str::to_owned));
        known.push("penalty_damping".to_owned());
        known.extend(others);
        // A joint with several coordinates has these keys in `coordinates`.
        known.retain(|known| *known != key);
        self.inner(path).refuse_key(InputProblem::JointKey {
            joint: self.joint.name.clone(),
            kind: self.joint.kind.clone(),
            key,
            known,
        })
    }

    /// The location of a path within the joint.
    fn inner(&self, path: &[impl AsRef<str>]) -> Location<'_> {
        (path.iter()).fold(self.at.clone(), |at, key| at.at(key.as_ref()))
    }

    /// Refusal of a joint by its type.
    fn refused(&self, refusal: Refusal) -> InputError {
        let error = match refusal {
            Refusal::Missing(key) => return self.missing(key),
            Refusal::Unknown(path) => return self.useless(&path),
            Refusal::Value(path, message) => {
                return self
                    .inner(&path)
                    .refuse(InputProblem::Toml(plain(&message)));
            }
            Refusal::Joint(error) => error,
        };
        match error.downcast::<ModelError>() {
            Ok(error) => {
                let at = match *error {
                    ModelError::Slide { .. } if self.joint.keys.contains_key("start") => {
                        self.at.at("start")
                    }
                    ModelError::Slide { .. } => self.at.at("lines"),
                    _ => self.at.clone(),
                };
                at.refuse(*error)
            }
            Err(source) => {
                let at = match source.is::<AxisError>() {
                    true => self.at.at("axis"),
                    false => self.at.clone(),
                };
                let joint = self.joint.name.clone();
                at.refuse(InputProblem::Joint { joint, source })
            }
        }
    }
}

impl Assembly<'_> {
    /// Adds a joint whose parents exist, its node and its released coordinates.
    pub(super) fn add_joint(&mut self, registry: &Registry, k: usize) -> Result<(), InputError> {
        let (at, joint) = (self.at("joints").at(k), &self.file.joints[k]);
        let made = registry.get(&joint.kind).ok_or_else(|| {
            at.at("type").refuse(InputProblem::UnknownName {
                what: "type of joint",
                name: joint.kind.clone(),
                known: registry.types().map(|(name, _)| name.clone()).collect(),
            })
        })?;
        let entry = Entry { at, joint, made };
        let (chain, interpolation) = attached_to(&entry, self)?;
        let Some(&parent) = chain.first() else {
            return Err(entry.missing("lines"));
        };
        let of_parent = self.builder.node_name(parent);
        let [moved, carried] = [&joint.name, of_parent].map(|node| self.offset(&entry.at, node));
        let [moved, carried] = [moved?[0], carried?[0]];
        let mut site = Site {
            builder: &mut self.builder,
            name: &joint.name,
            parent,
            chain: &chain,
            interpolation,
            moved,
        };
        let nodes =
            (made.make)(&joint.keys, &mut site).map_err(|refusal| entry.refused(refusal))?;
        let [frame, parent] = [nodes.frame, parent].map(|node| self.builder.position(node));
        let amplitudes = self.file.imperfections.iter().map(|i| i.amplitude.abs());
        if frame == parent && (moved - carried).norm() > AT_REST * amplitudes.sum::<f64>() {
            let joint = joint.name.clone();
            return Err(entry.at.refuse(InputProblem::ShapeOfJoint { joint }));
        }
        let single = |n: &NodeId| self.builder.quantities(*n).len() == 1;
        let single: Vec<NodeId> = nodes.coordinates.iter().copied().filter(single).collect();
        acts(&entry, &mut self.builder, &self.inputs, &single)?;
        if let Analysis::Campbell(campbell) = &self.file.analysis
            && campbell.joint == joint.name
        {
            self.rotate(&entry, &single)?;
        }
        self.nodes.add(joint.name.clone(), nodes.frame);
        self.joints[k] = Some(nodes);
        for &coordinate in &single {
            // A single coordinate has the name of the joint.
            let name = match single.len() {
                1 => joint.name.clone(),
                _ => self.builder.node_name(coordinate).to_owned(),
            };
            self.joint_coordinates.add(name, coordinate);
        }
        Ok(())
    }

    /// Makes the angle of a revolute joint one of steady rotation.
    fn rotate(&mut self, entry: &Entry<'_>, coordinates: &[NodeId]) -> Result<(), InputError> {
        let joint = entry.joint;
        let refused = |why: String| {
            let joint = joint.name.clone();
            InputProblem::NoRotation { joint, why }
        };
        let angle = match *coordinates {
            [only] if self.builder.quantities(only) == [Quantity::Angle] => only,
            _ => {
                let at = self.at("analysis").at("campbell").at("joint");
                let why = format!("type `{}` does not release one angle", joint.kind);
                return Err(at.refuse(refused(why)));
            }
        };
        if let Some(key) = joint.acts().given().next() {
            let why = format!("it has `{key}`, and its speed is that of the diagram");
            return Err(entry.at.at(key).refuse_key(refused(why)));
        }
        let speed = self.builder.input(0.0);
        (self.builder).prescribe_coordinate(angle, 0, SteadyRotation(speed));
        self.speed = Some(speed);
        Ok(())
    }
}

/// The nodes to which a joint is attached, and the interpolation of rotations between them.
fn attached_to(
    entry: &Entry<'_>,
    assembly: &Assembly<'_>,
) -> Result<(Vec<NodeId>, Interpolation), InputError> {
    let Entry { at, joint, made } = entry;
    if made.along {
        if joint.parent.is_some() {
            return Err(entry.useless(&["parent"]));
        }
        return chain(at, joint, assembly);
    }
    if !joint.lines.is_empty() {
        return Err(entry.useless(&["lines"]));
    }
    let parent = (joint.parent.as_ref()).ok_or_else(|| entry.missing("parent"))?;
    let node = assembly.nodes.find(&at.at("parent"), parent)?;
    Ok((vec![node], Interpolation::default()))
}

/// Adds springs, actuators and prescribed motions to the released coordinates.
fn acts(
    entry: &Entry<'_>,
    builder: &mut ModelBuilder,
    inputs: &Names<Input>,
    released: &[NodeId],
) -> Result<(), InputError> {
    let Entry { at, joint, .. } = entry;
    let own = joint.acts();
    if released.is_empty() {
        let coordinates = (!joint.coordinates.is_empty()).then_some("coordinates");
        let given = own.given().next().or(coordinates);
        return given.map_or(Ok(()), |key| Err(entry.refuse(&[key], [])));
    }
    if released.len() < 2 && !joint.coordinates.is_empty() {
        return Err(entry.useless(&["coordinates"]));
    }
    if let &[node] = released {
        return act(at, (builder, inputs), &joint.name, &own, node);
    }
    let names = released.iter().map(|&n| builder.node_name(n));
    let names = names.map(|n| n.strip_prefix(&joint.name).unwrap_or(n).trim_start());
    let names: Vec<String> = names.map(str::to_owned).collect();
    if let Some(key) = own.given().next() {
        return Err(at.at(key).refuse_key(InputProblem::JointKey {
            joint: joint.name.clone(),
            kind: joint.kind.clone(),
            key: key.to_owned(),
            known: names
                .iter()
                .map(|name| format!("coordinates.{name}.{key}"))
                .collect(),
        }));
    }
    for (coordinate, acts) in &joint.coordinates {
        let at = at.at("coordinates").at(coordinate);
        let full = format!("{} {coordinate}", joint.name);
        let node = released.iter().find(|&&n| builder.node_name(n) == full);
        let &node = node.ok_or_else(|| {
            at.refuse_key(InputProblem::UnknownName {
                what: "coordinate of the joint",
                name: coordinate.clone(),
                known: names.clone(),
            })
        })?;
        act(&at, (builder, inputs), &full, acts, node)?;
    }
    Ok(())
}

/// The nodes along a joint's lines, and the interpolation of rotations between them.
fn chain(
    at: &Location<'_>,
    joint: &Joint,
    assembly: &Assembly<'_>,
) -> Result<(Vec<NodeId>, Interpolation), InputError> {
    let mut chain: Vec<NodeId> = Vec::new();
    let mut interpolation = None;
    for (i, name) in joint.lines.iter().enumerate() {
        let at = at.at("lines").at(i);
        // The lines of a joint are meshed before it.
        let Some(line) = &assembly.meshed[assembly.lines.find(&at, name)?] else {
            continue;
        };
        let follows = chain.last().is_none_or(|last| *last == line.nodes[0]);
        let same = *interpolation.get_or_insert(line.interpolation) == line.interpolation;
        if line.order != 1 || !follows || !same {
            return Err(at.refuse(InputProblem::SlideLine {
                joint: joint.name.clone(),
                line: name.clone(),
                order: line.order,
            }));
        }
        let first = usize::from(!chain.is_empty());
        chain.extend(&line.nodes[first..]);
    }
    Ok((chain, interpolation.unwrap_or_default()))
}

/// Adds spring, actuator and prescribed motion of the released coordinate `name`.
fn act(
    at: &Location<'_>,
    (builder, inputs): (&mut ModelBuilder, &Names<Input>),
    name: &str,
    acts: &Acts,
    coordinate: NodeId,
) -> Result<(), InputError> {
    if let Some(value) = acts.value {
        builder.start(coordinate, 0, value);
    }
    if acts.rate.is_some() {
        builder.prefer(coordinate);
    }
    if let Some(time) = &acts.prescribed {
        if let Some(key) = acts.given().find(|key| *key != "prescribed") {
            let joint = name.to_owned();
            return Err((at.at(key)).refuse_key(InputProblem::PrescribedJoint { joint, key }));
        }
        let prescribed = prescribed_function(&at.at("prescribed"), inputs, time)?;
        builder.prescribe_coordinate(coordinate, 0, prescribed);
    }
    if let Some(s) = acts.spring {
        let at = at.at("spring");
        let law = CoordinateLaw {
            k: s.k,
            k3: s.k3,
            c: s.c,
            x0: s.x0,
        };
        let spring = CoordinateSpring::new(law).map_err(|source| {
            let spring = format!("of joint {name}");
            at.refuse(InputProblem::Spring { spring, source })
        })?;
        builder
            .element(format!("spring of {name}"), spring, &[coordinate])
            .map_err(|error| at.refuse(error))?;
    }
    if let Some(time) = &acts.actuator {
        let at = at.at("actuator");
        let actuator = CoordinateForce::new(function(&at, inputs, time)?);
        builder
            .element(format!("actuator of {name}"), actuator, &[coordinate])
            .map_err(|error| at.refuse(error))?;
    }
    Ok(())
}
