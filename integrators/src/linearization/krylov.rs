//! Krylov subspaces of an operator that is applied to one vector at a time.
//!
//! Vectors are multiplied by the operator in the order in which they came, and the part of each product that is new is
//! appended (band Arnoldi method; Ruhe 1979, Math. Comp. 33). A start vector may
//! be added at any time, as a second copy of a repeated eigenvalue needs one; with all unit
//! vectors at the beginning the method is dense. The inner product xᵀ G y may be semi-definite: vectors
//! without length are dropped, and with them infinite eigenvalues of a pencil with the singular mass
//! matrix G (Nour-Omid, Parlett, Ericsson & Jensen 1987, Math. Comp. 48). Products and eigenvalues of dense matrices are faer's.

use super::inner_product;
use crate::random::Random;
use crate::registers::clear_upper_halves;
use crate::vectors::{add, dot};
use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, EvdParams, evd_real, evd_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::Solve;
use faer::{Accum, Col, ColMut, ColRef, Mat, MatRef, Par, Scale, Side, Spec};
use num_complex::Complex64;

/// Square of the length that a product must keep to count as a new direction, relative to its own.
const NEW: f64 = 1e-26;
/// The same for start vectors, whose lengths may have cancelled.
const INDEPENDENT: f64 = 1e-14;
/// Square of the part removed, relative to what is left, of a pass whose rounding errors are no more than those of w.
const SMALL: f64 = 1e-4;
/// Most passes: two suffice unless a vector vanishes.
const PASSES: usize = 3;
/// Largest residual of an eigenvector of a dense matrix, relative to its norm and size, that is one of rounding; it is
/// evaluated where the residual outside of the matrix, relative to the eigenvalue, is small.
const TRUSTED: f64 = 64.0 * f64::EPSILON;
const NEAR: f64 = 1e-6;
/// Relative difference of eigenvalues that are one, and square of the part of a vector of length one that others leave, of which
/// it is no combination.
const REPEATED: f64 = 1e-12;
const DEPENDENT: f64 = 1e-4;
/// Number of vectors that memory is reserved for.
const RESERVED: usize = 32;

/// Adds G w to its second argument.
type Gram<'a> = dyn Fn(&[f64], &mut [f64]) + 'a;

/// An orthonormal basis, and the operator in it.
pub(crate) struct Krylov<'a> {
    pub gram: Box<Gram<'a>>,
    /// Whether the operator is self-adjoint: coefficients of earlier vectors are then known.
    symmetric: bool,
    /// One vector after the other.
    basis: Vec<f64>,
    /// G v of each of them: a projection then needs no product.
    images: Vec<f64>,
    /// Length of a vector.
    dim: usize,
    /// Largest number of independent vectors.
    most: usize,
    /// Number of first vectors that are not multiplied.
    locked: usize,
    /// Coefficients of A v of the others in the basis.
    columns: Vec<Vec<f64>>,
    /// Whether a product added no direction: what it had without length is in no column.
    dropped: bool,
}

impl<'a> Krylov<'a> {
    /// An empty basis of vectors of a length, of which at most so many are independent: what is left of others is
    /// rounding errors.
    pub fn new(
        [dim, most]: [usize; 2],
        symmetric: bool,
        gram: impl Fn(&[f64], &mut [f64]) + 'a,
    ) -> Self {
        Self {
            gram: Box::new(gram),
            symmetric,
            basis: Vec::with_capacity(RESERVED * dim),
            images: Vec::with_capacity(RESERVED * dim),
            dim,
            most,
            locked: 0,
            columns: Vec::new(),
            dropped: false,
        }
    }

    /// Number of vectors that have been multiplied.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether the basis is invariant: nothing is left to multiply.
    pub fn is_exhausted(&self) -> bool {
        self.locked + self.columns.len() == self.basis().ncols()
    }

