//! Characteristic polynomials: of a matrix, in closed form, and their roots.

use super::{Accuracy, FirstStep, Numbers};
use crate::dynamics::Scheme;
use crate::dynamics::scheme::Coefficients;
use num_complex::Complex;
use std::f64::consts::TAU;

/// The coefficients p of det(λ − A) = λ³ + p₁ λ² + p₂ λ + p₃.
pub fn characteristic(A: [[f64; 3]; 3]) -> [f64; 3] {
    let minor = |i: usize, j: usize| A[i][i] * A[j][j] - A[i][j] * A[j][i];
    let determinant = A[0][0] * minor(1, 2) - A[0][1] * (A[1][0] * A[2][2] - A[1][2] * A[2][0])
        + A[0][2] * (A[1][0] * A[2][1] - A[1][1] * A[2][0]);
    [
        -(A[0][0] + A[1][1] + A[2][2]),
        minor(0, 1) + minor(0, 2) + minor(1, 2),
        -determinant,
    ]
}

/// Closed form of the accuracy at Ω: for the generalised-α family from its coefficients (Chung & Hulbert
/// 1993, with all four of them free), with q̈₀ = −ω² q₀ in the first step; for Runge-Kutta methods from
/// λ (λ − R(iΩ)) (λ − R(−iΩ)) with their stability function R, which multiplies q − i q̇/ω. `None` for
/// other schemes.
pub fn closed_form(scheme: &Scheme, Omega: f64) -> Option<Accuracy> {
    let (polynomial, first_step) = if let Some(coefficients) = scheme.coefficients() {
        of_family(coefficients, Omega)
    } else {
        let stability = scheme.family()?.stability?;
        let R = stability(scheme, Complex::new(0.0, Omega));
        let first_step = FirstStep {
            from_rest: [R.re, -R.im],
            from_origin: [R.im, R.re],
        };
        ([-2.0 * R.re, R.norm_sqr(), 0.0], first_step)
    };
    Some(Accuracy {
        Omega,
        polynomial,
        numbers: Numbers::of(polynomial, Omega),
        first_step,
    })
}

/// The characteristic polynomial and the first step of the generalised-α family.
fn of_family(coefficients: Coefficients, Omega: f64) -> ([f64; 3], FirstStep) {
    let Coefficients {
        alpha_m: m,
        alpha_f: f,
        beta: b,
        gamma: g,
    } = coefficients;
    let W = Omega * Omega;
    let (m1, f1) = (1.0 - m, 1.0 - f);
    let p0 = m1 + f1 * b * W;
    let polynomial = [
        3.0 * m - 2.0 + W * (3.0 * f * b - f * g - 0.5 * f - 2.0 * b + g + 0.5),
        1.0 - 3.0 * m + W * (-3.0 * f * b + 2.0 * f * g + b - g + 0.5),
        m + W * (f * b - f * g + 0.5 * f),
    ];
    // (1 − α_m) y₁ + α_m y₀ = −W ((1 − α_f) q₁ + α_f q₀), y = h² a, with y₀ = −W q₀,
    // multiplied out so that nothing large cancels.
    let position = m1 + W * (b * (m - f) - m1 * (0.5 - b));
    let velocity = W * f1 * (0.5 * g - b) - m1;
    let first_step = FirstStep {
        from_rest: [position / p0, Omega * velocity / p0],
        from_origin: [Omega * m1 / p0, (m1 + W * f1 * (b - g)) / p0],
    };
    (polynomial.map(|p| p / p0), first_step)
}

/// κ and σ of the period elongation κ Ω² and the damping ratio σ Ω³ at small Ω, for schemes of order 2
/// and above: of the generalised-α family by Chung & Hulbert 1993, with all coefficients free; of
/// Runge-Kutta methods by ln R(z) = z + κ z³ − σ z⁴ + …, where λ = R(iΩ). `None` for other schemes.
pub fn expansion(scheme: &Scheme) -> Option<[f64; 2]> {
    if scheme.order() < 2 {
        return None;
    }
    if let Some(Coefficients {
        alpha_m: m,
        alpha_f: f,
        beta: b,
        ..
    }) = scheme.coefficients()
    {
        return Some([
            (12.0 * b - 1.0 - 12.0 * f * f + 12.0 * f * m) / 24.0,
            (f - m) * (b - f + f * m) / 2.0,
        ]);
    }
    let stability = scheme.family()?.stability?;
    // R = 1 + z + z²/2 + c₃ z³ + c₄ z⁴ + … by Cauchy's integrals over a circle inside its poles.
    let (radius, count) = (0.5, 64);
    let taylor = |order: i32| {
        let positions = (0..count).map(|j| TAU * f64::from(j) / f64::from(count));
        let terms = positions.map(|angle| {
            let R = stability(scheme, Complex::from_polar(radius, angle));
            R * Complex::from_polar(1.0, -f64::from(order) * angle)
        });
        terms.sum::<Complex<f64>>().re / f64::from(count) / radius.powi(order)
    };
    let (c3, c4) = (taylor(3), taylor(4));
    // Rounding errors count as zero.
    let clean = |x: f64| if x.abs() < 1e-14 { 0.0 } else { x };
    Some([c3 - 1.0 / 6.0, c3 - c4 - 0.125].map(clean))
}

/// The roots of λ³ + p₁ λ² + p₂ λ + p₃: a real one, then two real ones or a complex pair, positive
/// imaginary part first.
pub fn roots([p1, p2, p3]: [f64; 3]) -> [Complex<f64>; 3] {
    let value = |x: f64| ((x + p1) * x + p2) * x + p3;
    // A real root, by bisection down to neighbouring numbers.
    let bound = 1.0 + p1.abs().max(p2.abs()).max(p3.abs());
    let (mut low, mut high) = (-bound, bound);
    if value(0.0) > 0.0 {
        high = 0.0;
    } else {
        low = 0.0;
    }
    loop {
        let middle = 0.5 * (low + high);
        if !(middle > low && middle < high) {
            break;
        }
        if value(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    let real = if value(low).abs() <= value(high).abs() {
        low
    } else {
        high
    };
    // The remaining factor λ² − 2 b λ + c.
    let b = -0.5 * (p1 + real);
    let c = p2 + real * (p1 + real);
    let square = b * b - c;
    let rest = if square < 0.0 {
        let im = (-square).sqrt();
        [Complex::new(b, im), Complex::new(b, -im)]
    } else {
        let far = b + square.sqrt().copysign(b);
        let near = if far == 0.0 { 0.0 } else { c / far };
        [Complex::new(far, 0.0), Complex::new(near, 0.0)]
    };
    [Complex::new(real, 0.0), rest[0], rest[1]]
}
