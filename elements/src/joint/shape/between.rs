//! Rotations between the two nodes of a beam, for joints along it.

use crate::beam::Interpolation;
use nalgebra::Vector3;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::so3::{complement, log_quaternion, quaternion};
use std::f64::consts::TAU;

/// Interpolation of rotations in a two-node beam, and the branches of its rotation vectors: those of the
/// coordinates of its nodes may be others, as elements change their charts separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Between {
    interpolation: Interpolation,
    /// Whether the complement of a node's vector is used.
    pub complements: [bool; 2],
}

impl Between {
    /// With the branches of the coordinates.
    pub fn new(interpolation: Interpolation) -> Self {
        Self {
            interpolation,
            complements: [false; 2],
        }
    }

    /// The rotation vector between those of the two nodes: Σ Nᵢ Ψᵢ, or log(R₁ exp(N₂ log(R₁ᵀ R₂))).
    pub fn at<S: Scalar>(&self, ends: [Vector3<S>; 2], shape: [S; 2]) -> Vector3<S> {
        let [first, last] = [0, 1].map(|k| match self.complements[k] {
            false => ends[k],
            true => complement(&ends[k]),
        });
        match self.interpolation {
            Interpolation::Total => first * shape[0] + last * shape[1],
            Interpolation::Geodesic => {
                let [p, r] = [first, last].each_ref().map(quaternion);
                let theta = log_quaternion(&p.conjugate().product(&r));
                log_quaternion(&p.product(&quaternion(&(theta * shape[1]))))
            }
        }
    }

    /// Chooses the branches with the smallest largest angle, as the beam does, or those of the coordinates
    /// if `psi` is `None`; returns whether they change.
    pub fn choose(&mut self, psi: Option<[Vector3<f64>; 2]>) -> bool {
        let before = self.complements;
        self.complements = psi.map_or([false; 2], |psi| {
            let angle = psi.map(|p| p.norm());
            // A complement has the angle 2π − ψ.
            match quaternion(&psi[0]).dot(&quaternion(&psi[1])) >= 0.0 {
                true => [angle[0] + angle[1] > TAU; 2],
                false if angle[0] <= angle[1] => [false, true],
                false => [true, false],
            }
        });
        self.complements != before
    }
}
