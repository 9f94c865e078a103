//! One spring that is not linear, and how to solve for its equilibrium.

use super::*;

/// One coordinate with the equilibrium λ P = f(w), given f and f′.
pub struct Scalar {
    pattern: BlockPattern,
    P: f64,
    f: fn(f64) -> [f64; 2],
}

impl Scalar {
    pub fn new(P: f64, f: fn(f64) -> [f64; 2]) -> Self {
        Self {
            pattern: BlockPattern::dense(1).with_coordinates(|_| CoordinateInfo {
                quantity: Quantity::Length,
                ..CoordinateInfo::default()
            }),
            P,
            f,
        }
    }
}

impl System for Scalar {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let [f, slope] = (self.f)(at.q[0]);
        if !f.is_finite() {
            let what = "the spring".to_owned();
            return Err(SystemError::NotFinite { what });
        }
        out.r[0] = at.t * self.P - f;
        if let Some((weights, S)) = out.S {
            S[0] = weights.K * slope;
        }
        if let Some(r_t) = out.r_t {
            r_t[0] = self.P;
        }
        Ok(())
    }

    fn is_symmetric(&self) -> bool {
        true
    }

    fn name(&self, _: usize) -> String {
        "the crown, downwards".to_owned()
    }

    fn scales(&self) -> Scales {
        Scales {
            force: [self.P, 0.0, 0.0],
            ..Scales::default()
        }
    }
}

/// The step that failed.
pub fn failed_step<T>(outcome: Result<T, StaticsError>) -> FailedStep {
    match outcome {
        Err(StaticsError::Step(failed)) => *failed,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("no step failed"),
    }
}

/// To round-off.
pub const TIGHT: StaticNewtonOptions = StaticNewtonOptions {
    relative: 1e-14,
    absolute: 1e-15,
    max_iterations: 20,
    full_corrections: 6,
    smallest_damping: 0.1,
};

/// Shallow two-bar truss of von Mises, height 1, with Green's strain: λ P = w (w − 1)(w − 2).
///
/// It snaps at w = 1 ∓ 1/√3 with f = ±2/(3√3).
pub fn truss() -> Scalar {
    Scalar::new(1.0, |w| {
        [
            w * (w - 1.0) * (w - 2.0),
            (w - 1.0) * (w - 2.0) + w * (w - 2.0) + w * (w - 1.0),
        ]
    })
}

/// Its limit load, 2/(3√3).
pub const LIMIT: f64 = 0.384_900_179_459_750_5;
