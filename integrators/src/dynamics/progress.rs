//! Progress of a run: its state, counters and energy balance.

use super::{DynamicsError, Invariants, State};
use crate::statics::Iteration;
use pullback_manifold::system::{Energies, Scales};

/// Energy balance of a run.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Kinetic and stored energy at the start.
    pub start: f64,
    /// Present energies and powers.
    pub now: Energies,
    /// Work of loads, supports and dampers so far: that of loads with a potential is the loss of
    /// potential, that of dampers follows from the displacements of each step, the rest from the
    /// trapezoidal rule over the steps.
    pub work: f64,
    /// Sum of the magnitudes of the work of all steps, without what dampers take.
    pub gross: f64,
    /// Largest |kinetic + stored| so far.
    pub largest: f64,
    /// Largest |kinetic + stored − start − work| so far.
    pub largest_defect: f64,
    /// Largest forces and moments so far, applied and reactions, times a length of the model and a
    /// radian: energies below its last digit are rounding errors.
    pub size: f64,
    /// Number of steps in a row with an absurd energy.
    pub absurd: usize,
    /// The energy when this number was last a power of two.
    pub mark: f64,
}

/// Ratio of an absurd energy to all energy that was ever present or supplied.
const ABSURD: f64 = 1e3;

/// Growth of an absurd energy while the number of its steps doubles, faster than the tenth power of
/// time; errors of a motion with hardly any energy grow more slowly.
const BOUNDLESS: f64 = 1e3;

impl EnergyBalance {
    /// Adds a step of size h with the energies at its end, the mean power dissipated in it if
    /// known, and the scales of the system.
    pub(super) fn add_step(
        &mut self,
        now: &Energies,
        h: f64,
        dissipated: Option<f64>,
        scales: &Scales,
    ) {
        let [force, moment, _] = scales.measures();
        self.size = self.size.max(force * scales.length + moment);
        let drawn = self.now.potential - now.potential;
        let lost = dissipated.unwrap_or(0.5 * (self.now.dissipated + now.dissipated));
        let given = |e: &Energies| e.supplied - e.drawn;
        let supplied = drawn + 0.5 * h * (given(&self.now) + given(now));
        self.work += supplied - h * lost;
        // What dampers take cannot come back.
        self.gross += supplied.abs() + (-h * lost).max(0.0);
        self.arrive(now);
        self.largest_defect = self.largest_defect.max(self.defect().abs());
    }

    /// Takes the energies at a new state.
    pub(super) fn arrive(&mut self, now: &Energies) {
        self.now = *now;
        self.largest = self.largest.max((now.kinetic + now.stored).abs());
    }

    /// Rejects a motion whose energy grows without bounds.
    pub(super) fn check_growth(&mut self, t: f64) -> Result<(), DynamicsError> {
        let (energy, known) = (self.now.kinetic + self.now.stored, self.start + self.gross);
        let absurd = known > 0.0 && energy > ABSURD * known;
        self.absurd = if absurd { self.absurd + 1 } else { 0 };
        let mut boundless = !energy.is_finite();
        if self.absurd.is_power_of_two() {
            boundless |= self.absurd >= 16 && energy > BOUNDLESS * self.mark;
            self.mark = energy;
        }
        if boundless {
            return Err(DynamicsError::Unstable { t, energy, known });
        }
        Ok(())
    }

    /// Whether the defect is only rounding errors of so many steps.
    pub fn is_rounding(&self, steps: usize) -> bool {
        self.largest_defect <= f64::EPSILON * self.size * steps as f64
    }

    /// Energy that was not supplied.
    pub fn defect(&self) -> f64 {
        self.now.kinetic + self.now.stored - self.start - self.work
    }
}

/// Counters and results of a run.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Summary {
    /// Accepted steps.
    pub steps: usize,
    /// Attempts that did not converge.
    pub failed: usize,
    /// Attempts rejected by the error estimate.
    pub inaccurate: usize,
    /// Linear solutions in accepted steps.
    pub iterations: usize,
    /// States at which the system was evaluated.
    pub evaluations: usize,
    /// Factorisations.
    pub factorisations: usize,
    /// Changes of chart.
    pub chart_changes: usize,
    /// Energy balance, if requested and provided by the system.
    pub energy: Option<EnergyBalance>,
    /// The largest stable step of a conditionally stable scheme, at the state where the run began, or was
    /// continued with a step beyond this.
    pub stable_step: Option<f64>,
    /// Whether the end was reached (an observer may stop earlier).
    pub finished: bool,
}

/// State of a run: everything that the next step depends on. A run that is continued from a copy
/// gives the same numbers to the last bit.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// The present state; empty accelerations are computed first.
    pub state: State,
    /// Step size of the algorithmic accelerations, 0 before the first step.
    pub last_step: f64,
    /// Next step size to try; 0 for that of the options.
    pub next_step: f64,
    /// Inputs at which the accelerations were computed ([`Events::inputs`]).
    ///
    /// [`Events::inputs`]: pullback_manifold::system::Events::inputs
    pub inputs: Vec<f64>,
    /// Values of the events of the user; one with a value below zero may occur.
    pub events: Vec<f64>,
    /// Target of a scheme that restores energy and momenta.
    pub invariants: Option<Invariants>,
    /// Number of converged steps since the last failure.
    pub easy: usize,
    /// Number of steps in a row that are much shorter than [`Progress::next_step`], as those that end at an event.
    pub short: usize,
    /// Counters so far.
    pub summary: Summary,
}

impl Progress {
    /// The beginning of a run.
    pub fn new(state: State) -> Self {
        Self {
            state,
            ..Self::default()
        }
    }
}

/// Report of an accepted step, for observers.
#[derive(Clone, Copy, Debug)]
pub struct StepReport<'a> {
    /// Present state of the run; a clone of it can be continued.
    pub progress: &'a Progress,
    /// Step size.
    pub step_size: f64,
    /// Linear solutions of this step.
    pub iterations: usize,
    /// History of the iterations, one stage (substep) after the other; each ends with its converged
    /// state, which has no correction (damping 0).
    pub residuals: &'a [Iteration],
    /// Charts changed at the end of the step.
    pub chart_changes: usize,
    /// Events that occurred at the end of the step, by their numbers
    /// ([`Simulation::add_event`](super::Simulation::add_event)).
    pub events: &'a [usize],
}
