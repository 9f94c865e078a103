//! Initial conditions of the file as vectors of the model.

mod requests;
mod values;

use super::file::Initial;
use super::parts::Assembly;
use super::{InputError, InputProblem, Location};
use nalgebra::{Matrix3, Vector3};
use pullback_elements::model::{Context, NodeId, RigidMotion};
use pullback_integrators::dynamics::{self as integrator, DynamicsError, Progress};
use pullback_manifold::so3;
use pullback_manifold::system::{Point, System};
use requests::{Rate, VelocityRequest, names};
use std::f64::consts::TAU;
use values::{geared, given};

/// Tolerance of velocities, relative to the largest.
const VELOCITY_TOLERANCE: f64 = 1e-9;

/// Coordinates and velocities at the start.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Start {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
}

impl Start {
    /// The beginning of a motion from here.
    pub(crate) fn motion(&self, context: &Context) -> Result<Progress, DynamicsError> {
        integrator::start(context, 0.0, &self.q, &self.v).map(Progress::new)
    }
}

pub(super) fn start(assembly: &Assembly<'_>, context: &mut Context) -> Result<Start, InputError> {
    let file = assembly.file;
    let mut q = context.initial().to_vec();
    // All positions come before all velocities, whatever their order in the file.
    let (mut entries, mut placed) = (Vec::new(), Vec::new());
    for (k, initial) in file.initial.iter().enumerate() {
        let at = assembly.at("initial").at(k);
        check(&at, initial)?;
        let node = match &initial.node {
            Some(name) => Some(assembly.nodes.find(&at.at("node"), name)?),
            None => None,
        };
        if let Some(node) = node {
            check_attached(&at, context, node, initial)?;
            position(&at, context, node, initial, &mut q)?;
            let of = [initial.displacement.is_some(), initial.rotation.is_some()];
            placed.extend(requests::unknowns(context, node, of));
        }
        let chosen = match &initial.line {
            Some(name) => {
                let line = assembly.lines.find(&at.at("line"), name)?;
                Some(assembly.geometry.lines[line].nodes.clone())
            }
            None => node.map(|node| vec![node]),
        };
        entries.push(Entry {
            at,
            initial,
            node,
            chosen,
        });
    }
    values::start(assembly, context, &mut q, &placed)?;
    let mut velocities = Velocities {
        start: Start {
            v: vec![0.0; q.len()],
            q,
        },
        rates: Vec::new(),
        requests: Vec::new(),
    };
    // Rates of joints take precedence over the motion of the whole model.
    let mut acts = file.joints.iter().flat_map(|j| j.all_acts());
    let chosen_rates = acts.any(|(_, a)| a.rate.is_some());
    let Start { q, v } = &velocities.start;
    if context.configure(Point { t: 0.0, q, v, a: v }).is_err() {
        // The analysis says why.
        return Ok(velocities.start);
    }
    for entry in &entries {
        let against = velocities.set_motion(context, entry)?;
        if let (Some(joint), false) = (against, chosen_rates) {
            return Err(entry.at.refuse(InputProblem::LoopMotion { joint }));
        }
    }
    velocities.set_rates(assembly, context)?;
    let held = velocities.fit_loops(context)?;
    requests::project(assembly, context, velocities, held, &placed)
}

/// An entry of `[[initial]]`: of a node, of chosen nodes, or of all.
struct Entry<'a> {
    at: Location<'a>,
    initial: &'a Initial,
    node: Option<NodeId>,
    chosen: Option<Vec<NodeId>>,
}

/// Initial velocities under construction.
struct Velocities<'a> {
    start: Start,
    /// Rates of joints.
    rates: Vec<Rate<'a>>,
    /// Velocities prescribed in loops that multipliers and penalties close.
    requests: Vec<VelocityRequest<'a>>,
}

