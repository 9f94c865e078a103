//! Joints of the file.

use super::advice::RENAMED;
use super::file::{Acts, Joint, ModelFile};
use super::loads::{function, prescribed_function};
use super::names::Names;
use super::parts::Laid;
use super::registry::{JointType, Refusal, Registry, Site};
use super::{InputError, Problem, Text, plain};
use pullback_elements::beam::Interpolation;
use pullback_elements::joint::{AxisError, JointNodes};
use pullback_elements::load::CoordinateForce;
use pullback_elements::model::{ModelBuilder, ModelError, NodeId};
use pullback_elements::spring::{CoordinateLaw, CoordinateSpring};

/// Keys of a joint that releases one coordinate.
const ACTS: [&str; 5] = ["spring", "actuator", "prescribed", "value", "rate"];

/// A joint of the file with its position there.
struct Entry<'a> {
    source: &'a Text<'a>,
    joint: &'a Joint,
    made: &'a JointType,
    index: String,
}

impl Entry<'_> {
    fn path<'b>(&'b self, inner: &[&'b str]) -> Vec<&'b str> {
        [&["joints", self.index.as_str()][..], inner].concat()
    }

    /// A missing key.
    fn missing(&self, key: impl Into<String>) -> InputError {
        let key = key.into();
        let earlier = RENAMED.iter().filter(|(_, now)| *now == key);
        for (word, _) in earlier {
            if self.joint.keys.contains_key(*word) {
                return self.useless(&[word]);
            }
        }
        let problem = Problem::JointNeeds {
            joint: self.joint.name.clone(),
            kind: self.joint.kind.clone(),
            key,
        };
        self.source.value(&self.path(&[]), problem)
    }

    /// A key (the last one of a path) that does not apply.
    fn useless(&self, path: &[&str]) -> InputError {
        let base = if self.made.along { "lines" } else { "parent" };
        let mut known = self.made.keys();
        let all = ["name", "type", base, "child", "closure", "penalty"];
        known.extend(all.map(str::to_owned));
        known.extend(["penalty_damping", "coordinates"].map(str::to_owned));
        known.extend(ACTS.map(str::to_owned));
        // A joint with several coordinates has these keys in `coordinates`.
        known.retain(|known| path != [known]);
        let problem = Problem::JointKey {
            joint: self.joint.name.clone(),
            kind: self.joint.kind.clone(),
            key: path.join("."),
            known,
        };
        self.source.key(&self.path(path), problem)
    }

    /// Refusal of a joint by its type.
    fn refused(&self, refusal: Refusal) -> InputError {
        fn strings(path: &[String]) -> Vec<&str> {
            path.iter().map(String::as_str).collect()
        }
        match refusal {
            Refusal::Missing(key) => self.missing(key),
            Refusal::Unknown(path) => self.useless(&strings(&path)),
            Refusal::Value(path, message) => {
                let problem = Problem::Toml(plain(&message));
                self.source.value(&self.path(&strings(&path)), problem)
            }
            Refusal::Joint(error) => match error.downcast::<ModelError>() {
                Ok(error) => {
                    let at: &[&str] = match *error {
                        ModelError::Slide { .. } if self.joint.keys.contains_key("start") => {
                            &["start"]
                        }
                        ModelError::Slide { .. } => &["lines"],
                        _ => &[],
                    };
                    self.source.value(&self.path(at), Problem::Model(*error))
                }
                Err(source) => {
                    let at: &[&str] = if source.is::<AxisError>() {
                        &["axis"]
                    } else {
                        &[]
                    };
                    let joint = self.joint.name.clone();
                    let problem = Problem::Joint { joint, source };
                    self.source.value(&self.path(at), problem)
                }
            },
        }
    }
}

/// Adds joint number `k` of the file, whose parents exist; returns its node and the nodes of its single coordinates.
pub(super) fn make(
    source: &Text<'_>,
    registry: &Registry,
    builder: &mut ModelBuilder,
    nodes: &Names<NodeId>,
    file: &ModelFile,
    laid: &Laid,
    k: usize,
) -> Result<JointNodes, InputError> {
    let (joint, index) = (&file.joints[k], k.to_string());
    let made = registry.get(&joint.kind).ok_or_else(|| {
        let problem = Problem::UnknownName {
            what: "type of joint",
            name: joint.kind.clone(),
            known: registry.types().map(|(name, _)| name.clone()).collect(),
        };
        source.value(&["joints", &index, "type"], problem)
    })?;
    let entry = Entry {
        source,
        joint,
        made,
        index,
    };
    let (chain, interpolation) = hangs_on(&entry, nodes, laid)?;
    let Some(&parent) = chain.first() else {
        return Err(entry.missing("lines"));
    };
    let mut site = Site {
        builder,
        name: &joint.name,
        parent,
        chain: &chain,
        interpolation,
    };
    let JointNodes { frame, coordinates } =
        (made.make)(&joint.keys, &mut site).map_err(|refusal| entry.refused(refusal))?;
    let single = coordinates.into_iter().filter(|&n| builder.dim(n) == 1);
    let coordinates: Vec<NodeId> = single.collect();
    acts(&entry, builder, &coordinates)?;
    Ok(JointNodes { frame, coordinates })
}

