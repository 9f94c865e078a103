//! The relative displacement and rotation of two frames, with their derivatives.

use crate::beam::relative::{Operator, RelativeNode, RelativePose, Turn, turn_between};
use crate::blocks::three;
use nalgebra::{SMatrix, SVector, Vector3, Vector6};
use pullback_manifold::so3;

/// The map (x₁, x₂) → y = (u, θ), u = R₁ᵀ(x₂ − x₁) − u₀, θ = log(R₁ᵀR₂), in one configuration of the two frames: the
/// second one is a node relative to the first.
pub(super) struct Relation {
    /// (u, θ).
    pub y: Vector6<f64>,
    first: Turn,
    second: RelativeNode,
}

/// The 6×12 matrix of an operator, the columns of the first frame before those of the second.
fn columns(of: &Operator) -> SMatrix<f64, 6, 12> {
    SMatrix::from_fn(|i, j| match j {
        0..6 => of.reference[(i, j)],
        _ => of.own[(i, j - 6)],
    })
}

impl Relation {
    /// At the coordinates of both frames (12); u₀ is R₁ᵀ(x₂ − x₁) in the reference configuration.
    pub(super) fn new(u0: &Vector3<f64>, x: &[f64]) -> Self {
        let first = Turn::new(three(x, 3));
        let R = so3::R(&first.psi, &first.quotients.tangent());
        let seen = RelativePose {
            z: R.tr_mul(&(three(x, 6) - three(x, 0) + u0)),
            theta: turn_between(&first.psi, &three(x, 9)),
        };
        let (u, theta) = (seen.z - u0, seen.theta);
        Self {
            y: Vector6::new(u.x, u.y, u.z, theta.x, theta.y, theta.z),
            second: RelativeNode::new(Turn::new(three(x, 9)), seen, &first, &R.transpose()),
            first,
        }
    }

    /// B = ∂y/∂x, 6×12.
    pub(super) fn B(&self) -> SMatrix<f64, 6, 12> {
        columns(&self.second.B)
    }

    /// Ḃ along the velocities v, 6×12; `y_dot` = B v.
    pub(super) fn B_dot(&self, v: &SVector<f64, 12>, y_dot: &Vector6<f64>) -> SMatrix<f64, 6, 12> {
        let [first, second] = [3, 9].map(|i| three(v.as_slice(), i));
        columns(&self.second.B_dot(y_dot, &self.first, &second, &first))
    }

    /// K_σ(f) = D_x(Bᵀf) for fixed f = (n, m), symmetric 12×12.
    pub(super) fn K_sigma(&self, f: &Vector6<f64>) -> SMatrix<f64, 12, 12> {
        let forces = [0, 3].map(|i| three(f.as_slice(), i));
        let mut K = SMatrix::<f64, 12, 12>::zeros();
        let (second, first) = (&self.second, &self.first);
        second.add_geometric(first, forces, K.as_mut_slice(), 12, [6, 0]);
        // But for rounding it is.
        (K + K.transpose()) * 0.5
    }
}