impl<'a> Velocities<'a> {
    /// Sets the motion of an entry, which overwrites those of earlier ones. Returns a joint of a loop that does not allow it.
    fn set_motion(
        &mut self,
        context: &mut Context,
        entry: &Entry<'a>,
    ) -> Result<Option<String>, InputError> {
        let &Entry {
            ref at,
            initial,
            node,
            ..
        } = entry;
        let chosen = entry.chosen.as_deref();
        let turns = initial.angular_velocity.or(initial.body_angular_velocity);
        if initial.velocity.is_none() && turns.is_none() {
            return Ok(None);
        }
        let motion = motion(context, initial, node);
        let of = [
            initial.velocity.is_some() || initial.about.is_some(),
            turns.is_some(),
        ];
        self.rates.retain(|rate| {
            let other = chosen.is_some_and(|nodes| !nodes.contains(&rate.node));
            other || (node.is_some() && !of[rate.k / 3])
        });
        if let Some(node) = node.filter(|&node| !context.is_own(node)) {
            self.set_attached(context, node, (&motion, of), entry);
            return Ok(None);
        }
        let Start { q, v } = &mut self.start;
        // Components that the entry does not prescribe stay.
        let others = node.map(|node| requests::unknowns(context, node, of.map(|of| !of)));
        let others = others.into_iter().flatten();
        let kept: Vec<(usize, f64)> = others.map(|u| (u, v[u])).collect();
        context.set_velocity(q, v, chosen, &motion);
        kept.into_iter().for_each(|(u, rate)| v[u] = rate);
        self.requests.push(VelocityRequest {
            at: at.clone(),
            unknowns: match (node, chosen) {
                (Some(node), _) => requests::unknowns(context, node, of).collect(),
                (None, Some(nodes)) => context.unknowns_behind(nodes),
                (None, None) => (0..context.initial().len())
                    .filter(|&u| !context.pattern().coordinates()[u].is_multiplier)
                    .collect(),
            },
            of_node: node.is_some(),
        });
        let Some(node) = node else {
            // Where a map cannot be evaluated at the start, the analysis says so.
            let fitted = context.fit_rates(q, v, chosen, &motion);
            return Ok(fitted.unwrap_or_default().into_iter().next());
        };
        // Its velocities are its own, and joints stay as they were.
        movable(at, context, node, initial, &motion).map(|()| None)
    }

    /// The velocity and angular velocity, as far as they are given, of a node that is attached to a joint.
    fn set_attached(
        &mut self,
        context: &Context,
        node: NodeId,
        (motion, of): (&RigidMotion, [bool; 2]),
        entry: &Entry<'a>,
    ) {
        let arm = context.node_state(node).position - motion.about;
        let velocity = motion.velocity + motion.omega.cross(&arm);
        let both = [("velocity", velocity), (spin(entry.initial), motion.omega)];
        for (n, (key, wanted)) in both.into_iter().enumerate().filter(|(n, _)| of[*n]) {
            self.rates.extend((0..3).map(|k| Rate {
                node,
                k: 3 * n + k,
                u: None,
                of: entry.initial.node.clone().unwrap_or_default(),
                key,
                at: entry.at.at(key),
                given: wanted[k],
            }));
        }
    }

    /// Sets the rates of joint coordinates that are unknowns, and notes those in loops.
    fn set_rates(&mut self, assembly: &Assembly<'a>, context: &Context) -> Result<(), InputError> {
        for (joint, of, given) in given(assembly.file, |acts| acts.rate) {
            let at = assembly.at("joints").at(joint).at("rate");
            let node = assembly.joint_coordinates.find(&at, &of)?;
            let u = context.unknown_at(node, 0);
            match u {
                Some(u) => self.start.v[u] = given,
                None if !context.in_loop(node) => geared(&at, assembly.file, &of, "rate")?,
                None => {}
            }
            if u.is_some() || !context.is_own(node) {
                self.rates.push(Rate {
                    node,
                    k: 0,
                    u,
                    of,
                    key: "rate",
                    at,
                    given,
                });
            }
        }
        Ok(())
    }

    /// Fits the velocities of loops that maps close to the rates in them; returns the unknowns that these determine.
    fn fit_loops(&mut self, context: &mut Context) -> Result<Vec<usize>, InputError> {
        let rates: Vec<&Rate<'_>> = self.rates.iter().filter(|r| r.u.is_none()).collect();
        let Some(first) = rates.first() else {
            return Ok(Vec::new());
        };
        let given: Vec<usize> = self.rates.iter().filter_map(|r| r.u).collect();
        let Start { q, v } = &mut self.start;
        let wanted: Vec<_> = rates.iter().map(|r| (r.node, r.k, r.given)).collect();
        // Where a map cannot be evaluated at the start, the analysis says so.
        let fitted = context.fit_coordinate_rates(q, v, &wanted, &given);
        let (missing, unknowns) = fitted.unwrap_or_default();
        let left = missing.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if left <= VELOCITY_TOLERANCE {
            return Ok(unknowns);
        }
        let of_node = rates.iter().find(|rate| rate.key != "rate");
        Err(match (of_node, &rates[..]) {
            (Some(rate), _) => rate.at.refuse(InputProblem::InitialHeld {
                node: rate.of.clone(),
                key: rate.key,
            }),
            // A single component of a spherical joint may be free.
            (None, [one]) => (first.at).refuse(InputProblem::LoopLocked { of: one.of.clone() }),
            _ => first.at.refuse(InputProblem::LoopRates {
                of: names(rates.iter().copied()),
                left: left * rates.iter().fold(0.0_f64, |m, r| m.max(r.given.abs())),
            }),
        })
    }
}

