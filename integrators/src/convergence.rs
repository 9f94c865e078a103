//! Prediction of the next iteration from the past ones.

use crate::statics::Iteration;

/// Residual that the last tangent should leave, relative to the tolerance.
const SAFE: f64 = 0.1;
/// Corrections larger than this, relative to the scales of the coordinates, are not rounding errors.
const SMALL: f64 = 1e-6;
/// A correction with no effect, relative to the largest of its step.
const NOTHING: f64 = 1e-9;
/// Bound of κ, the part of a first correction that it leaves relative to its square, in the scales of the
/// coordinates.
const CURVED: f64 = 100.0;
/// Residuals that fall by less than this factor stagnate.
const FALL: f64 = 0.1;
/// The same for corrections in a time step, whose first corrections are small.
const FALL_IN_TIME: f64 = 0.1;
/// The same in statics, where a large step may begin far from its end and corrections fall
/// linearly: to two thirds per iteration for a purely cubic spring.
const FALL_AT_REST: f64 = 0.9;
/// Ratio of residuals in linear convergence, three tenths for that spring: slower than quadratic
/// convergence, unlike rounding errors, which stay.
const LINEARLY: std::ops::Range<f64> = 0.01..0.5;

/// Prediction of the next residual, and of the correction that it needs.
///
/// With the tangent of each iterate, corrections fall as c_k = κ c²_{k−1}, and residuals with them:
/// r_k ≈ ϱ² r_{k−1}, ϱ = c_{k−1} / c_{k−2}. A tangent that is one correction old is off by
/// 2 κ c_{k−1}, so that a correction with it leaves 2 r²_k / r_{k−1} (Deuflhard 2004, Newton Methods
/// for Nonlinear Problems, section 2.1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConvergencePredictor {
    /// The residual before the last correction, per quantity, and relative to the tolerance.
    before: ([f64; 3], f64),
    /// The predicted residual relative to the tolerance.
    next: f64,
    /// Whether the last correction came from the tangent of its iterate.
    renewed: bool,
    /// Whether the next correction is predicted to have no effect.
    settled: bool,
    /// Ratio of a small last correction to the one before.
    fallen: f64,
}

impl ConvergencePredictor {
    /// From the iterations of a step; `renewed` says that the last one used the tangent of its iterate.
    pub(crate) fn new(history: &[Iteration], renewed: bool) -> Self {
        let unknown = Self {
            before: ([0.0; 3], 0.0),
            next: f64::INFINITY,
            renewed,
            settled: false,
            fallen: 0.0,
        };
        let (before, last) = match history {
            [.., before, last] if before.damping * last.damping > 0.0 => (before, last),
            [first] if first.damping == 1.0 => {
                return Self {
                    before: (first.residual, first.ratio),
                    next: first.ratio * (CURVED * first.correction).min(1.0),
                    ..unknown
                };
            }
            _ => return unknown,
        };
        // Both may be zero.
        let ratio = last.correction / before.correction.max(f64::MIN_POSITIVE);
        let fall = match renewed {
            // A damped correction predicts nothing.
            _ if before.damping * last.damping < 1.0 => f64::INFINITY,
            true => ratio * ratio,
            false => 2.0 * ratio,
        };
        let largest = history.iter().fold(0.0, |m, i| f64::max(m, i.correction));
        let small = last.correction < SMALL;
        Self {
            before: (last.residual, last.ratio),
            next: last.ratio * fall,
            renewed,
            settled: small && last.correction * fall <= NOTHING * largest,
            fallen: if small { ratio } else { 0.0 },
        }
    }

    /// Whether one correction with the last tangent brings a residual to balance.
    pub(crate) fn serves(&self, residual: f64) -> bool {
        self.renewed && 2.0 * residual * residual <= SAFE * self.before.1
    }

    /// Whether the next state will need no tangent of its own.
    pub(crate) fn without_tangent(&self) -> bool {
        self.settled || self.next <= 1.0 || self.serves(self.next)
    }

    /// Whether another correction is predicted not to help, though residuals exceed the tolerance:
    /// it would have no effect, or corrections and residuals have stopped falling. Residuals of
    /// stiff neighbours may hide one that still falls; corrections show it. At `rest` one part of a
    /// structure may converge linearly after all others.
    pub(crate) fn is_stagnation(&self, residual: [f64; 3], allowed: [f64; 3], rest: bool) -> bool {
        let stays = |k: usize| residual[k] <= allowed[k] || residual[k] > FALL * self.before.0[k];
        let linearly = |k: usize| {
            residual[k] > allowed[k] && LINEARLY.contains(&(residual[k] / self.before.0[k]))
        };
        let fall = if rest { FALL_AT_REST } else { FALL_IN_TIME };
        let settled = self.settled && !(rest && (0..3).any(linearly));
        settled || (self.fallen > fall && (0..3).all(stays))
    }
}
