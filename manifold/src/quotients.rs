//! Small-angle quotients: the only module that forms sin ψ/ψ and its relatives.
//!
//! With z = ψ² and D = (1/ψ) d/dψ = 2 d/dz, every coefficient of the rotation vector chart belongs
//! to one of three families of entire functions of z,
//!
//! ```text
//! b_n = (−D)ⁿ sin ψ/ψ          b₀ = sin ψ/ψ       b₁ = −c₁   b₂ = c₁′/ψ
//! e_n = (−D)ⁿ (1−cos ψ)/ψ²     e₀ = −c₄           e₁ = −c₂   e₂ = c₂′/ψ
//! f_n = (−D)ⁿ (ψ−sin ψ)/ψ³     f₀ = c₅            f₁ = −c₃   f₂ = c₃′/ψ
//! ```
//!
//! (b_n = j_n(ψ)/ψⁿ, spherical Bessel functions), tied by
//!
//! ```text
//! z b_{n+1} = (2n+1) b_n − b_{n−1},   z e_{n+1} = 2(n+1) e_n − b_n,   z f_{n+1} = 2(n+1) f_n − b_{n+1}.
//! ```
//!
//! Upwards these divide by z and amplify errors at small ψ, downwards they do not: below
//! [`SERIES_LIMIT`] the heads come from their Taylor series and the rest by descent, above it b₀, e₀,
//! f₀ come from sin ψ/2, cos ψ/2 and the rest by ascent. On [0, 2π) the relative error stays below
//! 1e-14 (1e-13 for the derivatives c₁′/ψ, c₂′/ψ, c₃′/ψ), also beside the zeros of c₁ and c₁′.
//!
//! T⁻¹ has poles at ψ = 2πn; its coefficients come from the partial fractions of the cotangent,
//! whose terms all have one sign.

mod inverse;

pub use inverse::{InverseQuotients, log_factor};

use crate::scalar::{MAX_ORDER, Scalar};

/// Values and derivatives of one function, up to the highest order.
type Orders = [f64; MAX_ORDER + 1];

/// The z = ψ² below which Taylor series are used (ψ ≈ 2.45).
pub const SERIES_LIMIT: f64 = 6.0;

/// Below this distance from a zero, b₁ and b₂ are expanded about it.
const WINDOW: f64 = 0.125;

/// A zero r of b₁ or b₂: nearest `f64`, remainder, and the factor of its addition formula.
struct Zero {
    high: f64,
    low: f64,
    factor: f64,
}

/// First zero of b₁ (tan r = r); the factor is cos r.
const ZERO_B1: Zero = Zero {
    high: 4.493_409_457_909_064,
    low: -3.322_828_416_974_956e-17,
    factor: -0.217_233_628_211_221_66,
};

/// First zero of b₂ (tan r = 3r/(3−r²)); the factor is sin r/(3r) = cos r/(3−r²).
const ZERO_B2: Zero = Zero {
    high: 5.763_459_196_894_55,
    low: 1.282_360_293_836_429_7e-16,
    factor: -0.028_723_631_387_302_467,
};

impl Zero {
    /// ψ − r if ψ lies in the window, correctly rounded even when ψ is the nearest `f64` to r.
    #[inline]
    fn offset(&self, psi: f64) -> Option<f64> {
        let d = psi - self.high;
        (d.abs() < WINDOW).then_some(d - self.low)
    }
}

/// ψ³ b₁ = sin ψ − ψ cos ψ at ψ = r + d, by the addition theorems with tan r = r eliminated:
/// every term carries d, so nothing cancels.
#[cold]
fn b1_near_zero(psi: f64, d: f64) -> f64 {
    let r = ZERO_B1.high;
    let (s, c) = d.sin_cos();
    ZERO_B1.factor * (s * (1.0 + r * r + r * d) - d * c) / (psi * psi * psi)
}

/// ψ⁵ b₂ = (3−ψ²) sin ψ − 3ψ cos ψ at ψ = r + d, as [`b1_near_zero`].
#[cold]
fn b2_near_zero(psi: f64, d: f64) -> f64 {
    let r = ZERO_B2.high;
    let r2 = r * r;
    let (s, c) = d.sin_cos();
    let along_s = r2 * r2 + 3.0 * r2 + 9.0 + d * (r * (3.0 + 2.0 * r2) + d * (r2 - 3.0));
    let along_c = -3.0 * d * (r2 + 3.0 + r * d);
    let z = psi * psi;
    ZERO_B2.factor * (s * along_s + c * along_c) / (z * z * psi)
}

