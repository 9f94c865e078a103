//! Initial conditions of the file as vectors of the model.

use super::assemble::{LineGeometry, Names};
use super::file::{Initial, ModelFile};
use super::{InputError, Problem, Text};
use nalgebra::Vector3;
use pullback_elements::model::{Model, NodeId, RigidMotion};
use pullback_manifold::so3;
use pullback_manifold::system::System;

/// Coordinates and velocities at the start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Start {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
}

pub(super) fn start(
    source: &Text<'_>,
    model: &mut Model,
    nodes: &Names<NodeId>,
    released: &Names<NodeId>,
    lines: &[LineGeometry],
    file: &ModelFile,
) -> Result<Start, InputError> {
    let n = model.pattern().dim();
    let (mut q, mut v) = (vec![0.0; n], vec![0.0; n]);
    for (k, initial) in file.initial.iter().enumerate() {
        let index = k.to_string();
        let whole = ["initial", index.as_str()];
        let path = |key: &'static str| ["initial", index.as_str(), key];
        check(source, &path, &whole, initial)?;
        let node = match &initial.node {
            Some(name) => Some(nodes.find(source, &path("node"), name)?),
            None => None,
        };
        if let Some(node) = node {
            hangs(source, &path, model, node, initial)?;
            place(source, &path, model, node, initial, &mut q)?;
        }
        let omega = match (initial.angular_velocity, initial.body_angular_velocity) {
            (Some(omega), _) => Vector3::from(omega),
            (None, Some(body)) => {
                let psi = initial.rotation.unwrap_or_default();
                so3::rotation(&Vector3::from(psi)) * Vector3::from(body)
            }
            (None, None) => Vector3::zeros(),
        };
        let here = node
            .map(|n| model.reference(n) + Vector3::from(initial.displacement.unwrap_or_default()));
        let motion = RigidMotion {
            velocity: initial.velocity.unwrap_or_default().into(),
            omega,
            about: initial
                .about
                .map_or_else(|| here.unwrap_or_default(), Vector3::from),
        };
        let chosen = match (&node, &initial.line) {
            (Some(node), _) => Some(vec![*node]),
            (None, None) => None,
            (None, Some(name)) => {
                let line = lines.iter().find(|l| l.name == *name).ok_or_else(|| {
                    let problem = Problem::UnknownName {
                        what: "line",
                        name: name.clone(),
                        known: lines.iter().map(|l| l.name.clone()).collect(),
                    };
                    source.value(&path("line"), problem)
                })?;
                Some(line.nodes.clone())
            }
        };
        let moves = initial.velocity.is_some()
            || initial.angular_velocity.is_some()
            || initial.body_angular_velocity.is_some();
        if moves {
            if let Some(node) = node {
                movable(source, &path, model, node, initial)?;
            }
            model.set_velocity(&q, &mut v, chosen.as_deref(), &motion);
            // Where a map cannot be evaluated at the start, the analysis says so.
            model.fit_rates(&q, &mut v, chosen.as_deref(), &motion).ok();
        }
    }
    for (k, joint) in file.joints.iter().enumerate() {
        let index = k.to_string();
        for (key, given, vector) in [("value", joint.value, &mut q), ("rate", joint.rate, &mut v)] {
            let Some(given) = given else { continue };
            let at = ["joints", index.as_str(), key];
            let coordinate = released.find(source, &at, &joint.name)?;
            model.set(vector, coordinate, 0, given);
        }
    }
    Ok(Start { q, v })
}

fn check<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    whole: &[&str],
    initial: &Initial,
) -> Result<(), InputError> {
    let place = [
        ("displacement", initial.displacement.is_some()),
        ("rotation", initial.rotation.is_some()),
        (
            "body_angular_velocity",
            initial.body_angular_velocity.is_some(),
        ),
    ];
    for (key, given) in place {
        if given && initial.node.is_none() {
            return Err(source.key(&path(key), Problem::InitialNode { key }));
        }
    }
    if initial.node.is_some() && initial.line.is_some() {
        return Err(source.key(
            &path("line"),
            Problem::InitialTwice {
                first: "node",
                second: "line",
            },
        ));
    }
    if initial.angular_velocity.is_some() && initial.body_angular_velocity.is_some() {
        let (first, second) = ("angular_velocity", "body_angular_velocity");
        return Err(source.key(&path(second), Problem::InitialTwice { first, second }));
    }
    let says = place.iter().any(|p| p.1)
        || initial.velocity.is_some()
        || initial.angular_velocity.is_some();
    if !says {
        return Err(source.value(whole, Problem::InitialNothing));
    }
    Ok(())
}

/// Refuses what a node that hangs on a joint cannot have of its own.
fn hangs<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    model: &Model,
    node: NodeId,
    initial: &Initial,
) -> Result<(), InputError> {
    let turns = model.is_own(model.free_rotation_of(node));
    for (key, given, own) in [
        ("displacement", initial.displacement, model.is_own(node)),
        ("velocity", initial.velocity, model.is_own(node)),
        ("rotation", initial.rotation, turns),
        ("angular_velocity", initial.angular_velocity, turns),
        (
            "body_angular_velocity",
            initial.body_angular_velocity,
            turns,
        ),
    ] {
        if given.is_some() && !own {
            let node = initial.node.clone().unwrap_or_default();
            return Err(source.key(&path(key), Problem::InitialHung { node, key }));
        }
    }
    Ok(())
}

/// Refuses a velocity of a node along a coordinate that is held or driven.
fn movable<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    model: &Model,
    node: NodeId,
    initial: &Initial,
) -> Result<(), InputError> {
    let velocity = initial.velocity.unwrap_or_default();
    let held = (0..3).any(|k| velocity[k] != 0.0 && model.unknown_at(node, k).is_none());
    if held && model.is_own(node) {
        let (node, key) = (initial.node.clone().unwrap_or_default(), "velocity");
        return Err(source.value(&path(key), Problem::InitialHeld { node, key }));
    }
    Ok(())
}

/// Initial displacement and rotation of a node.
fn place<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    model: &Model,
    node: NodeId,
    initial: &Initial,
    q: &mut [f64],
) -> Result<(), InputError> {
    let free = model.free_rotation_of(node);
    let first = if free == node { 3 } else { 0 };
    for (key, node, first, values) in [
        ("displacement", node, 0, initial.displacement),
        ("rotation", free, first, initial.rotation),
    ] {
        for (i, value) in values.unwrap_or_default().into_iter().enumerate() {
            if !model.set(q, node, first + i, value) && value != 0.0 {
                let node = initial.node.clone().unwrap_or_default();
                return Err(source.value(&path(key), Problem::InitialHeld { node, key }));
            }
        }
    }
    Ok(())
}