    /// The basis, a vector in each column.
    fn basis(&self) -> MatRef<'_, f64> {
        columns(&self.basis, self.dim)
    }

    /// Leaves the vectors so far, which span a space that the operator maps to itself, out of the search for others.
    pub fn lock(&mut self) {
        self.locked = self.basis().ncols();
    }

    /// Adds a start vector; false if the basis contains it.
    pub fn add(&mut self, w: Vec<f64>) -> bool {
        let before = self.basis().ncols();
        let coefficients = self.append(w, vec![0.0; before], INDEPENDENT);
        coefficients.len() > before
    }

    /// The next vector v to multiply, and G v.
    pub fn next(&self) -> Option<(&[f64], &[f64])> {
        let first = (self.locked + self.columns.len()) * self.dim;
        let next = first..first + self.dim;
        Some((self.basis.get(next.clone())?, &self.images[next]))
    }

    /// Takes the product of the operator and [`Krylov::next`].
    pub fn take(&mut self, mut product: Vec<f64>) {
        let j = self.locked + self.columns.len();
        let before = self.basis().ncols();
        let mut known = vec![0.0; before];
        if self.symmetric {
            for (known, column) in known[self.locked..].iter_mut().zip(&self.columns) {
                *known = column.get(j).copied().unwrap_or(0.0);
            }
            known[j] = dot(&product, &self.images[j * self.dim..][..self.dim]);
            for (v, known) in self.basis.chunks_exact(self.dim).zip(&known) {
                if *known != 0.0 {
                    add(&mut product, -known, v);
                }
            }
        } else {
            // Most of the product is in the basis: it is measured after a first pass.
            let images = columns(&self.images, self.dim);
            project(self.basis(), images, &mut product, &mut known);
        }
        let column = self.append(product, known, NEW);
        self.dropped |= column.len() == before;
        self.columns.push(column);
    }

    /// Orthogonalises a vector, less the part of it with known coefficients, and appends what is left; returns
    /// all coefficients.
    fn append(&mut self, mut w: Vec<f64>, mut coefficients: Vec<f64>, least: f64) -> Vec<f64> {
        let end = self.images.len();
        self.images.resize(end + self.dim, 0.0);
        let (images, Gw) = self.images.split_at_mut(end);
        let (basis, images) = (columns(&self.basis, self.dim), columns(images, self.dim));
        let mut left = 0.0;
        for _ in 0..PASSES {
            let square = project(basis, images, &mut w, &mut coefficients);
            Gw.fill(0.0);
            (self.gram)(&w, Gw);
            left = dot(&w, Gw);
            // The next pass removes what this one leaves by rounding errors.
            if square <= SMALL * left {
                break;
            }
        }
        let is_new = left > least * (left + dot(&coefficients, &coefficients));
        if is_new && coefficients.len() < self.most {
            let length = left.sqrt();
            Gw.iter_mut().for_each(|x| *x /= length);
            self.basis.extend(w.iter().map(|x| x / length));
            coefficients.push(length);
        } else {
            self.images.truncate(end);
        }
        coefficients
    }

    /// Eigenvalues of the operator within the basis, the largest first; `None` if the dense solver fails.
    pub fn ritz(&self) -> Option<Vec<RitzPair>> {
        let columns: Vec<_> = self.columns.iter().map(|c| &c[self.locked..]).collect();
        ritz_pairs(&columns, self.symmetric)
    }

    /// A x of the vectors x with these coefficients, without a product; `None` if a part of it was dropped.
    pub fn images(&self, coefficients: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let image = |x: &Vec<f64>| {
            let mut y = vec![0.0; self.basis().ncols()];
            for (column, x) in self.columns.iter().zip(x) {
                add(&mut y, *x, column);
            }
            y
        };
        (!self.dropped).then(|| {
            let images: Vec<_> = coefficients.iter().map(image).collect();
            self.combine(&images)
        })
    }

    /// The vectors with these coefficients in the basis.
    pub fn combine(&self, coefficients: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = self.basis().ncols();
        let entry = |i: usize, j: usize| coefficients[j].get(i).copied().unwrap_or(0.0);
        let vectors = self.basis() * Mat::from_fn(count, coefficients.len(), entry);
        clear_upper_halves();
        vectors
            .col_iter()
            .map(|x| x.iter().copied().collect())
            .collect()
    }
}