/// Taylor coefficient number j in z of (−D)ⁿ Σ (−z)^j/(2j+m)!.
const fn coefficient(n: usize, m: usize, j: usize) -> f64 {
    let mut product = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut i = 1;
    while i <= n {
        product *= (2 * j + 2 * i) as f64;
        i += 1;
    }
    let mut factorial = 1.0;
    let mut i = 2;
    while i <= 2 * j + m + 2 * n {
        factorial *= i as f64;
        i += 1;
    }
    product / factorial
}

/// Taylor table of L functions (n, m), see [`coefficient`]; row j holds the terms z^j.
const fn taylor<const L: usize, const N: usize>(kind: [(usize, usize); L]) -> [[f64; L]; N] {
    let mut table = [[0.0; L]; N];
    let mut j = 0;
    while j < N {
        let mut l = 0;
        while l < L {
            table[j][l] = coefficient(kind[l].0, kind[l].1, j);
            l += 1;
        }
        j += 1;
    }
    table
}

/// b₂, b₃, e₃, f₃: first neglected term below 4e-18 of the value for z ≤ [`SERIES_LIMIT`].
const HEADS: [[f64; 4]; 12] = taylor([(2, 1), (3, 1), (3, 2), (3, 3)]);
/// b₄, e₄, f₄, needed for fourth derivatives only.
const FOURTH: [[f64; 3]; 12] = taylor([(4, 1), (4, 2), (4, 3)]);
/// b₀, e₀, f₀.
const VALUES: [[f64; 3]; 14] = taylor([(0, 1), (0, 2), (0, 3)]);

/// L polynomials at once (N even); even and odd terms run side by side to halve the latency.
#[inline]
fn polynomials<const L: usize, const N: usize>(table: &[[f64; L]; N], x: f64) -> [f64; L] {
    let x2 = x * x;
    let mut even = table[N - 2];
    let mut odd = table[N - 1];
    for pair in table[..N - 2].rchunks_exact(2) {
        for l in 0..L {
            even[l] = pair[0][l] + x2 * even[l];
            odd[l] = pair[1][l] + x2 * odd[l];
        }
    }
    for l in 0..L {
        even[l] += x * odd[l];
    }
    even
}

/// The three families up to order four.
struct Families {
    b: Orders,
    e: Orders,
    f: Orders,
}

/// All families at ψ ≥ 0. Inlined, so that a caller pays only for the orders it reads.
#[inline(always)]
fn families(psi: f64) -> Families {
    let z = psi * psi;
    if z < SERIES_LIMIT {
        let [b2, b3, e3, f3] = polynomials(&HEADS, z);
        let [b4, e4, f4] = polynomials(&FOURTH, z);
        let b1 = 5.0 * b2 - z * b3;
        let b0 = 3.0 * b1 - z * b2;
        let e2 = (b2 + z * e3) * (1.0 / 6.0);
        let f2 = (b3 + z * f3) * (1.0 / 6.0);
        let e1 = (b1 + z * e2) * 0.25;
        let f1 = (b2 + z * f2) * 0.25;
        let e0 = (b0 + z * e1) * 0.5;
        let f0 = (b1 + z * f1) * 0.5;
        return Families {
            b: [b0, b1, b2, b3, b4],
            e: [e0, e1, e2, e3, e4],
            f: [f0, f1, f2, f3, f4],
        };
    }
    // Half angles keep sin ψ near π and 1−cos ψ near 2π to full relative accuracy.
    let (s, c) = (0.5 * psi).sin_cos();
    let u = 1.0 / z;
    let cos = (c - s) * (c + s);
    let b0 = 2.0 * s * c * (u * psi);
    let e0 = 2.0 * s * s * u;
    let f0 = (1.0 - b0) * u;
    let b1 = match ZERO_B1.offset(psi) {
        Some(d) => b1_near_zero(psi, d),
        None => (b0 - cos) * u,
    };
    let b2 = match ZERO_B2.offset(psi) {
        Some(d) => b2_near_zero(psi, d),
        None => (3.0 * b1 - b0) * u,
    };
    let b3 = (5.0 * b2 - b1) * u;
    let e1 = (2.0 * e0 - b0) * u;
    let e2 = (4.0 * e1 - b1) * u;
    let e3 = (6.0 * e2 - b2) * u;
    let f1 = (2.0 * f0 - b1) * u;
    let f2 = (4.0 * f1 - b2) * u;
    let f3 = (6.0 * f2 - b3) * u;
    let b4 = (7.0 * b3 - b2) * u;
    let e4 = (8.0 * e3 - b3) * u;
    let f4 = (8.0 * f3 - b4) * u;
    Families {
        b: [b0, b1, b2, b3, b4],
        e: [e0, e1, e2, e3, e4],
        f: [f0, f1, f2, f3, f4],
    }
}

