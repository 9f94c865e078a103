//! Products and sums of vectors.

/// xᵀ y.
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    // Four sums, which a processor adds at the same time.
    let (xs, x_rest) = x.as_chunks::<4>();
    let (ys, y_rest) = y.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (x, y) in xs.iter().zip(ys) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}

/// y ← y + α x.
pub(crate) fn add(y: &mut [f64], alpha: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += alpha * x;
    }
}

/// A vector without symmetry, so that it is orthogonal to no mode.
pub(crate) fn generic(n: usize) -> Vec<f64> {
    let part = |i: usize| (i * 7919 % 1009) as f64 / 1009.0;
    (0..n).map(|i| 1.0 + 0.5 * part(i)).collect()
}
