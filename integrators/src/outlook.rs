//! What the iterations so far say of the next.

use crate::statics::Iteration;

/// A residual that the last tangent is to leave, over what the convergence test allows.
const SAFE: f64 = 0.1;

/// The residual that is evaluated next, before it is known.
///
/// With the tangent of each iterate, corrections fall as c_k = κ c²_{k−1}, and residuals with them:
/// r_k ≈ ϱ² r_{k−1}, ϱ = c_{k−1} / c_{k−2}. A tangent that is one correction old is off by
/// 2 κ c_{k−1}, so that a correction with it leaves r_{k+1} ≈ 2 r²_k / r_{k−1} (Deuflhard 2004, Newton
/// Methods for Nonlinear Problems, section 2.1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outlook {
    /// r_{k−1}, over what is allowed.
    before: f64,
    /// r_k, as is expected.
    next: f64,
    /// Whether the last correction came from the tangent of its iterate.
    renewed: bool,
}

impl Outlook {
    /// From the iterations of a step, the last of which had the tangent of its iterate where it is
    /// `renewed`.
    pub(crate) fn new(history: &[Iteration], renewed: bool) -> Self {
        let (before, next) = match history {
            [.., before, last] if before.damping * last.damping == 1.0 => {
                let fall = (last.correction / before.correction).powi(2);
                (last.ratio, last.ratio * fall)
            }
            _ => (0.0, f64::INFINITY),
        };
        Self {
            before,
            next,
            renewed,
        }
    }

    /// Whether the state to be evaluated is expected to be in balance.
    pub(crate) fn is_balance(&self) -> bool {
        // An old tangent was taken only where it leads there.
        !self.renewed || self.next <= 1.0
    }

    /// Whether the last tangent takes a residual to balance in one correction.
    pub(crate) fn serves(&self, residual: f64) -> bool {
        self.renewed && 2.0 * residual * residual <= SAFE * self.before
    }

    /// Whether the state to be evaluated will need no tangent of its own.
    pub(crate) fn without_tangent(&self) -> bool {
        self.is_balance() || self.serves(self.next)
    }
}