/// Removes from a vector its part in a basis with these images, adds the coefficients of that part, and returns the sum of
/// their squares.
fn project(
    basis: MatRef<'_, f64>,
    images: MatRef<'_, f64>,
    w: &mut [f64],
    coefficients: &mut [f64],
) -> f64 {
    let parts = images.transpose() * ColRef::from_slice(w);
    let w = ColMut::from_slice_mut(w);
    matmul(w, Accum::Add, basis, &parts, -1.0, Par::Seq);
    clear_upper_halves();
    for (c, part) in coefficients.iter_mut().zip(parts.iter()) {
        *c += part;
    }
    parts.squared_norm_l2()
}

/// Vectors of a length, one after the other, as the columns of a matrix.
fn columns(vectors: &[f64], dim: usize) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(vectors, dim, vectors.len() / dim.max(1))
}

/// An approximate eigenvalue of an operator, and its eigenvector in a basis.
pub(crate) struct RitzPair {
    /// The eigenvalue.
    pub theta: Complex64,
    /// Coefficients of the eigenvector, of length one.
    pub vector: Vec<Complex64>,
    /// Length of A x − θ x.
    pub residual: f64,
}

/// An eigenvector of length one, by inverse iteration from a pseudo-random vector: back-substitution fails for repeated
/// eigenvalues.
fn inverse_iteration(H: &Mat<f64>, theta: Complex64, seed: u64) -> Vec<Complex64> {
    let n = H.nrows();
    let mut random = Random(seed);
    let start = Col::from_fn(n, |_| Complex64::from(random.next()));
    let mut x = start.clone();
    // Of a defective eigenvalue, as of critical damping, the matrix is singular to the last digit at the lesser distance.
    for distance in [f64::EPSILON, f64::EPSILON.sqrt()] {
        let shift = theta + distance * H.norm_l2();
        let shifted = Mat::from_fn(n, n, |i, j| match i == j {
            true => H[(i, j)] - shift,
            false => H[(i, j)].into(),
        });
        let lu = shifted.partial_piv_lu();
        x.clone_from(&start);
        for _ in 0..2 {
            x = lu.solve(&x);
            x = &x * Scale(x.norm_l2().recip().into());
        }
        if x.iter().all(|x| x.is_finite()) {
            break;
        }
    }
    clear_upper_halves();
    x.iter().copied().collect()
}

/// Eigenvalues and eigenvectors of length one; `None` if the iteration fails.
///
/// By the QR iteration with two shifts. That with many shifts in faer 0.24 sorts eigenvalues in a loop that may not end where
/// many are almost equal.
fn eigenpairs(H: &Mat<f64>) -> Option<Vec<(Complex64, Vec<Complex64>)>> {
    let n = H.nrows();
    let mut params: Spec<EvdParams, f64> = Spec::default();
    params.schur.blocking_threshold = usize::MAX;
    let [none, all] = [ComputeEigenvectors::No, ComputeEigenvectors::Yes];
    let mut memory = MemBuffer::new(evd_scratch::<f64>(n, none, all, Par::Seq, params));
    let (stack, mut U) = (MemStack::new(&mut memory), Mat::zeros(n, n));
    let [mut re, mut im] = [Diag::zeros(n), Diag::zeros(n)];
    let (real, imaginary) = (re.as_mut(), im.as_mut());
    evd_real(
        H.as_ref(),
        real,
        imaginary,
        None,
        Some(U.as_mut()),
        Par::Seq,
        stack,
        params,
    )
    .ok()?;
    let mut pairs = Vec::with_capacity(n);
    while let k = pairs.len()
        && k < n
    {
        // The columns of a pair are the real and the imaginary part of its first vector.
        let next = (k + 1).min(n - 1);
        let part = if im[k] == 0.0 { 0.0 } else { 1.0 };
        let column = (0..n).map(|i| Complex64::new(U[(i, k)], part * U[(i, next)]));
        let length = column.clone().map(|x| x.norm_sqr()).sum::<f64>().sqrt();
        let vector: Vec<Complex64> = column.map(|x| x / length).collect();
        let conjugate = vector.iter().map(|x| x.conj()).collect();
        let theta = Complex64::new(re[k], im[k]);
        pairs.push((theta, vector));
        if im[k] != 0.0 {
            pairs.push((theta.conj(), conjugate));
        }
    }
    Some(pairs)
}

