//! General solvers of ordinary differential equations on a model, to measure their cost.
//!
//! The model is given as a first-order system with its exact tangents,
//!
//! ```text
//! y = (q, q̇),   ẏ = (q̇, q̈),   M q̈ = r(t, q, q̇, 0),   ∂q̈ = −M⁻¹ (K ∂q + C ∂q̇)
//! ```
//!
//! and the solver, of the library diffsol, chooses its steps by a tolerance. It is restarted at changes of chart, which
//! it does not support, and at kinks of functions of time. Nor does it support a mass matrix that depends on q: every
//! evaluation factorises M, and its own linear algebra uses full matrices. The cargo feature `diffsol` enables it.

#[cfg(feature = "diffsol")]
mod equations;
#[cfg(feature = "diffsol")]
mod solver;

#[cfg(feature = "diffsol")]
pub use solver::{Observer, integrate};

use pullback_integrators::dynamics::DynamicsError;
use pullback_integrators::significant;
use std::fmt;
use std::str::FromStr;

/// Failure of a general solver.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "each message says what its variant is")]
#[non_exhaustive]
pub enum GeneralError {
    #[error(
        "the solver {solver} takes ordinary differential equations, and {multiplier} is a \
         multiplier: close the loop by a map"
    )]
    Multiplier { solver: String, multiplier: String },
    /// The motion cannot start, or continue.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    #[error("the solver {solver} at time {}: {reason}", significant(*t))]
    Solver {
        solver: String,
        t: f64,
        /// The error of the model or the solver.
        reason: String,
    },
}

/// A method of the library diffsol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Backward differences of variable order, 1 to 5.
    Bdf,
    /// A diagonally implicit Runge-Kutta method of order 3 with an explicit first stage.
    Esdirk,
}

/// A general solver and its relative tolerance, from a name such as `diffsol-bdf` or
/// `diffsol-esdirk:1e-6`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct General {
    /// The method.
    pub rule: Rule,
    /// Relative tolerance, in a comparison that at its largest step size.
    pub tolerance: f64,
    /// Whether the tolerance was given.
    has_tolerance: bool,
}

/// Names and methods.
const RULES: [(&str, Rule); 2] = [("diffsol-bdf", Rule::Bdf), ("diffsol-esdirk", Rule::Esdirk)];
/// Prefix of the names of general solvers.
pub(crate) const PREFIX: &str = "diffsol";
/// Default relative tolerance.
const TOLERANCE: f64 = 1e-4;

impl General {
    /// A method with a relative tolerance.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] unless the tolerance is in [1e-13, 0.1].
    pub fn new(rule: Rule, tolerance: f64) -> Result<Self, DynamicsError> {
        let [from, to] = [1e-13, 0.1];
        if !(tolerance >= from && tolerance <= to) {
            return Err(DynamicsError::Parameter {
                name: "tolerance of a general solver",
                value: tolerance,
                from,
                to,
            });
        }
        Ok(Self {
            rule,
            tolerance,
            has_tolerance: true,
        })
    }

    /// The same at a step size of a comparison whose largest one is `largest`: the tolerance decreases with h²,
    /// like errors of second-order schemes, down to rounding.
    pub fn at(&self, step: f64, largest: f64) -> Self {
        let tolerance = (self.tolerance * (step / largest).powi(2)).max(1e-13);
        Self { tolerance, ..*self }
    }

    /// Description for reports.
    pub fn about(&self) -> &'static str {
        match self.rule {
            Rule::Bdf => {
                "backward differences of variable order and step (diffsol), total rotation vectors, \
                 a system of the first order; h stands for a tolerance that falls with h²"
            }
            Rule::Esdirk => {
                "ESDIRK of order 3 with variable step (diffsol), total rotation vectors, a system of \
                 the first order; h stands for a tolerance that falls with h²"
            }
        }
    }
}

impl FromStr for General {
    type Err = DynamicsError;

    /// `diffsol-bdf` or `diffsol-esdirk`, with a tolerance after a colon unless it is 1e-4. An error
    /// in programs built without the feature `diffsol`.
    fn from_str(text: &str) -> Result<Self, DynamicsError> {
        let refuse = |problem: &str| DynamicsError::Word {
            word: text.to_owned(),
            problem: problem.to_owned(),
        };
        let word = text.split(':').next().unwrap_or(text);
        let number = text.split_once(':').map(|(_, number)| number);
        let Some((_, rule)) = RULES.iter().find(|(known, _)| *known == word) else {
            return Err(refuse(
                "no general solver has this name; there are diffsol-bdf and diffsol-esdirk, or \
                 diffsol-bdf:TOLERANCE",
            ));
        };
        if !cfg!(feature = "diffsol") {
            return Err(refuse(
                "this program is built without general solvers; build it with them: \
                 cargo build --release --features diffsol",
            ));
        }
        let tolerance = number.map_or(Ok(TOLERANCE), |number| {
            let read = number.trim().parse();
            read.map_err(|_| refuse(&format!("`{number}` is not a number")))
        })?;
        Ok(Self {
            has_tolerance: number.is_some(),
            ..Self::new(*rule, tolerance)?
        })
    }
}

impl fmt::Display for General {
    /// The name from which it is parsed.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = RULES.iter().find(|(_, rule)| *rule == self.rule);
        f.write_str(word.map_or("", |(word, _)| word))?;
        if self.has_tolerance {
            write!(f, ":{}", self.tolerance)?;
        }
        Ok(())
    }
}
