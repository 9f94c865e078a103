//! Discontinuities: a kink of a prescribed motion, a change of inputs, a change of segment.

use super::run::MotionRun;
use super::stops::StopTime;
use super::{DynamicsError, Progress};
use crate::abilities::{energetics, events};
use pullback_manifold::system::{Energies, System};

impl MotionRun {
    /// Continues behind a kink, from a state just before it.
    pub(super) fn pass(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        stop: StopTime,
    ) -> Result<(), DynamicsError> {
        let state = &mut progress.state;
        let known = energetics(system).momentum(state.point(), &mut self.momentum);
        let known = known.map_err(DynamicsError::at(state.t))?;
        state.t = stop.right;
        // The rate of the accelerations before a kink serves behind it where a function is sampled, in steps that are equal
        // but for the division of its intervals. In growing steps its error grows too: by 2 α_m/(1 − α_m) in one that doubles.
        let grows = self.goal(progress).h > 1.1 * progress.last_step;
        if grows || self.options.adaptivity.is_some() {
            let state = &mut progress.state;
            state.algorithmic.clone_from(&state.filtered);
        }
        self.proceed(system, progress, known)
    }

    /// Continues after a change of inputs, and says whether there was one.
    pub(super) fn take_inputs(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<bool, DynamicsError> {
        let changed = events(system).inputs() != progress.inputs;
        if changed {
            self.refresh(system, progress)?;
        }
        Ok(changed)
    }

    /// Continues after a change of the state, or of inputs: loops are closed again, and where prescribed velocities follow
    /// inputs, they jump as at a kink.
    pub(super) fn refresh(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        let now = events(system).inputs().to_vec();
        let mut known = false;
        if now != progress.inputs {
            let inputs = events(system).inputs().iter_mut();
            inputs.zip(&progress.inputs).for_each(|(u, old)| *u = *old);
            let momentum = energetics(system).momentum(progress.state.point(), &mut self.momentum);
            events(system).inputs().copy_from_slice(&now);
            // Inputs at which nothing can be evaluated had no step.
            known = momentum.unwrap_or(false) && self.momentum.iter().all(|p| p.is_finite());
            progress.inputs = now;
        }
        let h = self.options.step.min(progress.next_step);
        self.stepper.close_gaps(system, &mut progress.state, h)?;
        self.proceed(system, progress, known)
    }

    /// Continues behind a jump, with an impulse if the momentum before it is known.
    fn proceed(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        known: bool,
    ) -> Result<(), DynamicsError> {
        match known {
            true => self.jump(system, progress, true)?,
            false => self.renew(system, progress, true)?,
        }
        self.set_target(system, progress)
    }

    /// Applies the impulse that conserves the momentum; updates accelerations and energies.
    pub(super) fn jump(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        supplied: bool,
    ) -> Result<(), DynamicsError> {
        let h = self.options.step.min(progress.next_step);
        let state = &mut progress.state;
        // A prescribed velocity jumps, or a map changed its segment.
        let momenta = (&self.momentum[..], &mut self.missing[..]);
        let impulses = (self.stepper).apply_impulse(system, state, momenta, supplied, h)?;
        progress.summary.evaluations += impulses;
        progress.summary.factorisations += impulses;
        if let (false, Some(projection)) = (supplied, &mut self.projection) {
            // The energy is continuous at a corner.
            projection.restore(system, &mut self.stepper, progress, 0.0)?;
        }
        self.renew(system, progress, supplied)
    }

    /// Updates accelerations and energies after a jump; `supplied` says that supports do its work.
    fn renew(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        supplied: bool,
    ) -> Result<(), DynamicsError> {
        // Accelerations jump with a prescribed motion, but not along a chain of beams.
        self.accelerate(system, progress, supplied)?;
        let now = self.energies(system, &progress.state)?;
        if let (Some(now), Some(balance)) = (now, &mut progress.summary.energy) {
            if supplied {
                let energy = |e: &Energies| e.kinetic + e.stored;
                let work = energy(&now) - energy(&balance.now);
                balance.work += work;
                balance.gross += work.abs();
            }
            balance.arrive(&now);
        }
        Ok(())
    }
}
