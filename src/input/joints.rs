//! Joints of the file.

use super::assemble::{LineGeometry, Names};
use super::file::{Acts, Joint, JointKind, ModelFile};
use super::loads::{drive, function};
use super::{InputError, Problem, Text};
use pullback_elements::beam::Interpolation;
use pullback_elements::joint::{
    JointNodes, constant_velocity, cylindrical, helical, offset, planar, prismatic, revolute,
    slide_on, spherical, universal, weld,
};
use pullback_elements::load::CoordinateForce;
use pullback_elements::model::{ModelBuilder, ModelError, NodeId};
use pullback_elements::spring::{CoordinateLaw, CoordinateSpring};

/// The nodes of a joint.
pub(super) struct Made {
    /// The node that hangs on it.
    pub frame: NodeId,
    /// The nodes of the single coordinates that it releases.
    pub released: Vec<NodeId>,
}

impl Made {
    fn fixed(frame: NodeId) -> Self {
        let released = Vec::new();
        Self { frame, released }
    }
}

impl From<JointNodes> for Made {
    fn from(JointNodes { frame, released }: JointNodes) -> Self {
        Self { frame, released }
    }
}

/// Makes joint number `k` of the file, whose masters exist.
pub(super) fn make(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    nodes: &Names<NodeId>,
    file: &ModelFile,
    laid: &[Option<LineGeometry>],
    k: usize,
) -> Result<Made, InputError> {
    let joint = &file.joints[k];
    let index = k.to_string();
    let path = |key: &'static str| ["joints", index.as_str(), key];
    let whole = ["joints", index.as_str()];
    check_keys(source, &path, &whole, joint)?;
    let model = |error: ModelError| source.value(&whole, Problem::Model(error));
    let master = match &joint.master {
        Some(name) => Some(nodes.find(source, &path("master"), name)?),
        None => None,
    };
    let missing = |key| missing(source, &whole, joint, key);
    let on = || master.ok_or_else(|| missing("master"));
    let axis = || joint.axis.ok_or_else(|| missing("axis"));
    let (b, name) = (&mut *builder, joint.name.as_str());
    let at_axis = |error| source.value(&path("axis"), Problem::Model(error));
    let made = match joint.kind {
        JointKind::Offset => {
            let place = joint.place.ok_or_else(|| missing("place"))?;
            Made::fixed(offset(b, name, on()?, place).map_err(model)?)
        }
        JointKind::Weld => Made::fixed(weld(b, name, on()?).map_err(model)?),
        JointKind::Revolute => {
            let made = revolute(b, name, on()?, axis()?).map_err(at_axis)?;
            Made {
                frame: made.frame,
                released: vec![made.angle],
            }
        }
        JointKind::Spherical => Made::fixed(spherical(b, name, on()?).map_err(model)?.frame),
        JointKind::Slide => {
            let (chain, interpolation) = chain(source, file, laid, &path, joint)?;
            let start = joint.start.unwrap_or(0.0);
            let made = slide_on(b, name, &chain, start, interpolation).map_err(|error| {
                let key = if joint.start.is_some() {
                    "start"
                } else {
                    "lines"
                };
                source.value(&path(key), Problem::Model(error))
            })?;
            Made {
                frame: made.frame,
                released: vec![made.way],
            }
        }
        JointKind::Universal => {
            let second = joint.second_axis.ok_or_else(|| missing("second_axis"))?;
            let made = universal(b, name, on()?, [axis()?, second]);
            made.map_err(at_axis)?.into()
        }
        JointKind::ConstantVelocity => {
            let second = joint.second_axis.ok_or_else(|| missing("second_axis"))?;
            let made = constant_velocity(b, name, on()?, [axis()?, second]);
            made.map_err(at_axis)?.into()
        }
        JointKind::Cylindrical => cylindrical(b, name, on()?, axis()?)
            .map_err(at_axis)?
            .into(),
        JointKind::Prismatic => prismatic(b, name, on()?, axis()?).map_err(at_axis)?.into(),
        JointKind::Planar => {
            let first = joint.second_axis.ok_or_else(|| missing("second_axis"))?;
            let made = planar(b, name, on()?, axis()?, first);
            made.map_err(at_axis)?.into()
        }
        JointKind::Helical => {
            let pitch = joint.pitch.ok_or_else(|| missing("pitch"))?;
            let made = helical(b, name, on()?, axis()?, pitch);
            made.map_err(at_axis)?.into()
        }
    };
    for (coordinate, acts) in joint.all_acts() {
        let at = match coordinate {
            "" => whole.to_vec(),
            _ => ["joints", index.as_str(), "coordinates", coordinate].to_vec(),
        };
        match (coordinate, made.released.as_slice()) {
            ("", [node]) => act(source, builder, &at, &joint.name, &acts, *node)?,
            ("", _) => {}
            _ => {
                let full = format!("{} {coordinate}", joint.name);
                let node = made
                    .released
                    .iter()
                    .find(|&&n| builder.node_name(n) == full);
                let &node = node.ok_or_else(|| {
                    let start = joint.name.len() + 1;
                    let names = made
                        .released
                        .iter()
                        .map(|&n| builder.node_name(n)[start..].to_owned());
                    let problem = Problem::UnknownName {
                        what: "coordinate of the joint",
                        name: coordinate.to_owned(),
                        known: names.collect(),
                    };
                    source.key(&at, problem)
                })?;
                act(source, builder, &at, &full, &acts, node)?;
            }
        }
    }
    Ok(made)
}

