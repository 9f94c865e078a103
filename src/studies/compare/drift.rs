//! Drift of energies and momenta along a run.

use super::sample::{FrameSample, Sample};
use nalgebra::Vector3;
use pullback_integrators::dynamics::EnergyBalance;
use serde::Serialize;

/// Energies and momenta that the motion conserves, as found from the reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Conserved {
    /// The energy: kinetic, stored, and the potential of loads.
    pub energy: bool,
    /// Components of the linear momentum.
    pub momentum: [bool; 3],
    /// Components of the angular momentum about the origin.
    pub angular_momentum: [bool; 3],
}

/// Components of the linear and of the angular momentum, as those of [`Conserved`].
pub type Components = [[bool; 3]; 2];

impl Conserved {
    /// The same without these components of momenta.
    pub(super) fn without(self, left_out: Components) -> Self {
        let rest = |all: [bool; 3], out: [bool; 3]| [0, 1, 2].map(|i| all[i] && !out[i]);
        Self {
            momentum: rest(self.momentum, left_out[0]),
            angular_momentum: rest(self.angular_momentum, left_out[1]),
            ..self
        }
    }
}

/// Momentum relative to its scale in the motion, below which it is zero.
const NOTHING: f64 = 1e-12;

/// Components of momenta that are zero throughout these runs, which every scheme conserves.
pub(super) fn zeros<'a>(runs: impl Iterator<Item = &'a [Sample]> + Clone) -> Components {
    let samples = || runs.clone().flatten();
    let largest = |value: &dyn Fn(&Sample) -> f64| samples().map(value).fold(0.0, f64::max);
    let fastest = |speed: &dyn Fn(&FrameSample) -> f64| {
        largest(&|s| s.nodes.iter().map(speed).fold(0.0, f64::max))
    };
    let energy = largest(&|s| s.gross_energy);
    let speeds = [
        fastest(&|n| n.velocity.norm()),
        fastest(&|n| n.omega.norm()),
    ];
    [0, 1].map(|k| {
        // A body with this speed and energy has a momentum of about their quotient.
        let could = if speeds[k] > 0.0 {
            energy / speeds[k]
        } else {
            0.0
        };
        let size = largest(&|s| s.momenta[k].norm()).max(could);
        [0, 1, 2].map(|i| largest(&|s| s.momenta[k][i].abs()) <= NOTHING * size)
    })
}

/// The largest changes of conserved quantities since the start, at the common times, and the balance of energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Drift {
    /// Of the energy, if it is conserved.
    pub energy: Option<f64>,
    /// Of the conserved components of the linear momentum.
    pub momentum: Option<f64>,
    /// Of the conserved components of the angular momentum.
    pub angular_momentum: Option<f64>,
    /// Largest defect of the balance of energy over all steps: kinetic and stored less supplied, the
    /// work by the trapezoidal rule.
    pub balance: Option<f64>,
    /// Mean change of the energy in the last quarter of the run less that in the first, if the energy is
    /// conserved, or else of the defect of its balance: growth with time, without oscillations.
    pub trend: Option<f64>,
    /// The largest |h| of the equations of loops, each relative to its size, if there are any.
    pub violation: Option<f64>,
    /// The largest energy: the magnitudes of kinetic, stored and load potential.
    pub largest_energy: Option<f64>,
}

/// Fewest samples for quarters of a run.
const FEW: usize = 8;

impl Drift {
    /// The drift of a run.
    pub(super) fn of(
        samples: &[Sample],
        conserved: Conserved,
        balance: Option<EnergyBalance>,
    ) -> Self {
        let energy = |s: &Sample| {
            if conserved.energy {
                Some(s.energy)
            } else {
                s.defect
            }
        };
        let values: Vec<f64> = samples.iter().filter_map(energy).collect();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let quarter = values.len() / 4;
        let quarters = (values.len() >= FEW).then(|| values.len() - quarter);
        let largest = samples.iter().map(|s| s.gross_energy).reduce(f64::max);
        let violations = samples.iter().filter_map(|s| s.violation);
        let worse = |a: f64, b: f64| if b > a || b.is_nan() { b } else { a };
        Self {
            violation: violations.reduce(worse),
            energy: drift(samples, &|s| s.energy).filter(|_| conserved.energy),
            momentum: drift_of(samples, conserved.momentum, &|s| s.momenta[0]),
            angular_momentum: drift_of(samples, conserved.angular_momentum, &|s| s.momenta[1]),
            balance: balance.map(|e| e.largest_defect),
            trend: quarters.map(|last| mean(&values[last..]) - mean(&values[..quarter])),
            largest_energy: largest.filter(|e| *e > 0.0),
        }
    }

    /// A change of energy over the largest energy.
    pub fn relative(&self, change: Option<f64>) -> Option<f64> {
        Some(change? / self.largest_energy?)
    }
}

/// The largest difference from the start; `None` without samples.
pub(super) fn drift(samples: &[Sample], value: &dyn Fn(&Sample) -> f64) -> Option<f64> {
    let first = value(samples.first()?);
    let differences = samples.iter().map(|s| (value(s) - first).abs());
    Some(differences.fold(0.0, f64::max))
}

/// The largest change since the start of the conserved components of a vector; `None` if there are none.
fn drift_of(
    samples: &[Sample],
    conserved: [bool; 3],
    vector: &dyn Fn(&Sample) -> Vector3<f64>,
) -> Option<f64> {
    let drifts = (0..3)
        .filter(|&i| conserved[i])
        .filter_map(|i| drift(samples, &|s| vector(s)[i]));
    drifts.reduce(f64::max)
}