/// The nodes to which a joint is attached, and the interpolation of rotations between them.
fn hangs_on(
    entry: &Entry<'_>,
    nodes: &Names<NodeId>,
    laid: &Laid,
) -> Result<(Vec<NodeId>, Interpolation), InputError> {
    let Entry { joint, made, .. } = *entry;
    if made.along {
        if joint.parent.is_some() {
            return Err(entry.useless(&["parent"]));
        }
        return chain(entry, laid);
    }
    if !joint.lines.is_empty() {
        return Err(entry.useless(&["lines"]));
    }
    let parent = (joint.parent.as_ref()).ok_or_else(|| entry.missing("parent"))?;
    let node = nodes.find(entry.source, &entry.path(&["parent"]), parent)?;
    Ok((vec![node], Interpolation::default()))
}

/// Adds springs, actuators and prescribed motions to the released coordinates.
fn acts(
    entry: &Entry<'_>,
    builder: &mut ModelBuilder,
    released: &[NodeId],
) -> Result<(), InputError> {
    let Entry { source, joint, .. } = *entry;
    let own = joint.acts();
    let given = [
        own.spring.is_some(),
        own.actuator.is_some(),
        own.prescribed.is_some(),
        own.value.is_some(),
        own.rate.is_some(),
    ];
    if let &[node] = released {
        if !joint.coordinates.is_empty() {
            return Err(entry.useless(&["coordinates"]));
        }
        return act(source, builder, &entry.path(&[]), &joint.name, &own, node);
    }
    if let Some(key) = (ACTS.iter().zip(given)).find_map(|(key, given)| given.then_some(key)) {
        return Err(entry.useless(&[key]));
    }
    if released.is_empty() && !joint.coordinates.is_empty() {
        return Err(entry.useless(&["coordinates"]));
    }
    for (coordinate, acts) in &joint.coordinates {
        let at = entry.path(&["coordinates", coordinate]);
        let full = format!("{} {coordinate}", joint.name);
        let node = released.iter().find(|&&n| builder.node_name(n) == full);
        let &node = node.ok_or_else(|| {
            let names = released.iter().map(|&n| builder.node_name(n));
            let names = names.map(|n| n.strip_prefix(&joint.name).unwrap_or(n).trim_start());
            let problem = Problem::UnknownName {
                what: "coordinate of the joint",
                name: coordinate.clone(),
                known: names.map(str::to_owned).collect(),
            };
            source.key(&at, problem)
        })?;
        act(source, builder, &at, &full, acts, node)?;
    }
    Ok(())
}

/// The nodes along a joint's lines, and the interpolation of rotations between them.
fn chain(entry: &Entry<'_>, laid: &Laid) -> Result<(Vec<NodeId>, Interpolation), InputError> {
    let Entry { source, joint, .. } = *entry;
    let mut chain: Vec<NodeId> = Vec::new();
    let mut interpolation = None;
    for (i, name) in joint.lines.iter().enumerate() {
        let index = i.to_string();
        let at = entry.path(&["lines", index.as_str()]);
        // The lines of a joint are meshed before it.
        let Some(line) = &laid.lines[laid.names.find(source, &at, name)?] else {
            continue;
        };
        let follows = chain.last().is_none_or(|last| *last == line.nodes[0]);
        let same = *interpolation.get_or_insert(line.interpolation) == line.interpolation;
        if line.order != 1 || !follows || !same {
            let problem = Problem::SlideLine {
                joint: joint.name.clone(),
                line: name.clone(),
                order: line.order,
            };
            return Err(source.value(&at, problem));
        }
        let first = usize::from(!chain.is_empty());
        chain.extend(&line.nodes[first..]);
    }
    Ok((chain, interpolation.unwrap_or_default()))
}

/// Spring, actuator and prescribed motion of the released coordinate `name` at the path `at`.
fn act(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    at: &[&str],
    name: &str,
    acts: &Acts,
    coordinate: NodeId,
) -> Result<(), InputError> {
    let path = |key: &'static str| [at, &[key]].concat();
    if let Some(value) = acts.value {
        builder.start(coordinate, 0, value);
    }
    if acts.rate.is_some() {
        builder.prefer(coordinate);
    }
    if let Some(time) = &acts.prescribed {
        for (key, given) in [
            ("spring", acts.spring.is_some()),
            ("actuator", acts.actuator.is_some()),
            ("value", acts.value.is_some()),
            ("rate", acts.rate.is_some()),
        ] {
            if given {
                let joint = name.to_owned();
                return Err(source.key(&path(key), Problem::PrescribedJoint { joint, key }));
            }
        }
        let prescribed = prescribed_function(source, &path("prescribed"), time)?;
        builder.prescribe_coordinate(coordinate, 0, prescribed);
    }
    if let Some(s) = acts.spring {
        let law = CoordinateLaw {
            k: s.k,
            k3: s.k3,
            c: s.c,
            x0: s.x0,
        };
        let spring = CoordinateSpring::new(law).map_err(|error| {
            let problem = Problem::Spring {
                spring: format!("of joint {name}"),
                source: error,
            };
            source.value(&path("spring"), problem)
        })?;
        builder
            .element(format!("spring of {name}"), spring, &[coordinate])
            .map_err(|error| source.value(&path("spring"), Problem::Model(error)))?;
    }
    if let Some(time) = &acts.actuator {
        let actuator = CoordinateForce::boxed(function(source, &path("actuator"), time)?);
        builder
            .element(format!("actuator of {name}"), actuator, &[coordinate])
            .map_err(|error| source.value(&path("actuator"), Problem::Model(error)))?;
    }
    Ok(())
}
