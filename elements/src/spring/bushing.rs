//! An elastic joint: a 6×6 spring and damper between two frames.

use super::relative::Relation;
use super::{SpringError, finite};
use crate::Asymmetry;
use crate::blocks::{add, add_block};
use crate::element::{Abilities, Element, ElementEnergies, Motion, ONE_TURN, Response};
use nalgebra::{Matrix3, Matrix6, SVector, Vector3};
use pullback_manifold::domain::{DomainError, LARGEST_ANGLE};

/// A spring and damper in all six relative displacements y = (u, θ) of two frame nodes; dim 12.
///
/// ```text
/// u = R₁ᵀ(x₂ − x₁) − u₀,   θ = log(R₁ᵀR₂)
/// ```
///
/// in the frame of the first node, zero in the reference configuration (u₀ is u there). Energy ½
/// y·Ky, dissipation ẏ·Dẏ, covector Bᵀ(K y + D ẏ) with B = ∂y/∂x; tangents by the pull-back of the
/// spring through y(x), \[M04\] (183). Invariant under rigid motions of both nodes.
///
/// θ is the rotation vector of the product of the two nodes' quaternions, smooth for relative
/// rotations up to 2π. A model follows these quaternions from step to step, and returns an error
/// beyond 2π: use a joint with a [`CoordinateSpring`] for whole turns.
///
/// For a bushing to the ground, the first node is held.
///
/// [`CoordinateSpring`]: super::CoordinateSpring
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bushing {
    u0: Vector3<f64>,
    /// K and D in global components of the reference configuration.
    K: Matrix6<f64>,
    D: Matrix6<f64>,
}

impl Bushing {
    /// Between the nodes' reference `positions` (global components, L), with stiffness K and damping D
    /// in y = (u, θ); 6×6, symmetric, positive semidefinite, components in the bushing's axes, the
    /// columns of the rotation `axes` (global components of the reference configuration).
    ///
    /// Units of K: F/L, F and F L in its blocks uu, uθ and θθ; those of D times T.
    ///
    /// # Errors
    /// [`SpringError`] for numbers that are not finite, matrices that are not symmetric (to 1e-12)
    /// or not positive semidefinite, both zero, or axes that are not a rotation (to 1e-9).
    pub fn new(
        positions: &[Vector3<f64>; 2],
        axes: &Matrix3<f64>,
        K: &Matrix6<f64>,
        D: &Matrix6<f64>,
    ) -> Result<Self, SpringError> {
        for position in positions {
            finite("a position", position.as_slice())?;
        }
        let skewed = (axes.tr_mul(axes) - Matrix3::identity()).amax();
        let rotation = skewed <= 1e-9 && axes.determinant() > 0.0;
        if !rotation {
            return Err(SpringError::Axes {
                columns: (*axes).into(),
            });
        }
        check("the stiffness K", K)?;
        check("the damping D", D)?;
        if *K == Matrix6::zeros() && *D == Matrix6::zeros() {
            return Err(SpringError::Nothing);
        }
        let mut Q = Matrix6::zeros();
        for first in [0, 3] {
            Q.fixed_view_mut::<3, 3>(first, first).copy_from(axes);
        }
        let rotated = |A: &Matrix6<f64>| {
            let A = Q * A * Q.transpose();
            (A + A.transpose()) * 0.5
        };
        Ok(Self {
            u0: positions[1] - positions[0],
            K: rotated(K),
            D: rotated(D),
        })
    }
}

/// Checks that A is finite, symmetric and positive semidefinite.
fn check(quantity: &'static str, A: &Matrix6<f64>) -> Result<(), SpringError> {
    finite(quantity, A.as_slice())?;
    let diagonal: [f64; 6] = std::array::from_fn(|i| A[(i, i)]);
    let indefinite = Err(SpringError::NotPositiveSemidefinite { quantity, diagonal });
    if diagonal.iter().any(|&a| a < 0.0) {
        return indefinite;
    }
    // Independent of the units: scaled to a unit diagonal if it is not zero.
    let unit = diagonal.map(|a| if a > 0.0 { 1.0 / a.sqrt() } else { 1.0 });
    let scaled = Matrix6::from_fn(|i, j| unit[i] * A[(i, j)] * unit[j]);
    if let Some(asymmetry) = Asymmetry::of(A, |i, j| 1e-12 / (unit[i] * unit[j])) {
        return Err(SpringError::NotSymmetric {
            quantity,
            asymmetry,
        });
    }
    if scaled.symmetric_eigenvalues().min() < -1e-12 {
        return indefinite;
    }
    Ok(())
}

impl Element for Bushing {
    fn dim(&self) -> usize {
        12
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let here = Relation::new(&self.u0, at.x);
        DomainError::within(LARGEST_ANGLE - here.y.fixed_rows::<3>(3).norm(), ONE_TURN)?;
        let B = here.B();
        let mut f = self.K * here.y;
        // Velocities, ẏ = B ẋ, if they matter.
        let moving = (!at.v.is_empty() && self.D != Matrix6::zeros()).then(|| {
            let v = SVector::<f64, 12>::from_column_slice(at.v);
            (v, B * v)
        });
        if let Some((_, y_dot)) = &moving {
            f += self.D * y_dot;
        }
        add(out.r, 0, &-B.tr_mul(&f));
        if let Some(K) = out.K.as_deref_mut() {
            // [M04] (183) with −f for r: Bᵀ(K B + D Ḃ) + K_σ(f).
            let mut stress = self.K * B;
            if let Some((v, y_dot)) = &moving {
                stress += self.D * here.B_dot(v, y_dot);
            }
            add_block(K, 12, 0, 0, &(B.tr_mul(&stress) + here.K_sigma(&f)));
        }
        if let Some(C) = out.C.as_deref_mut() {
            add_block(C, 12, 0, 0, &B.tr_mul(&(self.D * B)));
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }
}

impl ElementEnergies for Bushing {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let y = Relation::new(&self.u0, at.x).y;
        0.5 * y.dot(&(self.K * y))
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        if at.v.is_empty() {
            return 0.0;
        }
        let y_dot = Relation::new(&self.u0, at.x).B() * SVector::<f64, 12>::from_column_slice(at.v);
        y_dot.dot(&(self.D * y_dot))
    }
}
