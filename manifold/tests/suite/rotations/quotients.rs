//! The quotients against an independent double-double oracle and a table of 30 digits.
//!
//! Bounds are relative to the value itself, also beside its zeros.

use crate::support::double_double::{Dd, series};
use crate::support::*;
use approx::{assert_abs_diff_eq, assert_relative_eq};

const NAMES: [&str; 14] = [
    "sinc",
    "one_minus_cos",
    "c1",
    "c2",
    "c3",
    "c4",
    "c5",
    "dc1",
    "dc2",
    "dc3",
    "g",
    "a3",
    "a1",
    "a2",
];

fn bound(name: &str) -> f64 {
    match name {
        "dc1" | "dc2" | "dc3" | "a1" | "a2" => 1e-13,
        _ => 1e-14,
    }
}

fn evaluate(psi: f64) -> [f64; 14] {
    let q = Quotients::new(psi);
    let a = InverseQuotients::new(psi);
    [
        q.sinc,
        q.one_minus_cos,
        q.c1,
        q.c2,
        q.c3,
        q.c4,
        q.c5,
        q.dc1,
        q.dc2,
        q.dc3,
        a.g,
        a.a3,
        a.a1,
        a.a2,
    ]
}

fn oracle(psi: Dd) -> [Dd; 14] {
    let z = psi * psi;
    let quarter = z * Dd(0.25, 0.0);
    let s = series(0, 1, quarter);
    let s2 = s * s;
    let f0 = series(0, 3, z);
    // (S5 − 4 S6), the numerator of a₂: Σ (−z)^j (2j+2)/(2j+6)! = Σ (−z)^j/(2j+5)! − 4 Σ (−z)^j/(2j+6)!.
    let numerator = series(0, 5, z) + series(0, 6, z) * Dd(-4.0, 0.0);
    [
        series(0, 1, z),
        series(0, 2, z),
        -series(1, 1, z),
        -series(1, 2, z),
        -series(1, 3, z),
        -series(0, 2, z),
        f0,
        series(2, 1, z),
        series(2, 2, z),
        series(2, 3, z),
        series(0, 0, quarter) / s,
        series(1, 1, quarter) / (s * Dd(4.0, 0.0)),
        -(f0 / s2),
        numerator / s2,
    ]
}

fn relative(value: f64, exact: Dd) -> f64 {
    let d = Dd(value, 0.0) + -exact;
    (d.0 / exact.0).abs()
}

/// A value and its first derivatives, relative to themselves.
fn close(what: &str, found: [f64; 4], exact: [Dd; 4]) {
    for (n, tolerance) in [1e-14, 1e-13, 1e-13, 1e-13].into_iter().enumerate() {
        let error = relative(found[n], exact[n]);
        assert!(error <= tolerance, "{what}, derivative {n}: {error:e}");
    }
}

fn table_name(name: &str) -> String {
    if name.starts_with('d') {
        format!("{name}_over_psi")
    } else {
        name.to_owned()
    }
}

