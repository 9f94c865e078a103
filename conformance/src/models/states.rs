//! The states at which a model is checked: its start, and smooth random deformations of it.

use super::view::unknowns;
use crate::{Random, TestState};
use nalgebra::{DVector, Vector3};
use pullback_elements::model::{Context, FreeRotation, ModelState};
use pullback_manifold::chart::Complement;
use pullback_manifold::map::Map;
use pullback_manifold::so3::{log_quaternion, quaternion};
use pullback_manifold::system::{Charts, Evaluation, Quantity, System, SystemError};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Magnitudes of a field of displacements and rotations over the model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    /// Displacements in lengths of the model.
    pub displacement: f64,
    /// Rotation angles in radians.
    pub rotation: f64,
    /// Independent part of each node, in its units.
    pub noise: f64,
}

/// Wave number of a smooth field, over the length of the model.
const WAVES: f64 = 3.0;

impl Size {
    pub(super) const NONE: Self = Self {
        displacement: 0.0,
        rotation: 0.0,
        noise: 0.0,
    };
    pub(super) const NEAR: Self = Self {
        displacement: 0.02,
        rotation: 0.2,
        noise: 0.02,
    };
    pub(super) const FAR: Self = Self {
        displacement: 0.1,
        rotation: 1.4,
        noise: 0.05,
    };

    fn times(self, factor: f64) -> Self {
        Self {
            displacement: self.displacement * factor,
            rotation: self.rotation * factor,
            noise: self.noise * factor,
        }
    }
}

/// A smooth field of vectors.
struct Field {
    base: Vector3<f64>,
    amplitude: Vector3<f64>,
    wave: Vector3<f64>,
    phase: f64,
}

impl Field {
    fn new(random: &mut Random, size: f64, length: f64) -> Self {
        Self {
            base: random.of_norm(0.7 * size),
            amplitude: random.of_norm(0.5 * size),
            wave: random.of_norm(WAVES / length),
            phase: random.of_norm(3.0).x,
        }
    }

    fn at(&self, X: &Vector3<f64>) -> Vector3<f64> {
        self.base + self.amplitude * (self.wave.dot(X) + self.phase).sin()
    }
}

/// A state at rest near `q`, inside all domains and with suitable charts. A size that leads outside, or to a singular
/// position of a loop, where derivatives have few digits, is halved repeatedly. Loops are solved from their saved
/// states at `q`.
///
/// # Errors
/// [`SystemError`] where `q` itself is outside of a domain.
pub(super) fn beside(
    context: &mut Context,
    (t, q): (f64, &[f64]),
    first: &ModelState,
    size: Size,
    units: &[f64],
    random: &mut Random,
) -> Result<TestState, SystemError> {
    let seed = random.clone();
    let mut factor = 1.0;
    loop {
        let same_model = context.set_state(first.clone());
        debug_assert!(same_model, "a state of another model");
        let regular = context.singularity_warnings().is_empty();
        *random = seed.clone();
        let x = moved(context, q, size.times(factor), units, random);
        let mut state = TestState::statics(t, DVector::from_vec(x));
        let settled = settle(context, &mut state).and_then(|()| {
            let mut r = vec![0.0; q.len()];
            context.evaluate(state.point(), Evaluation::residual(&mut r))
        });
        match settled {
            Ok(()) if factor == 0.0 || !regular || context.singularity_warnings().is_empty() => {
                return Ok(state);
            }
            Err(error) if factor == 0.0 => return Err(error),
            _ => factor = if factor > 1e-3 { 0.5 * factor } else { 0.0 },
        }
    }
}

/// The position of a frame, or of the first frame that reads the coordinates of a joint.
fn position(context: &Context, node: usize) -> Vector3<f64> {
    let frames = context.mapped_nodes().iter().map(|&n| n as usize);
    let mut readers = frames.filter(|&n| context.nodes()[n].parents(0).contains(&(node as u32)));
    let own = &context.nodes()[node];
    match own.is_frame() {
        true => own.position(),
        false => (readers.next()).map_or(own.position(), |n| context.nodes()[n].position()),
    }
}