/// The rigid motion of an entry, of a node in the configuration set.
fn motion(context: &Context, initial: &Initial, node: Option<NodeId>) -> RigidMotion {
    let here = node.map(|node| context.node_state(node));
    RigidMotion {
        velocity: initial.velocity.unwrap_or_default().into(),
        omega: match (initial.angular_velocity, initial.body_angular_velocity) {
            (Some(omega), _) => Vector3::from(omega),
            (None, Some(body)) => {
                here.map_or_else(Matrix3::identity, |here| here.R) * Vector3::from(body)
            }
            (None, None) => Vector3::zeros(),
        },
        about: match (initial.about, here) {
            (Some(about), _) => about.into(),
            (None, Some(here)) => here.position,
            (None, None) => Vector3::zeros(),
        },
    }
}

fn check(at: &Location<'_>, initial: &Initial) -> Result<(), InputError> {
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
            return Err((at.at(key)).refuse_key(InputProblem::InitialNode { key }));
        }
    }
    if initial.node.is_some() && initial.line.is_some() {
        let (first, second) = ("node", "line");
        return Err((at.at(second)).refuse_key(InputProblem::InitialTwice { first, second }));
    }
    if initial.angular_velocity.is_some() && initial.body_angular_velocity.is_some() {
        let (first, second) = ("angular_velocity", "body_angular_velocity");
        return Err((at.at(second)).refuse_key(InputProblem::InitialTwice { first, second }));
    }
    let says = position.iter().any(|p| p.1)
        || initial.velocity.is_some()
        || initial.angular_velocity.is_some();
    if !says {
        return Err(at.refuse(InputProblem::InitialNothing));
    }
    Ok(())
}

/// Refuses coordinates that a node attached to a joint does not have.
fn check_attached(
    at: &Location<'_>,
    context: &Context,
    node: NodeId,
    initial: &Initial,
) -> Result<(), InputError> {
    let turns = context.is_own(context.free_rotation_of(node));
    for (key, given, own) in [
        ("displacement", initial.displacement, context.is_own(node)),
        ("rotation", initial.rotation, turns),
    ] {
        if given.is_some() && !own {
            let node = initial.node.clone().unwrap_or_default();
            return Err((at.at(key)).refuse_key(InputProblem::InitialAttached { node, key }));
        }
    }
    Ok(())
}

/// The key of the angular velocity of an entry.
fn spin(initial: &Initial) -> &'static str {
    match initial.body_angular_velocity {
        Some(_) => "body_angular_velocity",
        None => "angular_velocity",
    }
}

/// Refuses a velocity of a node along a coordinate that is held or prescribed.
fn movable(
    at: &Location<'_>,
    context: &Context,
    node: NodeId,
    initial: &Initial,
    motion: &RigidMotion,
) -> Result<(), InputError> {
    let psi = context.node_state(node).psi;
    let rate = so3::tangent_inverse(&psi).tr_mul(&motion.omega);
    let both = [("velocity", 0, motion.velocity), (spin(initial), 3, rate)];
    for (key, first, wanted) in both {
        let tiny = 1e-12 * wanted.amax();
        let held =
            (0..3).any(|k| wanted[k].abs() > tiny && context.unknown_at(node, first + k).is_none());
        if held {
            let node = initial.node.clone().unwrap_or_default();
            return Err((at.at(key)).refuse(InputProblem::InitialHeld { node, key }));
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
fn position(
    at: &Location<'_>,
    context: &Context,
    node: NodeId,
    initial: &Initial,
    q: &mut [f64],
) -> Result<(), InputError> {
    let (free, first) = requests::rotation(context, node);
    for (key, node, first, values) in [
        ("displacement", node, 0, initial.displacement),
        ("rotation", free, first, initial.rotation.map(folded)),
    ] {
        for (i, value) in values.unwrap_or_default().into_iter().enumerate() {
            if !context.set(q, node, first + i, value) && value != 0.0 {
                let node = initial.node.clone().unwrap_or_default();
                return Err((at.at(key)).refuse(InputProblem::InitialHeld { node, key }));
            }
        }
    }
    Ok(())
}
