//! Initial velocities: motions of the file, rates of joints, and what follows from them.

use super::requests::{self, Rate, VelocityRequest, contradiction};
use super::values::{geared, given};
use super::{Entry, Start, VELOCITY_TOLERANCE};
use crate::input::file::Initial;
use crate::input::parts::Assembly;
use crate::input::{InputError, InputProblem, Location};
use nalgebra::{Matrix3, Vector3};
use pullback_elements::model::{Context, NodeId, RigidMotion};
use pullback_manifold::so3;
use pullback_manifold::system::{Point, System};

/// Initial velocities under construction.
pub(super) struct Velocities<'a> {
    pub start: Start,
    /// Rates of joints, and velocities of nodes on them.
    pub rates: Vec<Rate<'a>>,
    /// The unknowns that these determine.
    pub determined_unknowns: Vec<usize>,
    /// Velocities prescribed in loops that multipliers and penalties close.
    pub requests: Vec<VelocityRequest<'a>>,
}

impl<'a> Velocities<'a> {
    /// The velocities of all entries at initial coordinates; `None` where a map cannot be evaluated, which the analysis reports.
    pub fn at(
        q: &[f64],
        assembly: &Assembly<'a>,
        context: &mut Context,
        entries: &[Entry<'a>],
    ) -> Result<Option<Self>, InputError> {
        let (q, v) = (q.to_vec(), vec![0.0; q.len()]);
        if (context.configure(Point {
            t: 0.0,
            q: &q,
            v: &v,
            a: &v,
        }))
        .is_err()
        {
            return Ok(None);
        }
        let mut all = Self {
            start: Start {
                q,
                v,
                ..Start::default()
            },
            rates: Vec::new(),
            determined_unknowns: Vec::new(),
            requests: Vec::new(),
        };
        let mut joints = assembly.file.joints.iter();
        let chosen_rates = joints.any(|j| j.acts_any(|a| a.rate.is_some()));
        // Rates of joints take precedence over the motion of the whole model; what is free behind them follows that again.
        for again in [false, true] {
            all.rates.clear();
            all.requests.clear();
            for entry in entries {
                let against = all.set_motion(context, entry)?;
                if let (Some(joint), false) = (against, chosen_rates || again) {
                    return Err(entry.at.refuse(InputProblem::LoopMotion { joint }));
                }
            }
            all.set_rates(assembly, context)?;
            all.determined_unknowns = all.fit_loops(context)?;
            if all.determined_unknowns.is_empty() {
                break;
            }
        }
        Ok(Some(all))
    }

    /// Sets the motion of an entry, which overwrites those of earlier ones. Returns a joint of a loop that does not allow it.
    fn set_motion(
        &mut self,
        context: &mut Context,
        entry: &Entry<'a>,
    ) -> Result<Option<String>, InputError> {
        let (initial, node, chosen) = (entry.initial, entry.node, entry.line_nodes.as_deref());
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
        let Start { q, v, .. } = &mut self.start;
        // Components that the entry does not prescribe stay.
        let others = node.map(|node| requests::unknowns(context, node, of.map(|of| !of)));
        let others = others
            .into_iter()
            .flatten()
            .chain(self.determined_unknowns.iter().copied());
        let kept: Vec<(usize, f64)> = others.map(|u| (u, v[u])).collect();
        context.set_velocity(q, v, chosen, &motion);
        kept.into_iter().for_each(|(u, rate)| v[u] = rate);
        self.requests.push(VelocityRequest {
            at: entry.at.clone(),
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
            let fitted = context.fit_rates(q, v, chosen, &motion, &self.determined_unknowns);
            return Ok(fitted.unwrap_or_default().into_iter().next());
        };
        // Its velocities are its own, and joints stay as they were.
        movable(&entry.at, context, node, initial, &motion).map(|()| None)
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
                rate: wanted[k],
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
                    rate: given,
                });
            }
        }
        Ok(())
    }

    /// Fits velocities to the rates in loops that maps close and to those of nodes on joints; returns the unknowns that all rates
    /// determine.
    fn fit_loops(&mut self, context: &mut Context) -> Result<Vec<usize>, InputError> {
        let rates: Vec<&Rate<'_>> = self.rates.iter().filter(|r| r.u.is_none()).collect();
        let mut given: Vec<usize> = self.rates.iter().filter_map(|r| r.u).collect();
        let Some(first) = rates.first() else {
            return Ok(given);
        };
        let Start { q, v, .. } = &mut self.start;
        let wanted: Vec<_> = rates.iter().map(|r| (r.node, r.k, r.rate)).collect();
        // Where a map cannot be evaluated at the start, the analysis says so.
        let fitted = context.fit_coordinate_rates(q, v, &wanted, &given);
        let (missing, unknowns) = fitted.unwrap_or_default();
        let size = |k: &usize| missing.get(*k).map_or(0.0, |x: &f64| x.abs());
        let worst = (0..rates.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
        let (worst, left) = worst.map_or((*first, 0.0), |k| (rates[k], size(&k)));
        if left <= VELOCITY_TOLERANCE {
            given.extend(unknowns);
            return Ok(given);
        }
        Err(match (worst.key, &rates[..]) {
            // A single component of a spherical joint may be free.
            ("rate", [one]) => (first.at).refuse(InputProblem::LoopLocked { of: one.of.clone() }),
            ("rate", _) => first.at.refuse(contradiction(&rates, left)),
            (key, _) => worst.at.refuse(InputProblem::InitialHeld {
                node: worst.of.clone(),
                key,
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
