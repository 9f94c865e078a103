//! Where a run in time is, and what it has done.

use super::{DynamicsError, Invariants, State};
use crate::statics::Iteration;
use pullback_manifold::system::{Energies, Scales};

/// Energies along a run.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Kinetic and stored energy at the start.
    pub start: f64,
    /// Energies and powers now.
    pub now: Energies,
    /// Work of loads, supports and dampers so far: that of loads with a potential is what they have
    /// lost of it, that of dampers follows from the displacements of each step, the rest comes from the
    /// trapezoidal rule over the steps.
    pub work: f64,
    /// Work of the steps so far, whatever its sign.
    pub gross: f64,
    /// Largest |kinetic + stored − start − work| so far.
    pub largest_defect: f64,
    /// Most that forces and moments have been, applied ones and reactions, times a length of the model
    /// and a radian: energies below the last digit of it are rounding errors.
    #[cfg_attr(feature = "serde", serde(default))]
    pub size: f64,
    /// Steps in a row in which the energy has been absurd.
    #[cfg_attr(feature = "serde", serde(default))]
    pub absurd: usize,
    /// The energy when these were a power of two, the last time.
    #[cfg_attr(feature = "serde", serde(default))]
    pub mark: f64,
}

/// Factor by which energy exceeds all that was ever there or supplied where it is absurd.
const ABSURD: f64 = 1e3;

/// Factor by which absurd energy must have grown while its steps doubled: faster than the tenth power
/// of time. Errors of a motion that has hardly any energy do not grow like this.
const BOUNDLESS: f64 = 1e3;

impl EnergyBalance {
    /// Takes the energies at the end of a step of size h, and the mean power dissipated in it if that is
    /// known; the system has these scales.
    pub(super) fn add_step(
        &mut self,
        now: &Energies,
        h: f64,
        dissipated: Option<f64>,
        scales: &Scales,
    ) {
        let sizes = scales.measures().into_iter().zip(scales.coordinate).take(2);
        let size = sizes.map(|(force, length)| force * length).sum();
        self.size = self.size.max(size);
        let drawn = self.now.potential - now.potential;
        let lost = dissipated.unwrap_or(0.5 * (self.now.dissipated + now.dissipated));
        let given = |e: &Energies| e.supplied - e.drawn;
        let work = drawn + h * (0.5 * (given(&self.now) + given(now)) - lost);
        self.work += work;
        self.gross += work.abs();
        self.now = *now;
        self.largest_defect = self.largest_defect.max(self.defect().abs());
    }

    /// Refuses a motion whose energy grows without bounds.
    pub(super) fn check_growth(&mut self, t: f64) -> Result<(), DynamicsError> {
        let (energy, known) = (self.now.kinetic + self.now.stored, self.start + self.gross);
        if known > 0.0 && energy > ABSURD * known {
            self.absurd += 1;
        } else {
            self.absurd = 0;
        }
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

    /// Whether the energies are in balance but for rounding errors.
    pub fn is_rounding(&self) -> bool {
        self.largest_defect <= f64::EPSILON * self.size
    }

    /// Energy that is there without having been supplied.
    pub fn defect(&self) -> f64 {
        self.now.kinetic + self.now.stored - self.start - self.work
    }
}

/// What a run did.
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
    /// Energies, where the system knows them and they were asked for.
    pub energy: Option<EnergyBalance>,
    /// Where the scheme has a limit, the largest stable step at the state from which the run began or was
    /// continued.
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub stable_step: Option<f64>,
    /// Whether the end was reached (an observer may stop earlier).
    pub finished: bool,
}

/// Where a run is: everything that the next step depends on. A run that is continued from a copy
/// gives the same numbers to the last bit.
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// The state; empty accelerations are found first.
    pub state: State,
    /// Step size that the algorithmic accelerations belong to, 0 before the first step.
    pub last_step: f64,
    /// Step size to try next; 0 for that of the options.
    pub next_step: f64,
    /// Whether a kink or jump of a function of time at its time is still to be passed, as at the start and
    /// where a run ended at one: what lies behind is found first.
    pub at_kink: bool,
    /// What was set from outside when the accelerations were found ([`System::inputs`]).
    ///
    /// [`System::inputs`]: pullback_manifold::system::System::inputs
    #[cfg_attr(
        feature = "serde",
        serde(default, skip_serializing_if = "Vec::is_empty")
    )]
    pub inputs: Vec<f64>,
    /// What a scheme that restores energy and momenta aims at.
    #[cfg_attr(
        feature = "serde",
        serde(alias = "kept", default, skip_serializing_if = "Option::is_none")
    )]
    pub invariants: Option<Invariants>,
    /// Converged steps in a row since the last failure.
    pub easy: usize,
    /// Steps in a row that ended early, at once after they began, where a map was handed over.
    #[cfg_attr(feature = "serde", serde(default))]
    pub short: usize,
    /// Counters so far.
    pub summary: Summary,
}

impl Progress {
    /// The beginning of a run.
    pub fn new(state: State) -> Self {
        Self {
            state,
            at_kink: true,
            ..Self::default()
        }
    }
}

/// An accepted step, as an observer sees it.
#[derive(Clone, Copy, Debug)]
pub struct StepReport<'a> {
    /// Where the run is now; a clone of it can be continued.
    pub progress: &'a Progress,
    /// Step size.
    pub step_size: f64,
    /// Linear solutions of this step.
    pub iterations: usize,
    /// History of the iterations, of one stage (substep) after the other where a scheme has several;
    /// each ends with its converged state, which has no correction (damping 0).
    pub residuals: &'a [Iteration],
    /// Charts changed at the end of the step.
    pub chart_changes: usize,
}
