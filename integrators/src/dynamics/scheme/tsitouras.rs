//! The explicit Runge-Kutta pair of Tsitouras.

use super::{Family, Scheme, SchemeProperties, Stage};
use num_complex::Complex;

/// Tsitouras 5(4).
pub(super) const TSITOURAS: Family = Family {
    word: "tsitouras",
    long: "tsitouras",
    usage: "tsitouras (explicit, order 5, stable for h of at most 0.478 / largest frequency)",
    // e^z up to z⁵ by its order; z⁶ takes the only path through all stages.
    stability: Some(|scheme, z| {
        let rows = scheme.stages().iter().enumerate();
        let last: f64 = rows.map(|(i, row)| row.v[i]).product();
        [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0]
            .into_iter()
            .fold(Complex::from(last), |sum, weight| sum * z + weight)
    }),
    make: |numbers| numbers.is_empty().then(|| Ok(Scheme::tsitouras())),
};

/// Times of the stages after the first one, which is the old state, and of the embedded method.
const C: [f64; 7] = [0.161, 0.327, 0.9, 0.9800255409045097, 1.0, 1.0, 1.0];

/// Weights of the stages, the last of which is the new state, and of the embedded method.
#[rustfmt::skip]
const A: [[f64; 7]; 7] = [
    [0.161, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-0.008480655492356989, 0.335480655492357, 0.0, 0.0, 0.0, 0.0, 0.0],
    [2.8971530571054935, -6.359448489975075, 4.3622954328695815, 0.0, 0.0, 0.0, 0.0],
    [5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525, 0.0, 0.0, 0.0],
    [5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401,
     -0.028269050394068383, 0.0, 0.0],
    [0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081,
     2.324710524099774, 0.0],
    [0.09468075576583945, 0.009183565540343254, 0.4877705284247616, 1.234297566930479,
     -2.7077123499835256, 1.866628418170587, 1.0 / 66.0],
];

/// The Ω at which |R(iΩ)| = 1, from the coefficients.
const LIMIT: f64 = 0.477978868882752;

impl Scheme {
    /// The explicit pair of orders 5 and 4 of Tsitouras (*Comput. Math. Appl.* 62, 2011, 770–775): six
    /// evaluations in a step, as the last stage is the first one of the next step. Each is solved for
    /// its accelerations with the mass matrix, without iteration and stiffness: a mass matrix that is not −∂r/∂q̈ lowers the
    /// order, and no error says so. The method of order 4 estimates the local error for adaptive steps.
    ///
    /// For smooth motion of rigid bodies: undamped vibrations grow beyond ω h = 0.478, if slowly,
    /// and a run in equal steps refuses larger ones. Every coordinate needs mass, and multipliers are refused.
    pub fn tsitouras() -> Self {
        let properties = SchemeProperties {
            order: 5,
            limit: Some(LIMIT),
            symmetric: false,
        };
        let [stages @ .., embedded] = Stage::runge_kutta(C, A);
        Self::table("Tsitouras 5(4)", "tsitouras", &stages, properties).with_embedded(embedded)
    }
}