fn moved(context: &Context, q: &[f64], size: Size, units: &[f64], random: &mut Random) -> Vec<f64> {
    let length = context.length();
    let displacement = Field::new(random, size.displacement * length, length);
    let rotation = Field::new(random, size.rotation, length);
    let mut x = q.to_vec();
    let unknowns = unknowns(context);
    for (u, &(node, k, kind)) in unknowns.iter().enumerate() {
        let own = random.range(-1.0, 1.0);
        let of = &context.nodes()[node];
        let frame = of.is_frame();
        // A free joint has the coordinates of a frame.
        let pose = frame || of.quantities().len() == 6;
        let field = |field: &Field| field.at(&position(context, node))[k % 3];
        x[u] += match (kind, pose) {
            (Quantity::Length, true) => field(&displacement) + own * size.noise * units[node],
            // Displacements of joints.
            (Quantity::Length, false) => own * (size.noise + size.displacement) * units[node],
            (Quantity::Angle, true) if frame => own * size.noise,
            (Quantity::Angle, true) => field(&rotation) + own * size.noise,
            (Quantity::Angle | Quantity::Other, _) => own * size.rotation,
        };
    }
    for free in context.free_rotations() {
        let Some(&u) = free.0.iter().flatten().next() else {
            continue;
        };
        let turn = rotation.at(&position(context, unknowns[u].0));
        let now = free.of(&x);
        // A rotation that is held in part is free about some axes only.
        let turned = match free.0.iter().all(Option::is_some) {
            true => log_quaternion(&quaternion(&turn).product(&quaternion(&now))),
            false => now + turn,
        };
        free.write(&mut x, &turned);
    }
    x
}

/// Random velocities and accelerations of the sizes of units and rate.
pub(super) fn moving(s: &TestState, units: &[f64], rate: f64, random: &mut Random) -> TestState {
    let v = random.entries(units) * rate;
    let a = random.entries(units) * rate.powi(2);
    TestState { v, a, ..s.clone() }
}

/// Changes the charts of rotations of a state, as at the end of a step, and returns their number. Rotations near 0 or
/// 2π, where the other chart ends, keep their charts.
pub(super) fn switch(
    context: &mut Context,
    rotations: &[FreeRotation],
    s: &mut TestState,
) -> Result<usize, SystemError> {
    // The distance from the nearer of 0 and 2π.
    let away = |rotation: &FreeRotation| {
        let psi = rotation.of(s.x.as_slice()).norm();
        psi.min(TAU - psi)
    };
    let most = rotations.iter().map(away).fold(0.0, f64::max);
    let least = (LARGER * most).clamp(TURNED[0], TURNED[1]);
    let clear = least..TAU - least;
    let before = s.x.clone();
    let changed = rotations.iter().filter(|r| complement(r, s, &clear));
    let count = changed.count();
    context.follow_charts(s.t, before.as_slice(), s.x.as_slice())?;
    Ok(count)
}

/// Sets the charts of a run that starts at a state.
fn settle(context: &mut Context, s: &mut TestState) -> Result<(), SystemError> {
    for rotation in context.free_rotations() {
        complement(&rotation, s, &(PI..TAU));
    }
    context.settle_charts(s.t, s.x.as_slice())
}

/// Changes the chart of a rotation of a state, if its angle is in a range; returns whether it is.
fn complement(rotation: &FreeRotation, s: &mut TestState, angles: &Range<f64>) -> bool {
    let [x, v, a] = [&s.x, &s.v, &s.a].map(|x| rotation.of(x.as_slice()));
    if !angles.contains(&x.norm()) {
        return false;
    }
    let k = Complement.kinematics(0.0, &x, &v, &a);
    for (to, from) in [(&mut s.x, k.x), (&mut s.v, k.x_dot), (&mut s.a, k.x_ddot)] {
        rotation.write(to.as_mut_slice(), &from);
    }
    true
}

/// Least distance of a rotation vector from 0 and 2π at which its chart is changed: a change enlarges round-off by 2π/ψ,
/// and the smallest ψ would determine the allowed errors of all. Of smaller rotations than the second distance only
/// those near the largest change their charts.
const TURNED: [f64; 2] = [0.2, 1.0];
const LARGER: f64 = 0.7;
