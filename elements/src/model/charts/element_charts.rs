//! The common chart of the nodes of each element, followed from state to state.
//!
//! A rotation is two unit quaternions, ±; a rotation vector is one of them. An element needs to
//! know which of its nodes' vectors belong together: nodes at 3.1 e and −3.1 e are almost the same
//! rotation, or almost two turns apart. The history of the nodes decides: within a step vectors
//! move continuously, and a change of chart at its end keeps the rotation and may change the sign
//! of the quaternion.

use crate::model::state::ElementState;
use crate::model::{Context, ElementEntry, NodeForm};
use nalgebra::Vector3;
use pullback_manifold::so3;
use pullback_manifold::system::Point;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Gain in angle (rad) that makes an element change its chart (hysteresis): an element on the
/// border does not oscillate.
const HYSTERESIS: f64 = 1e-6;

/// Difference of rotation vectors (rad), beyond round-off, below which a state is an accepted one:
/// by continuity the elements' charts are valid there.
const SAME: f64 = 1e-6;

/// An accepted state.
#[derive(Clone, Debug, Default)]
pub(in crate::model) struct Accepted {
    t: f64,
    /// Rotation vectors of all nodes, zero for those without one.
    psi: Vec<Vector3<f64>>,
    /// Nodes that the elements evaluate through the complement map.
    switched: Vec<u32>,
}

impl Accepted {
    fn is(&self, psi: &[Vector3<f64>]) -> bool {
        let mut pairs = self.psi.iter().zip(psi);
        !self.switched.is_empty() && pairs.all(|(a, b)| (a - b).amax() < SAME)
    }

    /// Whether a node that an element reads through its complement has passed zero since: the complement is then on
    /// another branch, two turns away.
    pub(in crate::model) fn passed_zero(
        &self,
        e: &ElementEntry,
        switched: u32,
        rotation: impl Fn(usize) -> Vector3<f64>,
    ) -> bool {
        let mut nodes = e.nodes.iter().map(|&n| n as usize).enumerate();
        switched != 0
            && nodes.any(|(k, n)| {
                let last = self.psi.get(n).filter(|_| switched & (1 << k) != 0);
                last.is_some_and(|psi| psi.dot(&rotation(n)) <= 0.0)
            })
    }

    fn switched(&mut self, elements: &[ElementState]) {
        self.switched.clear();
        self.switched.extend(elements.iter().map(|e| e.wanted));
    }
}

/// State for the choice of the elements' charts.
#[derive(Clone, Debug, Default)]
pub(in crate::model) struct ElementCharts {
    /// Rotation vectors of all nodes at the end of a step, before and after changes of chart.
    before: Vec<Vector3<f64>>,
    after: Vec<Vector3<f64>>,
    /// The last accepted state, and the one before it at another time.
    pub(in crate::model) now: Accepted,
    previous: Accepted,
    /// Whether the elements' charts were set for the next state.
    set_for_next: bool,
    /// Whether elements have not yet entered the charts chosen for them.
    change_pending: bool,
    /// Angle beyond half a turn at which charts change, in radians.
    extra_angle: f64,
}

impl Context {
    /// Keeps the charts of free rotations, and those of elements, until a rotation vector is
    /// `angle` long (radians; limited to the range from π, the default, to 7π/4: charts end at 2π).
    /// A comparison shows the effect of changes of chart on a motion.
    pub fn keep_charts_until(&mut self, angle: f64) {
        self.state.element_charts.extra_angle = angle.clamp(PI, 1.75 * PI) - PI;
    }

    /// Whether the chart of a rotation vector must change.
    pub(in crate::model) fn is_beyond(&self, psi: &Vector3<f64>) -> bool {
        psi.norm() > PI + self.state.element_charts.extra_angle
    }

    /// Sets the charts of the elements for the next state; surplus entries are ignored.
    pub(in crate::model) fn set_element_charts(&mut self, charts: &[u32]) {
        for (e, &switched) in self.state.elements.iter_mut().zip(charts) {
            (e.switched, e.wanted) = (switched, switched);
        }
        self.state.element_charts.set_for_next = true;
    }

