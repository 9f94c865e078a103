//! Steps that end where a system changes its maps.

use super::run::Run;
use super::step::rebase;
use super::{Progress, State};
use crate::failure::Failure;
use crate::linear_solver::LinearSolver;
use pullback_manifold::system::{Point, System};

/// A change is met when it is overdue by less than this part of a step.
const MET: f64 = 1e-9;
/// A step that would end this part of its size before a change goes on to it; one that would have to
/// be this short is not made.
const NEAR: f64 = 1e-2;
/// Attempts at most: Newton's method for the time of a change.
const ATTEMPTS: usize = 6;

impl Run<'_> {
    /// Makes the step that was just made from `progress` again where a change lies in it
    /// ([`System::overdue`]), until it ends with the change, not later than `last`; the time at which
    /// it ends now.
    pub(super) fn land<Y: System + ?Sized>(
        &mut self,
        system: &mut Y,
        solver: &mut dyn LinearSolver,
        progress: &mut Progress,
        [to, last]: [f64; 2],
    ) -> Result<f64, Failure> {
        let from = progress.state.t;
        let h = to - from;
        let (mut end, mut near) = (to, NEAR * h);
        for _ in 0..ATTEMPTS {
            let State { t, q, v, a, .. } = &self.stepper.next;
            let at = Point { t: *t, q, v, a };
            let Some(late) = system.overdue(at).filter(|late| *late > -near) else {
                break;
            };
            if 0.0 < late && late <= MET * h {
                break;
            }
            let aim = end - late + 0.5 * MET * h;
            if !(aim > from + NEAR * h && aim <= last) {
                break;
            }
            (end, near) = (aim, h);
            rebase(progress, end - from);
            let scheme = &self.options.scheme;
            self.stepper
                .step(system, solver, scheme, &progress.state, end)?;
        }
        Ok(end)
    }
}