/// The decimal of the table, which need not be an `f64`.
fn decimal(text: &str) -> Dd {
    let (digits, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa: f64 = format!("{whole}{fraction}").parse().expect("digits");
    let positions = fraction.len() as i32 - exponent.parse::<i32>().expect("exponent");
    Dd(mantissa, 0.0) / Dd(10f64.powi(positions), 0.0)
}

/// The oracle, with which the quotients agree everywhere.
#[test]
fn the_oracle_is_the_table() {
    let table = include_str!("../../../../tests/reference/so3_coefficients.json");
    let data: serde_json::Value = serde_json::from_str(table).expect("valid JSON");
    let rows = data["values"].as_array().expect("rows");
    assert_eq!(rows.len(), 30);
    for row in rows {
        let text = |key: &str| row[key].as_str().expect("decimal text");
        let psi = text("psi");
        for (name, exact) in NAMES.iter().zip(oracle(decimal(psi))) {
            let expected = text(&table_name(name)).parse().expect("a number");
            let error = relative(expected, exact);
            assert!(error <= 2e-16, "{name} at {psi}: {error:e}");
        }
    }
    let limits = &data["limits_at_zero"];
    for (name, exact) in NAMES.iter().zip(oracle(Dd(0.0, 0.0))) {
        let text = limits[table_name(name)].as_str().expect("fraction");
        let (p, q) = text.split_once('/').unwrap_or((text, "1"));
        let expected = p.parse::<f64>().expect("p") / q.parse::<f64>().expect("q");
        assert!(relative(expected, exact) <= 2e-16, "{name} at 0");
    }
}

/// Sweep points: dense, and by units in the last position and upwards around every threshold and zero.
fn sweep() -> Vec<f64> {
    let edge = TAU - 0.1;
    let n = 30_000;
    let mut points: Vec<f64> = (0..=n)
        .map(|i| edge * f64::from(i) / f64::from(n))
        .collect();
    let zeros = [PI, 4.493_409_457_909_064, 5.763_459_196_894_55];
    let mut centres = vec![SERIES_LIMIT.sqrt()];
    for r in zeros {
        centres.extend([r, r - 0.125, r + 0.125]);
    }
    for c in centres {
        let mut step = f64::EPSILON * c;
        for k in 0..200 {
            points.extend([c + step * f64::from(k), c - step * f64::from(k)]);
        }
        while step < 0.2 {
            points.extend([c + step, c - step]);
            step *= 1.25;
        }
    }
    points.extend((0..300).map(|i| 2.0 * 10f64.powi(-i)));
    points.retain(|&p| (0.0..=edge).contains(&p));
    points
}

#[test]
fn agree_with_the_oracle_everywhere() {
    for psi in sweep() {
        let exact = oracle(Dd(psi, 0.0));
        for (k, value) in evaluate(psi).into_iter().enumerate() {
            let (error, name) = (relative(value, exact[k]), NAMES[k]);
            assert!(error <= bound(name), "{name} at {psi:?}: {error:e}");
        }
        let t = TangentQuotients::new(psi * psi);
        // As functions of z: relative to the largest value, z itself being rounded.
        for (value, k) in [(t.sinc, 0), (t.one_minus_cos, 1), (t.psi_minus_sin, 6)] {
            let error = (value - exact[k].0).abs();
            assert!(error <= 4e-16, "{} of z, {psi}", NAMES[k]);
        }
    }
}

/// Value and three derivatives in z of a function, by a nested jet.
macro_rules! derivatives {
    ($f:expr, $x:expr) => {{
        type G<S> = Grad<S, 1>;
        let x = G::variable(G::variable(G::<f64>::variable($x, 0), 0), 0);
        let y: G<G<G<f64>>> = $f(x);
        assert!((y.v.v.g[0] - y.g[0].v.v).abs() <= 1e-15 * y.g[0].v.v.abs());
        [y.v.v.v, y.g[0].v.v, y.g[0].g[0].v, y.g[0].g[0].g[0]]
    }};
}

#[test]
fn derivatives_in_z_are_exact() {
    let mut points: Vec<f64> = (0..2000).map(|i| f64::from(i) * 0.0191).collect();
    points.extend([
        SERIES_LIMIT,
        SERIES_LIMIT.next_down(),
        1e-8,
        1e-300,
        4.0 * SERIES_LIMIT,
    ]);
    for z in points {
        let exact = |m: usize, z: f64| {
            let z = Dd(z, 0.0);
            std::array::from_fn::<f64, 4, _>(|n| series(n, m, z).0 * (-0.5f64).powi(n as i32))
        };
        // Here z is the argument and its root is rounded, so a bound relative to the value would
        // fail beside a zero; relative to the limit at z = 0, the largest value, it is fair.
        let check = |name: &str, value: [f64; 4], m: usize, z: f64| {
            let (e, limit) = (exact(m, z), exact(m, 0.0));
            for n in 0..4 {
                let error = (value[n] - e[n]).abs() / limit[n].abs();
                let tolerance = if n == 0 { 1e-14 } else { 1e-13 };
                assert!(
                    error <= tolerance,
                    "{name} derivative {n} at z = {z}: {error:e}"
                );
            }
        };
        check("sinc", derivatives!(sinc, z), 1, z);
        let value = derivatives!(|z| TangentQuotients::new(z).one_minus_cos, z);
        check("one_minus_cos", value, 2, z);
        let value = derivatives!(|z| TangentQuotients::new(z).psi_minus_sin, z);
        check("psi_minus_sin", value, 3, z);
        // cos √z has D cos ψ = −sin ψ/ψ: derivative n of it is −½ derivative n−1 of sinc.
        let c = derivatives!(cos_sqrt, z);
        let s = exact(1, z);
        assert_abs_diff_eq!(c[0], z.sqrt().cos(), epsilon = 4e-16);
        for n in 1..4 {
            assert!((c[n] + 0.5 * s[n - 1]).abs() <= 1e-14, "cos {n} at {z}");
        }
        let (w, f) = half_angle(z);
        assert_abs_diff_eq!(w, (0.5 * z.sqrt()).cos(), epsilon = 3e-16);
        assert_abs_diff_eq!(f, 0.5 * exact(1, 0.25 * z)[0], epsilon = 3e-16);
    }
}

#[test]
fn log_factor_is_exact() {
    // L(cos h) = 2h/sin h, and (1−w²)L′ = wL − 2, (1−w²)L″ = 3wL′ + L, (1−w²)L‴ = 5wL″ + 4L′,
    // whose cancellation near w = 1 double-double outweighs.
    let mut points: Vec<f64> = (1..3000).map(|i| 1.0 - f64::from(i) / 1550.0).collect();
    points.extend([
        0.5,
        0.5f64.next_up(),
        0.5f64.next_down(),
        1.0 - 1e-3,
        1.0 - 1e-4,
    ]);
    for w in points {
        let k = |v: f64| Dd(v, 0.0);
        // h = acos w to double-double by Newton steps on the series of the cosine.
        let mut h = k(w.acos());
        for _ in 0..3 {
            let z = h * h;
            h = h + (series(0, 0, z) + k(-w)) / (h * series(0, 1, z));
        }
        let s2 = k(1.0) + -(k(w) * k(w));
        let f = k(2.0) / series(0, 1, h * h);
        let f1 = (k(w) * f + k(-2.0)) / s2;
        let f2 = (k(3.0) * k(w) * f1 + f) / s2;
        let f3 = (k(5.0) * k(w) * f2 + k(4.0) * f1) / s2;
        let value = derivatives!(log_factor, w);
        close(&format!("log_factor at w = {w}"), value, [f, f1, f2, f3]);
        assert!(relative(log_factor(w), f) <= 1e-14);
    }
    // At w = 1: 2 Σ n!/(3/2)_n ((1−w)/2)^n, terms 1, 2/3 x, 8/15 x², 16/35 x³.
    let at_one = derivatives!(log_factor, 1.0);
    let limits = [2.0, -2.0 / 3.0, 8.0 / 15.0, -24.0 / 35.0];
    for n in 0..4 {
        assert_relative_eq!(at_one[n], limits[n], epsilon = 0.0, max_relative = 1e-15);
    }
    let beyond = 1.0 + 4.0 * f64::EPSILON;
    assert!((log_factor(beyond) - (2.0 - (beyond - 1.0) * 2.0 / 3.0)).abs() < 1e-15);
}