    /// Starts a run, or restarts after a failed step. The elements' charts are those that were set,
    /// or those of this state when it was accepted, or else those in which neighbours agree: nodes
    /// are then less than half a turn apart.
    pub(in crate::model) fn start_element_charts(&mut self, t: f64, q: &[f64]) {
        self.fold_prescribed_rotations(t);
        // A joint outside its domain is reported by the next evaluation.
        if self.expand(Point::statics(t, q)).is_err() {
            return;
        }
        self.gather_rotations(|s| &mut s.after);
        let ElementCharts {
            after,
            now,
            previous,
            set_for_next,
            ..
        } = &mut self.state.element_charts;
        if !*set_for_next && !now.is(after) && previous.is(after) {
            std::mem::swap(now, previous);
        }
        let known = now.is(after);
        let elements = self.model.elements.iter().zip(&mut self.state.elements);
        for (k, (e, state)) in elements.enumerate() {
            state.overturned = false;
            match (*set_for_next, known) {
                (true, _) => {}
                (false, true) => state.switched = now.switched[k],
                (false, false) => state.switched = agreement(e, after),
            }
            state.wanted = state.switched;
        }
        *set_for_next = false;
        now.t = t;
        now.psi.clone_from(after);
        now.switched(&self.state.elements);
    }

    /// Records all rotation vectors at the end of a step, before charts change; false if that is
    /// not possible.
    pub(in crate::model) fn look_before(&mut self, at: Point<'_>) -> bool {
        let fine = self.expand(at).is_ok();
        if fine {
            self.gather_rotations(|s| &mut s.before);
        }
        fine
    }

    /// Each element evaluates its nodes in one common chart: the one with the smallest largest
    /// rotation angle. Nodes stored in the other chart are mapped by the complement. The choice
    /// does not depend on how the nodes are stored, and follows them continuously. Returns whether
    /// an element changes its chart.
    ///
    /// An element whose interpolation depends on its chart is out of balance in another one: forces
    /// at the accepted state are evaluated in the charts in which it was balanced, and the new
    /// charts are entered at the next state ([`Context::enter_element_charts`]).
    ///
    /// The configuration is the last one expanded.
    pub(in crate::model) fn follow_element_charts(&mut self, t: f64) -> bool {
        self.enter_element_charts();
        self.gather_rotations(|s| &mut s.after);
        let ElementCharts {
            before,
            after,
            now,
            previous,
            extra_angle,
            ..
        } = &mut self.state.element_charts;
        // If one angle is beyond π by this much, the other is below by as much.
        let gain = 2.0 * *extra_angle + HYSTERESIS;
        let mut changed = false;
        // A single frame has no neighbours.
        for (e, state) in self.model.elements.iter().zip(&mut self.state.elements) {
            if e.frames.count_ones() < 2 {
                continue;
            }
            let mut nodes = e.nodes.iter().map(|&n| n as usize);
            // Below a right angle all quaternions are within 45° of (1, 0): they agree.
            let small = |n: usize| {
                let limit = FRAC_PI_2 * FRAC_PI_2;
                before[n].norm_squared() < limit && after[n].norm_squared() < limit
            };
            if state.switched == 0 && nodes.all(small) {
                continue;
            }
            let possible = possible(e, state.switched, before);
            let passed = now.passed_zero(e, state.switched, |n| before[n]);
            if passed || possible == [false; 2] {
                state.overturned = true;
                changed = true;
                continue;
            }
            let seen = state.switched ^ flipped(e, before, after);
            let wanted = best(e, seen, after, possible, gain);
            changed |= wanted != seen;
            (state.switched, state.wanted) = (seen, wanted);
        }
        if now.t != t {
            std::mem::swap(now, previous);
            now.t = t;
        }
        now.psi.clone_from(after);
        now.switched(&self.state.elements);
        self.state.element_charts.change_pending = changed;
        changed
    }

    /// Makes the elements enter their new charts.
    pub(in crate::model) fn enter_element_charts(&mut self) {
        if std::mem::take(&mut self.state.element_charts.change_pending) {
            let elements = self.state.elements.iter_mut();
            elements.for_each(|e| e.switched = e.wanted);
        }
    }

