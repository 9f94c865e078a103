//! Initial conditions of the file as vectors of the model.

use super::assemble::{LineGeometry, Names};
use super::file::{Initial, ModelFile};
use super::requests::{self, Rate, VelocityRequest};
use super::values::{self, geared, given};
use super::{InputError, Problem, Text};
use nalgebra::Vector3;
use pullback_elements::model::{Context, NodeId, RigidMotion};
use pullback_manifold::so3;
use pullback_manifold::system::{Point, System};
use std::f64::consts::TAU;

/// Tolerance of velocities, relative to the largest.
pub(super) const LEFT: f64 = 1e-9;

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
    context: &mut Context,
    nodes: &Names<NodeId>,
    released: &Names<NodeId>,
    lines: &[LineGeometry],
    file: &ModelFile,
) -> Result<Start, InputError> {
    let n = context.pattern().dim();
    let (mut q, mut v) = (context.initial().to_vec(), vec![0.0; n]);
    // All positions come before all velocities, whatever their order in the file.
    let (mut chosen, mut placed) = (Vec::new(), Vec::new());
    let known = Names::lines(file);
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
            check_attached(source, &path, context, node, initial)?;
            position(source, &path, context, node, initial, &mut q)?;
            let of = [initial.displacement.is_some(), initial.rotation.is_some()];
            placed.extend(requests::unknowns(context, node, of));
        }
        let line = match &initial.line {
            Some(name) => {
                let line = known.find(source, &path("line"), name)?;
                Some(lines[line].nodes.clone())
            }
            None => node.map(|node| vec![node]),
        };
        chosen.push((node, line));
    }
    values::start(source, context, released, lines, file, &mut q, &placed)?;
    // Rates prescribed in loops, their names, and the path of the first.
    let (mut spins, mut names, mut first) = (Vec::new(), Vec::new(), None);
    // Velocities prescribed in loops that multipliers and penalties close.
    let mut requests: Vec<VelocityRequest> = Vec::new();
    let whole = |path: &[&str]| {
        path.iter()
            .map(|p| (*p).to_owned())
            .collect::<Vec<String>>()
    };
    // Rates of joints take precedence over the motion of the whole model.
    let chosen_rates = file
        .joints
        .iter()
        .any(|j| j.all_acts().any(|(_, a)| a.rate.is_some()));
    for (k, (initial, (node, chosen))) in file.initial.iter().zip(chosen).enumerate() {
        let index = k.to_string();
        let path = |key: &'static str| ["initial", index.as_str(), key];
        let moves = initial.velocity.is_some()
            || initial.angular_velocity.is_some()
            || initial.body_angular_velocity.is_some();
        if !moves {
            continue;
        }
        let here = node.map(|node| at(context, node, &q));
        let omega = match (initial.angular_velocity, initial.body_angular_velocity) {
            (Some(omega), _) => Vector3::from(omega),
            (None, Some(body)) => {
                let psi = here.map_or_else(Vector3::zeros, |[_, psi]| psi);
                so3::rotation(&psi) * Vector3::from(body)
            }
            (None, None) => Vector3::zeros(),
        };
        let motion = RigidMotion {
            velocity: initial.velocity.unwrap_or_default().into(),
            omega,
            about: match (initial.about, here) {
                (Some(about), _) => about.into(),
                (None, Some([position, _])) => position,
                (None, None) => Vector3::zeros(),
            },
        };
        if let Some(free) = node
            .map(|n| context.free_rotation_of(n))
            .filter(|&n| context.in_loop(n))
        {
            // The rotation of a spherical joint in a loop.
            let a = vec![0.0; v.len()];
            let at = Point {
                t: 0.0,
                q: &q,
                v: &v,
                a: &a,
            };
            let psi = match context.configure(at) {
                Ok(()) => {
                    Vector3::from_fn(|k, _| context.coordinate(free, k).map_or(0.0, |x| x[0]))
                }
                // The analysis reports the error.
                Err(_) => Vector3::zeros(),
            };
            let rate = so3::tangent_inverse(&psi).tr_mul(&motion.omega);
            spins.extend((0..3).map(|k| (free, k, rate[k])));
            names.push(initial.node.clone().unwrap_or_default());
            first.get_or_insert(whole(&["initial", &index]));
            continue;
        }
        let turns = initial.angular_velocity.or(initial.body_angular_velocity);
        let of = [
            initial.velocity.is_some() || initial.about.is_some(),
            turns.is_some(),
        ];
        // Components that the entry does not prescribe stay.
        let others = node.map(|node| requests::unknowns(context, node, of.map(|of| !of)));
        let others = others.into_iter().flatten();
        let kept: Vec<(usize, f64)> = others.map(|u| (u, v[u])).collect();
        context.set_velocity(&q, &mut v, chosen.as_deref(), &motion);
        kept.into_iter().for_each(|(u, rate)| v[u] = rate);
        if let Some(node) = node {
            movable(source, &path, context, node, initial, &q, &motion)?;
            requests.push(VelocityRequest::of_node(k, context, node, of));
        }
        // Where a map cannot be evaluated at the start, the analysis says so.
        let fitted = context.fit_rates(&q, &mut v, chosen.as_deref(), &motion);
        let against = fitted.unwrap_or_default();
        if node.is_none() {
            requests.push(VelocityRequest::of_nodes(k, context, chosen.as_deref()));
        }
        if let (Some(joint), false) = (against.first(), chosen_rates) {
            let joint = joint.clone();
            return Err(source.value(&["initial", &index], Problem::LoopMotion { joint }));
        }
    }
    let mut rates = spins;
    let mut held: Vec<Rate> = Vec::new();
    for (index, name, rate) in given(file, |acts| acts.rate) {
        let at = ["joints", index.as_str(), "rate"];
        let node = released.find(source, &at, &name)?;
        if let Some(u) = context.unknown_at(node, 0) {
            v[u] = rate;
            held.push(Rate {
                u,
                of: name.clone(),
                at: whole(&at),
                given: rate,
            });
        } else if !context.in_loop(node) {
            geared(source, &at, file, &name, "rate")?;
        }
        if !context.is_own(node) {
            rates.push((node, 0, rate));
            names.push(name);
            first.get_or_insert(whole(&at));
        }
    }
    if !rates.is_empty() {
        let most = rates.iter().fold(0.0_f64, |m, r| m.max(r.2.abs()));
        // Where a map cannot be evaluated at the start, the analysis says so.
        let left = context
            .fit_coordinate_rates(&q, &mut v, &rates)
            .unwrap_or(0.0);
        if left > LEFT * most {
            let path = first.unwrap_or_default();
            let path: Vec<&str> = path.iter().map(String::as_str).collect();
            // A single component of a spherical joint may be free.
            let problem = match (names.as_slice(), rates.len()) {
                ([one], 1) => Problem::LoopLocked { of: one.clone() },
                (all, _) => Problem::LoopRates {
                    of: all.join(", "),
                    left,
                },
            };
            return Err(source.value(&path, problem));
        }
    }
    let start = Start { q, v };
    requests::satisfy(source, context, file, start, &held, &placed, requests)
}

