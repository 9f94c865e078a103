//! Coefficients of the inverse maps: T⁻¹ (a cotangent) and the logarithm (an arc cosine).

use super::{SERIES_LIMIT, polynomials};
use crate::scalar::{MAX_ORDER, Scalar};

/// 2π minus its nearest `f64`.
const TWO_PI_LOW: f64 = 2.449_293_598_294_706_4e-16;
const TWO_PI: f64 = std::f64::consts::TAU;

/// The sum over n ≥ 4 in [`cotangent`]: row j holds t_j and 2(j+1) t_{j+1}, where t_j = 2 Σ_{n≥4} (2πn)^{−2(j+1)}.
const COTANGENT_TAIL: [[f64; 2]; 12] = {
    const T: [f64; 13] = [
        0.014_378_638_910_075_684,
        9.595_555_480_779_425e-6,
        1.125_714_338_300_260_9e-8,
        1.538_897_956_518_107_3e-11,
        2.247_318_965_080_410_4e-14,
        3.394_356_459_763_464e-17,
        5.223_754_698_482_221_5e-20,
        8.127_414_828_310_521e-23,
        1.272_843_048_024_265_6e-25,
        2.001_458_998_678_854_4e-28,
        3.155_044_680_287_923e-31,
        4.981_335_263_797_585e-34,
        7.872_558_284_510_73e-37,
    ];
    let mut table = [[0.0; 2]; 12];
    let mut j = 0;
    while j < 12 {
        table[j] = [T[j], 2.0 * (j + 1) as f64 * T[j + 1]];
        j += 1;
    }
    table
};

/// a₃ = Σ_{n≥1} 2/((2πn)² − ψ²) and D a₃ at 0 ≤ ψ < 2π.
#[inline]
fn cotangent(psi: f64) -> [f64; 2] {
    let z = psi * psi;
    let mut a = polynomials(&COTANGENT_TAIL, z);
    let gap = (TWO_PI - psi + TWO_PI_LOW) * (TWO_PI + psi);
    for pole in [
        1.0 / gap,
        1.0 / (4.0 * TWO_PI * TWO_PI - z),
        1.0 / (9.0 * TWO_PI * TWO_PI - z),
    ] {
        a[0] += 2.0 * pole;
        a[1] += 4.0 * pole * pole;
    }
    a
}

/// g = (ψ/2) cot(ψ/2) given a₃ = (1 − g)/ψ².
#[inline]
fn half_cotangent(psi: f64, a3: f64) -> f64 {
    let z = psi * psi;
    if z < SERIES_LIMIT {
        return 1.0 - z * a3;
    }
    let (s, c) = (0.5 * psi).sin_cos();
    0.5 * psi * c / s
}

/// What T⁻¹ and C₆ need at one angle 0 ≤ ψ < 2π; \[M04\] (65), (68).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseQuotients {
    /// g = (ψ/2) cot(ψ/2).
    pub g: f64,
    /// a₁ = g′/ψ.
    pub a1: f64,
    /// a₂ = a₃′/ψ.
    pub a2: f64,
    /// a₃ = (1 − g)/ψ².
    pub a3: f64,
}

impl InverseQuotients {
    /// All of them at the angle ψ ≥ 0.
    #[must_use]
    pub fn new(psi: f64) -> Self {
        let [a3, a2] = cotangent(psi);
        let g = half_cotangent(psi, a3);
        // The Riccati equation of the cotangent; g a₃ < 1/10, so nothing cancels.
        let a1 = g * a3 - 0.25;
        Self { g, a1, a2, a3 }
    }
}

/// Derivatives k = 0…4 in w of 2 acos(w)/√(1−w²) = 2 Σ n!/(3/2)_n xⁿ, x = (1−w)/2 (lanes).
const LOG_FACTOR: [[f64; MAX_ORDER + 1]; 36] = {
    let mut table = [[0.0; MAX_ORDER + 1]; 36];
    let mut n = 0;
    let mut a = 2.0;
    while n < 36 + MAX_ORDER {
        // xⁿ contributes n!/(n−k)! (−½)^k to the term x^{n−k} of derivative k.
        let mut factor = a;
        let mut k = 0;
        while k <= MAX_ORDER && k <= n {
            if n - k < 36 {
                table[n - k][k] = factor;
            }
            factor *= -0.5 * (n - k) as f64;
            k += 1;
        }
        a *= (n + 1) as f64 / (n as f64 + 1.5);
        n += 1;
    }
    table
};

/// ψ/sin(ψ/2) as an analytic function of w = cos(ψ/2) on (−1, 1]: 2 acos(w)/√(1−w²).
///
/// The rotation vector of a unit quaternion (w, v) is `log_factor(w)` v; it grows without bound
/// as w → −1 (ψ → 2π). A w beyond 1 by round-off is continued smoothly.
#[must_use]
pub fn log_factor<S: Scalar>(w: S) -> S {
    let c = w.re();
    let x = 0.5 * (1.0 - c);
    let closed = |c: f64| 2.0 * c.acos() / ((1.0 - c) * (1.0 + c)).sqrt();
    if S::ORDER == 0 {
        // acos and the root are accurate to the last digit for any w < 1.
        let value = if c < 1.0 {
            closed(c)
        } else {
            2.0 + x * (4.0 / 3.0)
        };
        return S::constant(value);
    }
    if x < 0.25 {
        return w.compose(polynomials(&LOG_FACTOR, x));
    }
    let u = 1.0 / ((1.0 - c) * (1.0 + c));
    let f = closed(c);
    let f1 = (c * f - 2.0) * u;
    let f2 = (3.0 * c * f1 + f) * u;
    let f3 = (5.0 * c * f2 + 4.0 * f1) * u;
    w.compose([f, f1, f2, f3, (7.0 * c * f3 + 9.0 * f2) * u])
}
