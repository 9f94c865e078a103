//! Lagrange shape functions on equidistant nodes and Gauss–Legendre points on [−1, 1].

/// Values and derivatives (with respect to ξ) of the `N` Lagrange polynomials at ξ.
pub(crate) fn lagrange<const N: usize>(xi: f64) -> ([f64; N], [f64; N]) {
    let node = |i: usize| -1.0 + 2.0 * i as f64 / (N - 1) as f64;
    let mut value = [1.0; N];
    let mut slope = [0.0; N];
    for i in 0..N {
        for k in (0..N).filter(|&k| k != i) {
            let factor = 1.0 / (node(i) - node(k));
            slope[i] = slope[i] * (xi - node(k)) * factor + value[i] * factor;
            value[i] *= (xi - node(k)) * factor;
        }
    }
    (value, slope)
}

/// Points and weights of the rule with `n` = 1…4 points, exact to degree 2n − 1.
pub(crate) fn gauss(n: usize) -> Vec<(f64, f64)> {
    match n {
        1 => vec![(0.0, 2.0)],
        2 => {
            let x = (1.0_f64 / 3.0).sqrt();
            vec![(-x, 1.0), (x, 1.0)]
        }
        3 => {
            let x = 0.6_f64.sqrt();
            vec![(-x, 5.0 / 9.0), (0.0, 8.0 / 9.0), (x, 5.0 / 9.0)]
        }
        _ => {
            let r = 2.0 / 7.0 * 1.2_f64.sqrt();
            let (x, y) = ((3.0 / 7.0 - r).sqrt(), (3.0 / 7.0 + r).sqrt());
            let s = 30.0_f64.sqrt();
            let (p, q) = ((18.0 + s) / 36.0, (18.0 - s) / 36.0);
            vec![(-y, q), (-x, p), (x, p), (y, q)]
        }
    }
}