fn missing(source: &Text<'_>, whole: &[&str], joint: &Joint, key: &'static str) -> InputError {
    let problem = Problem::JointNeeds {
        joint: joint.name.clone(),
        kind: joint.kind.key(),
        key,
    };
    source.value(whole, problem)
}

/// Refuses keys that the kind of joint has no use for.
fn check_keys<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    whole: &[&str],
    joint: &Joint,
) -> Result<(), InputError> {
    let given = [
        ("master", joint.master.is_some()),
        ("axis", joint.axis.is_some()),
        ("place", joint.place.is_some()),
        ("lines", !joint.lines.is_empty()),
        ("start", joint.start.is_some()),
        ("second_axis", joint.second_axis.is_some()),
        ("pitch", joint.pitch.is_some()),
        ("coordinates", !joint.coordinates.is_empty()),
        ("spring", joint.spring.is_some()),
        ("motor", joint.motor.is_some()),
        ("driven", joint.driven.is_some()),
        ("value", joint.value.is_some()),
        ("rate", joint.rate.is_some()),
    ];
    let one = ["spring", "motor", "driven", "value", "rate"];
    let (own, acts): (&[&str], &[&str]) = match joint.kind {
        JointKind::Offset => (&["master", "place"], &[]),
        JointKind::Weld | JointKind::Spherical => (&["master"], &[]),
        JointKind::Revolute | JointKind::Prismatic => (&["master", "axis"], &one),
        JointKind::Helical => (&["master", "axis", "pitch"], &one),
        JointKind::Slide => (&["lines", "start"], &one),
        JointKind::Cylindrical => (&["master", "axis"], &["coordinates"]),
        JointKind::Universal | JointKind::ConstantVelocity | JointKind::Planar => {
            (&["master", "axis", "second_axis"], &["coordinates"])
        }
    };
    if joint.kind != JointKind::Slide && joint.master.is_none() {
        return Err(missing(source, whole, joint, "master"));
    }
    if joint.kind == JointKind::Slide && joint.lines.is_empty() {
        return Err(missing(source, whole, joint, "lines"));
    }
    for (key, given) in given {
        if given && !own.contains(&key) && !acts.contains(&key) {
            let problem = Problem::JointKey {
                joint: joint.name.clone(),
                kind: joint.kind.key(),
                key,
            };
            return Err(source.key(&path(key), problem));
        }
    }
    Ok(())
}

/// The nodes that a slide runs along, and the interpolation between them.
fn chain<'a>(
    source: &Text<'_>,
    file: &ModelFile,
    laid: &[Option<LineGeometry>],
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    joint: &Joint,
) -> Result<(Vec<NodeId>, Interpolation), InputError> {
    let mut chain: Vec<NodeId> = Vec::new();
    let mut interpolation = None;
    for (i, name) in joint.lines.iter().enumerate() {
        let index = i.to_string();
        let at = [&path("lines")[..], &[index.as_str()]].concat();
        let k = file.lines.iter().position(|l| l.name == *name);
        let line = k.and_then(|k| laid[k].as_ref()).ok_or_else(|| {
            let problem = Problem::UnknownName {
                what: "line",
                name: name.clone(),
                known: file.lines.iter().map(|l| l.name.clone()).collect(),
            };
            source.value(&at, problem)
        })?;
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

/// Spring, motor and drive of the released coordinate `name`; `at` is where they stand.
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
    if let Some(time) = &acts.driven {
        for (key, given) in [
            ("spring", acts.spring.is_some()),
            ("motor", acts.motor.is_some()),
            ("value", acts.value.is_some()),
            ("rate", acts.rate.is_some()),
        ] {
            if given {
                let joint = name.to_owned();
                return Err(source.key(&path(key), Problem::DrivenJoint { joint, key }));
            }
        }
        let driven = drive(source, &path("driven"), time)?;
        builder.prescribe_coordinate(coordinate, 0, driven);
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
    if let Some(time) = &acts.motor {
        let motor = CoordinateForce::boxed(function(source, &path("motor"), time)?);
        builder
            .element(format!("motor of {name}"), motor, &[coordinate])
            .map_err(|error| source.value(&path("motor"), Problem::Model(error)))?;
    }
    Ok(())
}