/// d^k/dz^k = (−½)^k (−D)^k.
#[inline]
fn in_z(f: Orders) -> Orders {
    [f[0], -0.5 * f[1], 0.25 * f[2], -0.125 * f[3], 0.0625 * f[4]]
}

/// What R, T and their derivative tensors C₁…C₅ need at one angle ψ; \[M04\] (45), (53).
///
/// The primed coefficients are divided by ψ: `dc1` = (dc₁/dψ)/ψ, smooth at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quotients {
    /// sin ψ/ψ.
    pub sinc: f64,
    /// (1 − cos ψ)/ψ².
    pub one_minus_cos: f64,
    /// c₁ = (ψ cos ψ − sin ψ)/ψ³.
    pub c1: f64,
    /// c₂ = (ψ sin ψ + 2 cos ψ − 2)/ψ⁴.
    pub c2: f64,
    /// c₃ = (3 sin ψ − 2ψ − ψ cos ψ)/ψ⁵ = c₅′/ψ.
    pub c3: f64,
    /// c₄ = (cos ψ − 1)/ψ².
    pub c4: f64,
    /// c₅ = (ψ − sin ψ)/ψ³.
    pub c5: f64,
    /// c₁′/ψ.
    pub dc1: f64,
    /// c₂′/ψ.
    pub dc2: f64,
    /// c₃′/ψ.
    pub dc3: f64,
}

impl Quotients {
    /// All of them at the angle ψ ≥ 0.
    #[must_use]
    pub fn new(psi: f64) -> Self {
        let Families { b, e, f } = families(psi);
        Self {
            sinc: b[0],
            one_minus_cos: e[0],
            c1: -b[1],
            c2: -e[1],
            c3: -f[1],
            c4: -e[0],
            c5: f[0],
            dc1: b[2],
            dc2: e[2],
            dc3: f[2],
        }
    }

    /// The three of them that R and T need.
    #[inline]
    #[must_use]
    pub fn tangent(&self) -> TangentQuotients<f64> {
        TangentQuotients {
            sinc: self.sinc,
            one_minus_cos: self.one_minus_cos,
            psi_minus_sin: self.c5,
        }
    }
}

/// What R and T alone need, as functions of z = ψ²; \[M04\] Def 14, (21).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentQuotients<S> {
    /// sin ψ/ψ.
    pub sinc: S,
    /// (1 − cos ψ)/ψ².
    pub one_minus_cos: S,
    /// (ψ − sin ψ)/ψ³.
    pub psi_minus_sin: S,
}

impl<S: Scalar> TangentQuotients<S> {
    /// At z = ψ² ≥ 0, with all derivatives that `S` carries, also at zero.
    #[inline]
    #[must_use]
    pub fn new(z: S) -> Self {
        let psi = z.re().sqrt();
        if S::ORDER == 0 {
            let [b, e, f] = tangent_values(psi);
            return Self {
                sinc: S::constant(b),
                one_minus_cos: S::constant(e),
                psi_minus_sin: S::constant(f),
            };
        }
        let Families { b, e, f } = families(psi);
        Self {
            sinc: z.compose(in_z(b)),
            one_minus_cos: z.compose(in_z(e)),
            psi_minus_sin: z.compose(in_z(f)),
        }
    }
}

/// b₀, e₀, f₀ at ψ ≥ 0 without their derivatives.
fn tangent_values(psi: f64) -> [f64; 3] {
    let z = psi * psi;
    if z < SERIES_LIMIT {
        return polynomials(&VALUES, z);
    }
    let (s, c) = (0.5 * psi).sin_cos();
    let u = 1.0 / z;
    let b0 = 2.0 * s * c * (u * psi);
    [b0, 2.0 * s * s * u, (1.0 - b0) * u]
}

/// sin √z/√z.
#[inline]
#[must_use]
pub fn sinc<S: Scalar>(z: S) -> S {
    TangentQuotients::new(z).sinc
}

/// cos √z; D cos ψ = −b₀, so its derivatives are those of the first family.
#[must_use]
pub fn cos_sqrt<S: Scalar>(z: S) -> S {
    let psi = z.re().sqrt();
    if S::ORDER == 0 {
        return S::constant(psi.cos());
    }
    let b = families(psi).b;
    z.compose(in_z([psi.cos(), b[0], b[1], b[2], b[3]]))
}

/// (cos ψ/2, sin(ψ/2)/ψ) from z = ψ²: the parts of a unit quaternion, no root at zero.
#[inline]
#[must_use]
pub fn half_angle<S: Scalar>(z: S) -> (S, S) {
    let quarter = z * 0.25;
    (cos_sqrt(quarter), sinc(quarter) * 0.5)
}
