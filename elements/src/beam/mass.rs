//! Inertia of the beam at one integration point: \[M04\] (119), (147), (152).

use super::Section;
use super::element::{Beam, BeamError};
use crate::blocks::three;
use crate::element::{CombinedTangents, Motion};
use crate::inertia::{FrameMotion, Inertia};
use nalgebra::{Matrix3, Matrix6, Vector3};
use pullback_manifold::system::Weights;

/// One point of the inertia rule: shape functions, weight times length, inertia per length with
/// components in the global frame of the reference configuration.
#[derive(Clone, Debug)]
pub struct MassPoint<const NN: usize> {
    /// Shape functions of the nodes.
    pub N: [f64; NN],
    /// Weight times length, L.
    pub weight: f64,
    /// Inertia per length.
    pub inertia: Inertia,
}

impl<const NN: usize> MassPoint<NN> {
    /// Three entries of all nodes, from `first` on, interpolated.
    #[inline]
    fn sum(&self, from: &[f64], first: usize) -> Vector3<f64> {
        let nodes = from.chunks_exact(6).zip(&self.N);
        nodes.fold(Vector3::zeros(), |sum, (x, N)| sum + three(x, first) * *N)
    }

    /// Adds −f_acc, the drag α M ẋ, and their tangents.
    #[inline]
    pub(super) fn add(
        &self,
        at: &Motion<'_>,
        alpha: f64,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) {
        // The motion of the section is interpolated like x and Ψ.
        let [v, a] = [at.v, at.a].map(|x| [self.sum(x, 0), self.sum(x, 3)]);
        let motion = FrameMotion::new(self.sum(at.x, 3), v, a, alpha, self.inertia.is_eccentric());
        let f = self.inertia.force(&motion);
        for (r, N) in r.chunks_exact_mut(6).zip(&self.N) {
            for (r, f) in r.iter_mut().zip(f.iter()) {
                *r -= self.weight * N * f;
            }
        }
        for (weights, out) in tangents.iter_mut().flatten() {
            if weights.K == 0.0 && weights.C == 0.0 {
                self.spread(&(self.inertia.mass_matrix(&motion) * weights.M), out);
                continue;
            }
            let M = weights.M + alpha * weights.C;
            let weights = Weights { M, ..*weights };
            self.spread(&self.inertia.tangent(&motion, weights), out);
        }
    }

    /// Adds N_i N_j times a 6×6 matrix to all pairs of nodes.
    #[inline]
    fn spread(&self, block: &Matrix6<f64>, out: &mut [f64]) {
        let n = 6 * NN;
        let coupled = self.inertia.is_eccentric();
        for j in 0..NN {
            for i in 0..NN {
                let factor = self.weight * self.N[i] * self.N[j];
                for c in 0..6 {
                    let start = 6 * i + (6 * j + c) * n;
                    let out = &mut out[start..start + 6];
                    // Without a first moment, translations are not coupled to rotations or to each
                    // other.
                    let rows = match (coupled, c) {
                        (true, _) => 0..6,
                        (false, 0..3) => c..c + 1,
                        (false, _) => 3..6,
                    };
                    for (o, b) in out[rows.clone()]
                        .iter_mut()
                        .zip(&block.column(c).as_slice()[rows])
                    {
                        *o += factor * b;
                    }
                }
            }
        }
    }

    /// Kinetic energy.
    pub(super) fn kinetic_energy(&self, at: &Motion<'_>) -> f64 {
        let (x_dot, psi, psi_dot) = (self.sum(at.v, 0), self.sum(at.x, 3), self.sum(at.v, 3));
        self.weight * self.inertia.kinetic_energy(&x_dot, &psi, &psi_dot)
    }
}

/// Share of each node of a beam element in its mass, ∫ Nᵢ Aρ (M), and in its first moment, ∫ Nᵢ S
/// (M·L, components in the global frame of the reference configuration), by the element's own rule:
/// a uniform acceleration g needs the forces and moments of the weight of these shares.
///
/// # Errors
/// As [`Beam::new`].
pub fn carried(
    positions: &[Vector3<f64>],
    frame: &dyn Fn(f64) -> Matrix3<f64>,
    section: &Section,
) -> Result<Vec<(f64, Vector3<f64>)>, BeamError> {
    fn of<const NN: usize>(
        positions: [Vector3<f64>; NN],
        frame: &dyn Fn(f64) -> Matrix3<f64>,
        section: &Section,
    ) -> Result<Vec<(f64, Vector3<f64>)>, BeamError> {
        let beam = Beam::<NN>::new(&positions, frame, section)?;
        let share = |i: usize| {
            let points = beam.rotations.masses.iter().flatten();
            points.fold((0.0, Vector3::zeros()), |(mass, S), p| {
                let weight = p.weight * p.N[i];
                (mass + weight * p.inertia.mass, S + p.inertia.S * weight)
            })
        };
        Ok((0..NN).map(share).collect())
    }
    match *positions {
        [a, b] => of([a, b], frame, section),
        [a, b, c] => of([a, b, c], frame, section),
        [a, b, c, d] => of([a, b, c, d], frame, section),
        _ => Err(BeamError::Nodes(positions.len())),
    }
}
