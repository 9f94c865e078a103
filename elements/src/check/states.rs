//! Where a model is checked: its start, and smooth random deformations of it.

#![allow(non_snake_case)]

use crate::model::Model;
use nalgebra::{DVector, Vector3};
use pullback_manifold::check::{Random, State};
use pullback_manifold::so3::{log_quaternion, quaternion};
use pullback_manifold::system::{Evaluation, Kind, Point, System, SystemError};

/// A field of displacements and rotations over the model, and how rough it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    /// Displacements in lengths of the model.
    pub displacement: f64,
    /// Rotation angles in radians.
    pub rotation: f64,
    /// What each node has of its own, in its units.
    pub noise: f64,
}

/// Waves of a smooth field over the model.
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
        let mut vector = |size: f64| {
            let mut v = Vector3::zeros();
            random.direction(size, v.as_mut_slice());
            v
        };
        Self {
            base: vector(0.7 * size),
            amplitude: vector(0.5 * size),
            wave: vector(WAVES / length),
            phase: vector(3.0).x,
        }
    }

    fn at(&self, X: &Vector3<f64>) -> Vector3<f64> {
        self.base + self.amplitude * (self.wave.dot(X) + self.phase).sin()
    }
}

/// A state at rest beside `q`: inside all domains, in charts that fit. A size that leads outside, or to a
/// singular position of a loop, where derivatives have few digits, is halved as often as it takes. Loops are
/// solved from where `memories` has them, which is at `q`.
///
/// # Errors
/// [`SystemError`] where `q` itself is outside of a domain.
pub(super) fn beside(
    model: &mut Model,
    (t, q): (f64, &[f64]),
    memories: &[Vec<f64>],
    size: Size,
    units: &[f64],
    random: &mut Random,
) -> Result<State, SystemError> {
    let seed = random.clone();
    let mut factor = 1.0;
    loop {
        let same_model = model.recall_maps(memories);
        debug_assert!(same_model, "memories of another model");
        let regular = model.doubts().is_empty();
        *random = seed.clone();
        let x = moved(model, q, size.times(factor), units, random);
        let mut state = State::statics(t, DVector::from_vec(x));
        let settled = model.settle(&mut state).and_then(|()| {
            let (q, v, a) = (state.x.as_slice(), &[][..], &[][..]);
            let mut r = vec![0.0; q.len()];
            model.evaluate(Point { t, q, v, a }, Evaluation::residual(&mut r))
        });
        match settled {
            Ok(()) if factor == 0.0 || !regular || model.doubts().is_empty() => return Ok(state),
            Err(error) if factor == 0.0 => return Err(error),
            _ => factor = if factor > 1e-3 { 0.5 * factor } else { 0.0 },
        }
    }
}

fn moved(model: &Model, q: &[f64], size: Size, units: &[f64], random: &mut Random) -> Vec<f64> {
    let length = model.length();
    let displacement = Field::new(random, size.displacement * length, length);
    let rotation = Field::new(random, size.rotation, length);
    let mut x = q.to_vec();
    for (u, &(node, position, k, kind)) in model.inspect_unknowns().iter().enumerate() {
        let own = random.range(-1.0, 1.0);
        let frame = model.is_frame_at(node);
        x[u] += match (kind, frame) {
            (Kind::Length, true) => {
                displacement.at(&position)[k % 3] + own * size.noise * units[node]
            }
            // Ways that joints release.
            (Kind::Length, false) => own * (size.noise + size.displacement) * units[node],
            (Kind::Angle, true) => own * size.noise,
            (Kind::Angle, false) => own * size.rotation,
            (Kind::Other, _) => own * size.rotation,
        };
    }
    for unknowns in model.free_rotations() {
        let Some(u) = unknowns.iter().flatten().next() else {
            continue;
        };
        let (_, position, ..) = model.inspect_unknowns()[*u];
        let turn = rotation.at(&position);
        let now = Vector3::from_fn(|i, _| unknowns[i].map_or(0.0, |u| x[u]));
        // A rotation that is held in part can only go on about the axes that are free.
        let turned = match unknowns.iter().all(Option::is_some) {
            true => log_quaternion(&quaternion(&turn).product(&quaternion(&now))),
            false => now + turn,
        };
        for (u, psi) in unknowns.iter().zip(turned.iter()) {
            if let Some(u) = *u {
                x[u] = *psi;
            }
        }
    }
    x
}

/// Random velocities and accelerations of the sizes of units and rate.
pub(super) fn moving(s: &State, units: &[f64], rate: f64, random: &mut Random) -> State {
    let mut noise = |order: i32| {
        let mut v = DVector::zeros(s.x.len());
        random.fill(v.as_mut_slice());
        v.component_mul(&DVector::from_column_slice(units)) * rate.powi(order)
    };
    State {
        t: s.t,
        x: s.x.clone(),
        v: noise(1),
        a: noise(2),
    }
}