fn check<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    whole: &[&str],
    initial: &Initial,
) -> Result<(), InputError> {
    let position = [
        ("displacement", initial.displacement.is_some()),
        ("rotation", initial.rotation.is_some()),
        (
            "body_angular_velocity",
            initial.body_angular_velocity.is_some(),
        ),
    ];
    for (key, given) in position {
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
    let says = position.iter().any(|p| p.1)
        || initial.velocity.is_some()
        || initial.angular_velocity.is_some();
    if !says {
        return Err(source.value(whole, Problem::InitialNothing));
    }
    Ok(())
}

/// Refuses coordinates that a node attached to a joint does not have.
fn check_attached<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    context: &Context,
    node: NodeId,
    initial: &Initial,
) -> Result<(), InputError> {
    let rotation = context.free_rotation_of(node);
    let turns = context.is_own(rotation);
    let spins = turns || context.in_loop(rotation);
    for (key, given, own) in [
        ("displacement", initial.displacement, context.is_own(node)),
        ("velocity", initial.velocity, context.is_own(node)),
        ("rotation", initial.rotation, turns),
        ("angular_velocity", initial.angular_velocity, spins),
        (
            "body_angular_velocity",
            initial.body_angular_velocity,
            spins,
        ),
    ] {
        if given.is_some() && !own {
            let node = initial.node.clone().unwrap_or_default();
            return Err(source.key(&path(key), Problem::InitialHung { node, key }));
        }
    }
    Ok(())
}

/// Position and rotation vector of a node at coordinates.
fn at(context: &Context, node: NodeId, q: &[f64]) -> [Vector3<f64>; 2] {
    let free = context.free_rotation_of(node);
    let first = if free == node { 3 } else { 0 };
    let three = |node: NodeId, first: usize| {
        Vector3::from_fn(|k, _| context.unknown_at(node, first + k).map_or(0.0, |u| q[u]))
    };
    [context.reference(node) + three(node, 0), three(free, first)]
}

/// Refuses a velocity of a node along a coordinate that is held or prescribed.
fn movable<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    context: &Context,
    node: NodeId,
    initial: &Initial,
    q: &[f64],
    motion: &RigidMotion,
) -> Result<(), InputError> {
    let free = context.free_rotation_of(node);
    let first = if free == node { 3 } else { 0 };
    let [_, psi] = at(context, node, q);
    let rate = so3::tangent_inverse(&psi).tr_mul(&motion.omega);
    let spin = if initial.angular_velocity.is_some() {
        "angular_velocity"
    } else {
        "body_angular_velocity"
    };
    for (key, node, first, wanted) in [
        ("velocity", node, 0, motion.velocity),
        (spin, free, first, rate),
    ] {
        let tiny = 1e-12 * wanted.amax();
        let held =
            (0..3).any(|k| wanted[k].abs() > tiny && context.unknown_at(node, first + k).is_none());
        if held && context.is_own(node) {
            let node = initial.node.clone().unwrap_or_default();
            return Err(source.value(&path(key), Problem::InitialHeld { node, key }));
        }
    }
    Ok(())
}

/// The rotation vector of the same rotation with an angle of at most π.
fn folded(psi: [f64; 3]) -> [f64; 3] {
    let psi = Vector3::from(psi);
    let angle = psi.norm();
    let turns = (angle / TAU).round();
    if turns == 0.0 || !angle.is_finite() {
        psi.into()
    } else {
        (psi * (1.0 - turns * TAU / angle)).into()
    }
}

/// Initial displacement and rotation of a node.
fn position<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    context: &Context,
    node: NodeId,
    initial: &Initial,
    q: &mut [f64],
) -> Result<(), InputError> {
    let free = context.free_rotation_of(node);
    let first = if free == node { 3 } else { 0 };
    for (key, node, first, values) in [
        ("displacement", node, 0, initial.displacement),
        ("rotation", free, first, initial.rotation.map(folded)),
    ] {
        for (i, value) in values.unwrap_or_default().into_iter().enumerate() {
            if !context.set(q, node, first + i, value) && value != 0.0 {
                let node = initial.node.clone().unwrap_or_default();
                return Err(source.value(&path(key), Problem::InitialHeld { node, key }));
            }
        }
    }
    Ok(())
}
