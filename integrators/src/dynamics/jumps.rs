//! Discontinuities: a kink of a prescribed motion, a change of inputs, a change of segment.

#![allow(non_snake_case)]

use super::initial::apply_impulse;
use super::run::MotionRun;
use super::step::Stepper;
use super::stops::StopTime;
use super::{DynamicsError, Progress, State};
use crate::abilities::{events, momentum};
use crate::linear_solver::LinearSolver;
use pullback_manifold::system::{Energies, Point, System};

impl MotionRun {
    /// Continues after a kink.
    pub(super) fn pass(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
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
        let known = momentum(system, before, &mut self.momentum);
        let known = known.map_err(|source| DynamicsError::System { t: *t, source })?;
        *t = stop.right;
        if known {
            self.jump(system, solver, progress, stop.right, true)?;
        } else {
            self.renew(system, solver, progress, true)?;
        }
        self.set_target(system, progress)
    }

    /// Continues after a change of inputs. Inputs have no rate, so velocities do not change.
    pub(super) fn take_inputs(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        if events(system).inputs() == progress.inputs {
            return Ok(());
        }
        self.refresh(system, solver, progress)
    }

    /// Continues after a change of forces or velocities that needs no impulse.
    pub(super) fn refresh(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
    ) -> Result<(), DynamicsError> {
        progress.inputs = events(system).inputs().to_vec();
        self.renew(system, solver, progress, true)?;
        self.set_target(system, progress)
    }

    /// Applies the impulse that conserves the momentum; updates accelerations and energies.
    pub(super) fn jump(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
        t: f64,
        supplied: bool,
    ) -> Result<(), DynamicsError> {
        let h = self.options.step.min(progress.next_step);
        let Stepper { r, S, .. } = &mut self.stepper;
        let buffers: [&mut [f64]; 3] = [r, S, &mut self.missing];
        let state = &mut progress.state;
        // A prescribed velocity jumps, or a map changed its segment.
        let impulses = apply_impulse(
            system,
            solver,
            state,
            (&self.momentum, supplied),
            t,
            h,
            buffers,
        )?;
        progress.summary.evaluations += impulses;
        progress.summary.factorisations += impulses;
        if let (false, Some(projection), Some(kept)) =
            (supplied, &mut self.projection, &mut progress.invariants)
        {
            // The energy is continuous at a corner.
            projection.restore(system, &self.options.scheme, state, kept, (t, 0.0), [r, S])?;
            progress.summary.evaluations += projection.take_evaluations();
        }
        self.renew(system, solver, progress, supplied)
    }

    /// Updates accelerations and energies after a jump; `supplied` says that supports do its work.
    fn renew(
        &mut self,
        system: &mut dyn System,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
        supplied: bool,
    ) -> Result<(), DynamicsError> {
        // Accelerations jump with a prescribed motion, but not along a chain of beams.
        if supplied {
            progress.state.a.clear();
        }
        self.accelerate(system, solver, progress)?;
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
