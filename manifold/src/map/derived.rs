//! Everything that follows from φ by differentiation; the reference for hand-derived closed forms.

use super::{Kinematics, Map, Tangent};
use crate::jet::{Grad, Hess, Moving, Trace};
use crate::scalar::Scalar;
use nalgebra::{SMatrix, SVector};

/// x and B by one run over gradients.
pub fn tangent<const D: usize, const N: usize>(
    map: &(impl Map<D, N> + ?Sized),
    t: f64,
    q: &SVector<f64, D>,
) -> Tangent<D, N> {
    let q = SVector::<Grad<f64, D>, D>::from_fn(|i, _| Grad::variable(q[i], i));
    let x = map.phi(Grad::constant(t), &q);
    Tangent {
        x: x.map(|x| x.v),
        B: SMatrix::from_fn(|i, j| x[i].g[j]),
    }
}

/// x, ẋ, ẍ, B, Ḃ, B̈ by one run over moving values with their gradients.
pub fn kinematics<const D: usize, const N: usize>(
    map: &(impl Map<D, N> + ?Sized),
    t: f64,
    q: &SVector<f64, D>,
    v: &SVector<f64, D>,
    a: &SVector<f64, D>,
) -> Kinematics<D, N> {
    let q = SVector::<Moving<D>, D>::from_fn(|i, _| Moving::variable([q[i], v[i], a[i]], i));
    let x = map.phi(Moving::given([t, 1.0, 0.0]), &q);
    Kinematics {
        x: x.map(|x| x.x[0]),
        x_dot: x.map(|x| x.x[1]),
        x_ddot: x.map(|x| x.x[2]),
        B: SMatrix::from_fn(|i, j| x[i].g[0][j]),
        B_dot: SMatrix::from_fn(|i, j| x[i].g[1][j]),
        B_ddot: SMatrix::from_fn(|i, j| x[i].g[2][j]),
    }
}

/// Number of variables of one block of a Hessian. Small jets are cheap to copy, and four variables
/// hold the rotation of a frame and an angle; more variables are combined block by block.
const WIDTH: usize = 4;

/// K_σ(f), the Hessian of f·φ, in the variables in which φ is not affine.
pub fn geometric_stiffness<const D: usize, const N: usize>(
    map: &(impl Map<D, N> + ?Sized),
    t: f64,
    q: &SVector<f64, D>,
    f: &SVector<f64, N>,
) -> SMatrix<f64, D, D> {
    let (bent, n) = bent_variables(map, t, q);
    let bent = &bent[..n];
    let mut K = SMatrix::<f64, D, D>::zeros();
    if n <= WIDTH {
        write_block(map, t, q, f, bent, &mut K);
    } else {
        // Every two halves of the width are combined once.
        for (i, first) in bent.chunks(WIDTH / 2).enumerate() {
            for second in bent.chunks(WIDTH / 2).skip(i + 1) {
                let mut at = [0; WIDTH];
                let n = first.len() + second.len();
                at[..first.len()].copy_from_slice(first);
                at[first.len()..n].copy_from_slice(second);
                write_block(map, t, q, f, &at[..n], &mut K);
            }
        }
    }
    K.fill_upper_triangle_with_lower_triangle();
    K
}

/// The variables in which φ is not affine, and their number.
fn bent_variables<const D: usize, const N: usize>(
    map: &(impl Map<D, N> + ?Sized),
    t: f64,
    q: &SVector<f64, D>,
) -> ([usize; D], usize) {
    let q = SVector::<Trace, D>::from_fn(|i, _| Trace::variable(q[i], i));
    let x = map.phi(Trace::constant(t), &q);
    let (mut bent, mut n) = ([0; D], 0);
    for i in 0..D {
        if x.iter().any(|x| x.bends(i)) {
            bent[n] = i;
            n += 1;
        }
    }
    (bent, n)
}

/// The lower triangle of K_σ(f) in up to [`WIDTH`] variables, given in increasing order.
fn write_block<const D: usize, const N: usize>(
    map: &(impl Map<D, N> + ?Sized),
    t: f64,
    q: &SVector<f64, D>,
    f: &SVector<f64, N>,
    at: &[usize],
    K: &mut SMatrix<f64, D, D>,
) {
    let mut z = q.map(Hess::<WIDTH>::constant);
    for (k, &i) in at.iter().enumerate() {
        z[i] = Hess::coordinate(q[i], k);
    }
    let x = map.phi(Hess::constant(t), &z);
    for (k, &i) in at.iter().enumerate() {
        for (l, &j) in at[..=k].iter().enumerate() {
            K[(i, j)] = x.iter().zip(f.iter()).map(|(x, f)| f * x.xx[k][l]).sum();
        }
    }
}
