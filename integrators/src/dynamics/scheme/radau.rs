//! The two-stage Radau IIA method.

use super::{Family, Scheme, SchemeProperties, Stage};

/// Radau IIA.
pub(super) const RADAU: Family = Family {
    word: "radau",
    long: "radau-iia",
    usage: "radau (two stages, order 3)",
    // Hairer & Wanner, (IV.3.20): the Padé approximation of degrees 1 and 2.
    stability: Some(|_, z| (1.0 + z / 3.0) / (1.0 - z * 2.0 / 3.0 + z * z / 6.0)),
    make: |numbers| numbers.is_empty().then(|| Ok(Scheme::radau())),
};

impl Scheme {
    /// The two-stage Radau IIA method (Hairer & Wanner, *Solving Ordinary Differential Equations
    /// II*, table IV.5.5), of order 3 for coordinates and velocities, L-stable. Its stages at
    /// tₙ + h/3 and tₙ₊₁ are solved together. With multipliers the orders of position and velocity are 3
    /// and 2: 2s − 1 and s with s stages (Hairer, Lubich & Roche, *The Numerical Solution of
    /// Differential-Algebraic Systems by Runge-Kutta Methods*, 1989).
    pub fn radau() -> Self {
        let rows = [[0.0, 5.0 / 12.0, -1.0 / 12.0], [0.0, 3.0 / 4.0, 1.0 / 4.0]];
        let properties = SchemeProperties {
            order: 3,
            limit: None,
            symmetric: false,
        };
        let stages = Stage::runge_kutta([1.0 / 3.0, 1.0], rows);
        Self {
            multiplier_orders: Some([3, 2]),
            ..Self::table("Radau IIA", "radau", &stages, properties)
        }
    }
}
