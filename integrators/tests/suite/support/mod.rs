//! Set-up that several tests share.

pub mod dynamics;
pub mod linear_solver;
pub mod statics;

pub use pullback_integrators::{dynamics::*, linear_solver::*, linearization::*, statics::*};
pub use pullback_manifold::{domain::*, sparse::BlockPattern, system::*};
pub use std::ops::ControlFlow;

/// A system whose configuration is that of its last evaluation.
pub struct Configured<Y> {
    pub system: Y,
    pub q: Vec<f64>,
}

impl<Y> Configured<Y> {
    pub fn new(system: Y) -> Self {
        let q = Vec::new();
        Self { system, q }
    }
}

impl<Y: System> System for Configured<Y> {
    fn pattern(&self) -> &BlockPattern {
        self.system.pattern()
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        self.q = at.q.to_vec();
        self.system.evaluate(at, out)
    }
}

/// What is refused, row by row, with texts that its error has.
macro_rules! refused {
    ($($outcome:expr => $texts:expr),* $(,)?) => {$(
        let Err(error) = $outcome else {
            panic!("accepted: {}", stringify!($outcome));
        };
        let error = error.to_string();
        for text in $texts {
            assert!(error.contains(text), "`{text}` is not in: {error}");
        }
    )*};
}
pub(crate) use refused;
