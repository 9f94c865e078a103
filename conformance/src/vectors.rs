//! Arithmetic on slices.

/// The Euclidean norm.
pub(crate) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(crate) fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The product of a matrix of `rows` rows, column by column, and a vector.
pub(crate) fn times(A: &[f64], d: &[f64], rows: usize) -> Vec<f64> {
    let mut out = vec![0.0; rows];
    for (column, d) in A.chunks_exact(rows.max(1)).zip(d) {
        add(&mut out, column, *d);
    }
    out
}

/// Adds a vector times a factor.
pub(crate) fn add(to: &mut [f64], x: &[f64], factor: f64) {
    to.iter_mut().zip(x).for_each(|(to, x)| *to += x * factor);
}

/// The difference of two vectors over the size of the second one, `unit` included.
pub(crate) fn relative(found: &[f64], exact: &[f64], unit: f64) -> f64 {
    norm(&minus(found, exact)) / (norm(exact) + unit)
}

/// The larger number; NaN if one of them is.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}
