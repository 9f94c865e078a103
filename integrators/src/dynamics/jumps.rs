//! Discontinuities: a kink of a prescribed motion, a change of inputs, a change of segment.

use super::run::MotionRun;
use super::stops::StopTime;
use super::{DynamicsError, Progress, State};
use crate::abilities::{energetics, events};
use pullback_manifold::system::{Energies, Point, System};

impl MotionRun {
    /// Continues after a kink.
    pub(super) fn pass(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        stop: StopTime,
    ) -> Result<(), DynamicsError> {
        let State { t, q, v, a, .. } = &mut progress.state;
        let before = Point {
            t: stop.left.next_down(),
            q,
            v,
            a,
        };
        let known = energetics(system).momentum(before, &mut self.momentum);
        let known = known.map_err(|source| DynamicsError::System { t: *t, source })?;
        *t = stop.right;
        if known {
            self.jump(system, progress, true)?;
        } else {
            self.renew(system, progress, true)?;
        }
        self.set_target(system, progress)
    }

    /// Continues after a change of inputs, and says whether there was one. Inputs have no rate, so velocities do not
    /// change.
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

    /// Continues after a change of forces or velocities that needs no impulse.
    pub(super) fn refresh(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        progress.inputs = events(system).inputs().to_vec();
        self.renew(system, progress, true)?;
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
            let t = state.t;
            projection.restore(system, &mut self.stepper, progress, (t, 0.0))?;
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
        if supplied {
            progress.state.a.clear();
        }
        self.accelerate(system, progress)?;
        let now = self.energies(system, &progress.state, progress.state.t)?;
        if let (Some(now), Some(balance)) = (now, &mut progress.summary.energy) {
            if supplied {
                let energy = |e: &Energies| e.kinetic + e.stored;
                let work = energy(&now) - energy(&balance.now);
                balance.work += work;
                balance.gross += work.abs();
            }
            balance.now = now;
        }
        Ok(())
    }
}
