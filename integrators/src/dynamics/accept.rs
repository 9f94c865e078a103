//! The end of an accepted step: charts, invariants, the energy balance, kinks, the next step size.

use super::run::MotionRun;
use super::step::Stepper;
use super::stops::equal_steps;
use super::{DynamicsError, Progress, State};
use crate::abilities::energetics;
use pullback_manifold::system::{Energies, Point, System};

/// A halved step is doubled again after this many converged steps in a row.
const EASY: usize = 4;

impl MotionRun {
    /// Accepts the new state and updates charts, and accelerations after a kink; the number of
    /// changes of chart.
    pub(super) fn accept(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        h: f64,
    ) -> Result<usize, DynamicsError> {
        let damped = (progress.summary.energy).is_some_and(|e| e.now.dissipated != 0.0);
        let dissipated = match damped {
            true => self.mean_dissipation(system, &progress.state),
            false => None,
        };
        // The evaluation leaves the system at the end of the step.
        let now = self.energies(system, &self.stepper.next)?;
        std::mem::swap(&mut progress.state, &mut self.stepper.next);
        progress.last_step = h;
        progress.summary.steps += 1;
        self.finish_step(system, progress, h);
        let t = progress.state.t;
        let changes = progress.state.change_charts(system);
        progress.summary.chart_changes += changes.charts;
        let segments_changed = self.segments_changed(system, t)?;
        let now = match now {
            Some(now) if segments_changed => {
                // The jump restores what is missing.
                if let Some(kept) = &mut progress.invariants {
                    kept.add_step(&now, h);
                }
                Some(now)
            }
            now => self.restore_invariants(system, progress, now, changes.residual, h)?,
        };
        if let (Some(now), Some(balance)) = (now, &mut progress.summary.energy) {
            balance.add_step(&now, h, dissipated, &system.scales());
            balance.check_growth(t)?;
        }
        if segments_changed {
            self.jump(system, progress, false)?;
        }
        if let Some(stop) = self.stops.kink(t) {
            self.pass(system, progress, stop)?;
        }
        self.double_step(progress);
        Ok(changes.charts)
    }

    /// Projects the new state onto its invariants, if the scheme does; its energies then.
    fn restore_invariants(
        &mut self,
        system: &mut dyn System,
        progress: &mut Progress,
        now: Option<Energies>,
        residual_changed: bool,
        h: f64,
    ) -> Result<Option<Energies>, DynamicsError> {
        let Some(projection) = &mut self.projection else {
            return Ok(now);
        };
        if let (true, Some(now), Some(invariants)) =
            (residual_changed, &now, &mut progress.invariants)
        {
            // The discretisation itself depends on charts.
            let changed = projection.energies(system, &progress.state)?;
            invariants.energy += changed.total() - now.total();
        }
        let restored = projection.restore(system, &mut self.stepper, progress, h)?;
        Ok(Some(restored))
    }

    /// Doubles a step size that was halved, after enough converged steps in a row.
    fn double_step(&self, progress: &mut Progress) {
        if self.options.adaptivity.is_some() {
            return;
        }
        progress.easy += 1;
        let nominal = self.options.step;
        let stop = self.stops.next(progress.state.t, &self.options);
        let rest = equal_steps(stop.left - progress.state.t, progress.next_step);
        // With an odd number of steps left, doubled steps would miss the times of the steps before
        // they were halved.
        let pairs = rest % 2.0 == 0.0;
        if progress.easy >= EASY && progress.next_step < nominal && pairs {
            progress.next_step = nominal.min(2.0 * progress.next_step);
            progress.easy = 0;
        }
    }

    /// Power of dampers midway between a state and the next one, with the velocity (q₁ − q₀) / h.
    ///
    /// The powers at both ends may be those of dampers that relax within a small part of the step. This
    /// one is the dissipation of the trapezoidal rule in a linear system, for any step. `None` if the
    /// system cannot be evaluated there: a converged step must not fail by its energy balance.
    fn mean_dissipation(&mut self, system: &mut dyn System, state: &State) -> Option<f64> {
        let Stepper {
            next,
            inverse_scale,
            ..
        } = &self.stepper;
        let (q, v, h) = (&mut self.momentum, &mut self.missing, next.t - state.t);
        for i in 0..q.len() {
            q[i] = 0.5 * (state.q[i] + next.q[i]);
            // Multipliers have no rates.
            v[i] = match inverse_scale[i] {
                0.0 => 0.0,
                _ => (next.q[i] - state.q[i]) / h,
            };
        }
        let t = 0.5 * (state.t + next.t);
        let a = &next.a;
        energetics(system).dissipation(Point { t, q, v, a }).ok()
    }
}
