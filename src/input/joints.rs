//! Joints of the file.

use super::assemble::{LineGeometry, Names};
use super::file::{Joint, JointKind, ModelFile};
use super::loads::{drive, function};
use super::{InputError, Problem, Text};
use pullback_elements::joint::{offset, revolute, slide, spherical};
use pullback_elements::load::CoordinateForce;
use pullback_elements::model::{ModelBuilder, ModelError, NodeId};
use pullback_elements::spring::{CoordinateLaw, CoordinateSpring};

/// The nodes of a joint.
pub(super) struct Made {
    /// The node that hangs on it.
    pub frame: NodeId,
    /// The node of its one released coordinate.
    pub released: Option<NodeId>,
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
    let made = match joint.kind {
        JointKind::Offset => {
            let place = joint.place.ok_or_else(|| missing("place"))?;
            let master = master.ok_or_else(|| missing("master"))?;
            let frame = offset(builder, &joint.name, master, place).map_err(model)?;
            Made {
                frame,
                released: None,
            }
        }
        JointKind::Revolute => {
            let axis = joint.axis.ok_or_else(|| missing("axis"))?;
            let master = master.ok_or_else(|| missing("master"))?;
            let made = revolute(builder, &joint.name, master, axis)
                .map_err(|error| source.value(&path("axis"), Problem::Model(error)))?;
            Made {
                frame: made.frame,
                released: Some(made.angle),
            }
        }
        JointKind::Spherical => {
            let master = master.ok_or_else(|| missing("master"))?;
            let frame = spherical(builder, &joint.name, master).map_err(model)?;
            Made {
                frame: frame.frame,
                released: None,
            }
        }
        JointKind::Slide => {
            let chain = chain(source, file, laid, &path, joint)?;
            let start = joint.start.unwrap_or(0.0);
            let made = slide(builder, &joint.name, &chain, start)
                .map_err(|error| source.value(&path("lines"), Problem::Model(error)))?;
            Made {
                frame: made.frame,
                released: Some(made.way),
            }
        }
    };
    if let Some(coordinate) = made.released {
        act(source, builder, &path, joint, coordinate)?;
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
        ("spring", joint.spring.is_some()),
        ("motor", joint.motor.is_some()),
        ("driven", joint.driven.is_some()),
        ("value", joint.value.is_some()),
        ("rate", joint.rate.is_some()),
    ];
    let useful: &[&str] = match joint.kind {
        JointKind::Offset => &["master", "place"],
        JointKind::Revolute => &[
            "master", "axis", "spring", "motor", "driven", "value", "rate",
        ],
        JointKind::Spherical => &["master"],
        JointKind::Slide => &[
            "lines", "start", "spring", "motor", "driven", "value", "rate",
        ],
    };
    if joint.kind != JointKind::Slide && joint.master.is_none() {
        return Err(missing(source, whole, joint, "master"));
    }
    if joint.kind == JointKind::Slide && joint.lines.is_empty() {
        return Err(missing(source, whole, joint, "lines"));
    }
    for (key, given) in given {
        if given && !useful.contains(&key) {
            let problem = Problem::JointKey {
                joint: joint.name.clone(),
                kind: joint.kind.key(),
                key,
            };
            return Err(source.key(&path(key), problem));
        }
    }
    if joint.driven.is_some() {
        for (key, given) in [
            ("spring", joint.spring.is_some()),
            ("motor", joint.motor.is_some()),
            ("value", joint.value.is_some()),
            ("rate", joint.rate.is_some()),
        ] {
            if given {
                let joint = joint.name.clone();
                return Err(source.key(&path(key), Problem::DrivenJoint { joint, key }));
            }
        }
    }
    Ok(())
}

/// The nodes that a slide runs along.
fn chain<'a>(
    source: &Text<'_>,
    file: &ModelFile,
    laid: &[Option<LineGeometry>],
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    joint: &Joint,
) -> Result<Vec<NodeId>, InputError> {
    let mut chain: Vec<NodeId> = Vec::new();
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
        if line.order != 1 || !follows {
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
    Ok(chain)
}

/// Spring, motor and drive of the released coordinate.
fn act<'a>(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    joint: &Joint,
    coordinate: NodeId,
) -> Result<(), InputError> {
    let name = &joint.name;
    if let Some(s) = joint.spring {
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
    if let Some(time) = &joint.motor {
        let motor = CoordinateForce::boxed(function(source, &path("motor"), time)?);
        builder
            .element(format!("motor of {name}"), motor, &[coordinate])
            .map_err(|error| source.value(&path("motor"), Problem::Model(error)))?;
    }
    if let Some(time) = &joint.driven {
        let driven = drive(source, &path("driven"), time)?;
        builder.prescribe_coordinate(coordinate, 0, driven);
    }
    Ok(())
}