    fn gather_rotations(&mut self, to: impl Fn(&mut ElementCharts) -> &mut Vec<Vector3<f64>>) {
        let w = &self.work;
        let to = to(&mut self.state.element_charts);
        to.clear();
        to.extend(self.model.nodes.iter().map(|n| match n.form {
            NodeForm::Frame => Vector3::from_column_slice(&w.x[n.first + 3..n.first + 6]),
            _ => Vector3::zeros(),
        }));
    }
}

/// The element's frames: their bit and their rotation vector.
fn frames<'a>(
    e: &'a ElementEntry,
    psi: &'a [Vector3<f64>],
) -> impl Iterator<Item = (u32, &'a Vector3<f64>)> + Clone {
    let bits = e.nodes.iter().enumerate();
    bits.filter(|(k, _)| e.frames & (1 << k) != 0)
        .map(|(k, &n)| (1 << k, &psi[n as usize]))
}

/// The nodes whose quaternions have a negative product with the first one.
fn opposite(e: &ElementEntry, psi: &[Vector3<f64>]) -> u32 {
    let mut quaternions = frames(e, psi).map(|(bit, psi)| (bit, so3::quaternion(psi)));
    let Some((_, first)) = quaternions.next() else {
        return 0;
    };
    let other = |(bit, q): (u32, so3::Quaternion<f64>)| if first.dot(&q) < 0.0 { bit } else { 0 };
    quaternions.map(other).sum()
}

/// The choice by the present rotations alone.
fn agreement(e: &ElementEntry, psi: &[Vector3<f64>]) -> u32 {
    best(e, opposite(e, psi), psi, [true; 2], HYSTERESIS)
}

/// These nodes switched or all the others, the one with the smaller largest angle by `gain`, among
/// those that are `possible`.
fn best(
    e: &ElementEntry,
    switched: u32,
    psi: &[Vector3<f64>],
    possible: [bool; 2],
    gain: f64,
) -> u32 {
    if e.frames.count_ones() < 2 {
        return 0;
    }
    let (mut here, mut there) = (0.0_f64, 0.0_f64);
    for (bit, psi) in frames(e, psi) {
        let angle = psi.norm();
        let (a, b) = match switched & bit {
            0 => (angle, TAU - angle),
            _ => (TAU - angle, angle),
        };
        here = here.max(a);
        there = there.max(b);
    }
    let other = there < here - gain && possible[1];
    if other || !possible[0] {
        e.frames ^ switched
    } else {
        switched
    }
}

/// Whether the vectors of a step, in the element's chart during it, can be continued with the nodes
/// as they are, and with all nodes switched.
///
/// Vectors a turn or more apart are too far from each other. A chart subtracts the same number of
/// whole turns from all of them, m, even or odd, and leaves each within one: |ψ − 2πm| < 2π.
fn possible(e: &ElementEntry, switched: u32, before: &[Vector3<f64>]) -> [bool; 2] {
    let seen = |bit: u32, psi: &Vector3<f64>| match switched & bit {
        0 => *psi,
        _ => so3::complement(psi),
    };
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for (bit, psi) in frames(e, before) {
        let psi = seen(bit, psi);
        let apart = |(bit, other): (u32, &Vector3<f64>)| (seen(bit, other) - psi).norm() >= TAU;
        if frames(e, before).any(apart) {
            return [false; 2];
        }
        least = least.min(psi.norm() / TAU);
        most = most.max(psi.norm() / TAU);
    }
    // most − 1 < m < least + 1
    let (from, to) = ((most - 1.0).floor() + 1.0, (least + 1.0).ceil() - 1.0);
    let parity = |m: f64| usize::from(m.rem_euclid(2.0) == 1.0);
    let mut out = [false; 2];
    if from <= to {
        out[parity(from)] = true;
        out[parity(to)] = true;
    }
    out
}

/// The nodes whose quaternion changed sign at the same configuration.
fn flipped(e: &ElementEntry, before: &[Vector3<f64>], after: &[Vector3<f64>]) -> u32 {
    let pairs = frames(e, before).zip(frames(e, after));
    let flips = pairs
        .filter(|((_, a), (_, b))| a != b && so3::quaternion(*a).dot(&so3::quaternion(*b)) < 0.0);
    flips.map(|((bit, _), _)| bit).sum()
}