/// Eigenvalues of the upper square of the matrix with these columns, the largest magnitude first; the rows
/// below give the residuals. `None` if the iteration fails.
fn ritz_pairs(columns: &[&[f64]], symmetric: bool) -> Option<Vec<RitzPair>> {
    let n = columns.len();
    let entry = |i: usize, j: usize| columns[j].get(i).copied().unwrap_or(0.0);
    if !(0..n).all(|j| columns[j].iter().all(|x| x.is_finite())) {
        return None;
    }
    let mut pairs: Vec<(Complex64, Vec<Complex64>)> = if symmetric {
        let H = Mat::from_fn(n, n, |i, j| 0.5 * (entry(i, j) + entry(j, i)));
        let pairs = H.self_adjoint_eigen(Side::Lower).ok()?;
        let vector = |k: usize| (0..n).map(|i| pairs.U()[(i, k)].into()).collect();
        (0..n).map(|k| (pairs.S()[k].into(), vector(k))).collect()
    } else {
        eigenpairs(&Mat::from_fn(n, n, entry))?
    };
    clear_upper_halves();
    pairs.sort_by(|a, b| b.0.norm().total_cmp(&a.0.norm()));
    let height = columns.iter().map(|c| c.len()).max().unwrap_or(0);
    let residual = |s: &[Complex64]| {
        let row = |i: usize| s.iter().enumerate().map(move |(j, s)| *s * entry(i, j));
        let squares = (n..height).map(|i| row(i).sum::<Complex64>().norm_sqr());
        squares.sum::<f64>().sqrt()
    };
    let size = columns
        .iter()
        .copied()
        .flatten()
        .map(|x| x * x)
        .sum::<f64>()
        .sqrt();
    let error = |theta: Complex64, s: &[Complex64]| {
        let mut error: Vec<Complex64> = s.iter().map(|s| -theta * s).collect();
        for (column, s) in columns.iter().zip(s) {
            error.iter_mut().zip(*column).for_each(|(e, h)| *e += s * h);
        }
        error.iter().map(|e| e.norm_sqr()).sum::<f64>().sqrt()
    };
    let thetas: Vec<Complex64> = pairs.iter().map(|p| p.0).collect();
    let mut found: Vec<RitzPair> = Vec::with_capacity(n);
    for (k, (theta, mut vector)) in pairs.into_iter().enumerate() {
        let mut below = residual(&vector);
        // The vector of a repeated eigenvalue may be wrong, and its residual large.
        let near = |i: usize| i != k && (thetas[i] - theta).norm() <= NEAR * theta.norm();
        let is_repeated = (k.saturating_sub(3)..(k + 4).min(n)).any(near);
        let is_far = symmetric || below > NEAR * theta.norm() && !is_repeated;
        // Not if it is not a number.
        let is_right = is_far
            || error(theta, &vector) <= TRUSTED * n as f64 * size
                && is_independent(theta, &vector, &found);
        if !is_right {
            vector = inverse_iteration(&Mat::from_fn(n, n, entry), theta, k as u64);
            below = residual(&vector);
        }
        found.push(RitzPair {
            theta,
            residual: below,
            vector,
        });
    }
    Some(found)
}

/// Whether a vector is no combination of those found before with the same eigenvalue.
fn is_independent(theta: Complex64, vector: &[Complex64], found: &[RitzPair]) -> bool {
    let same = |pair: &&RitzPair| (pair.theta - theta).norm() <= REPEATED * theta.norm();
    let mut basis: Vec<Vec<Complex64>> = Vec::new();
    let others = found.iter().filter(same).map(|pair| &pair.vector[..]);
    let mut left = 1.0;
    for own in others.chain([vector]) {
        let mut own = own.to_vec();
        for unit in &basis {
            let part = inner_product(unit, &own);
            own.iter_mut().zip(unit).for_each(|(x, u)| *x -= part * u);
        }
        left = own.iter().map(|x| x.norm_sqr()).sum();
        let length = f64::sqrt(left).max(f64::MIN_POSITIVE);
        own.iter_mut().for_each(|x| *x /= length);
        basis.push(own);
    }
    left > DEPENDENT
}
