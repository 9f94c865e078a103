//! Maps defined by equations.

#![allow(non_snake_case)]

mod charts;
mod flat;
mod linear;
mod map;
mod rank;
mod steep;

use pullback_manifold::map::Parametrization;

/// x, ẋ, ẍ, B, Ḃ and B̈.
fn motion(map: &dyn Parametrization, t: f64, motion: [&[f64]; 3]) -> [Vec<f64>; 6] {
    let (d, n) = map.dims();
    let mut all = [n, n, n, n * d, n * d, n * d].map(|len| vec![0.0; len]);
    let [x, x_dot, x_ddot, B, B_dot, B_ddot] = &mut all;
    let out = &mut [[&mut x[..], &mut B[..]], [x_dot, B_dot], [x_ddot, B_ddot]];
    map.duplicate().evaluate(t, motion, out);
    all
}

/// x and B.
fn tangent(map: &dyn Parametrization, t: f64, q: &[f64]) -> [Vec<f64>; 2] {
    let (d, n) = map.dims();
    let (mut x, mut B) = (vec![0.0; n], vec![0.0; n * d]);
    map.duplicate().tangent(t, q, &mut x, &mut B);
    [x, B]
}

fn gap(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let gaps = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    gaps.fold(0.0, |most, gap| if most > gap { most } else { gap })
}
