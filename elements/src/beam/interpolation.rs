//! Interpolation of rotations in a beam element.

use super::element::{Beam, BeamError};
use super::geodesic::Geodesic;
use super::mass::MassPoint;
use super::section::Section;
use crate::blocks::three;
use crate::element::{CombinedTangents, Element, Motion};
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::quotients::TangentQuotients;
use pullback_manifold::so3;
use std::fmt::Debug;

/// Interpolation of rotations of a beam element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Interpolation {
    /// The total rotation vector, Ψ(ξ) = Σ Nᵢ(ξ) Ψᵢ; \[M04\] chapter 3.
    ///
    /// The fastest. Strains depend on rigid rotations, and on the chart, to the order of the mesh
    /// error.
    #[default]
    Total,
    /// The rotation relative to a node r of the element, R(ξ) = R_r exp(Σ Nᵢ(ξ) log(R_rᵀ Rᵢ)):
    /// between two nodes the geodesic R₁ exp(N₂ log(R₁ᵀ R₂)).
    ///
    /// Strains are invariant under rigid rotations and changes of chart (Crisfield & Jelenić 1999,
    /// Proc. R. Soc. Lond. A 455). The nodes of an element may rotate by less than one turn
    /// relative to each other.
    Geodesic,
}

impl Interpolation {
    /// A beam element through two, three or four reference positions (equidistant in the parameter)
    /// with the section's orientation as a function of ξ ∈ [−1, 1] (columns E₁, E₂, E₃).
    ///
    /// E₁ is rotated to the tangent of the interpolated reference line; E₂ stays in its plane with it.
    ///
    /// # Errors
    /// [`BeamError`] for coinciding nodes, an invalid orientation or number of nodes.
    pub fn beam(
        self,
        positions: &[Vector3<f64>],
        frame: &dyn Fn(f64) -> Matrix3<f64>,
        section: &Section,
    ) -> Result<Box<dyn Element>, BeamError> {
        match *positions {
            [a, b] => self.of([a, b], frame, section),
            [a, b, c] => self.of([a, b, c], frame, section),
            [a, b, c, d] => self.of([a, b, c, d], frame, section),
            _ => Err(BeamError::Nodes(positions.len())),
        }
    }

    fn of<const NN: usize>(
        self,
        positions: [Vector3<f64>; NN],
        frame: &dyn Fn(f64) -> Matrix3<f64>,
        section: &Section,
    ) -> Result<Box<dyn Element>, BeamError> {
        Ok(match self {
            Self::Total => Box::new(Beam::<NN>::new(&positions, frame, section)?),
            Self::Geodesic => Box::new(Beam::<NN, Geodesic<NN>>::new(&positions, frame, section)?),
        })
    }
}

/// Interpolation of rotations: a map x̂ = φ(x) from the node coordinates (d, Ψ) to coordinates (d̂,
/// Ψ̂) in which position and rotation vector are interpolated by the shape functions.
///
/// Strains and their forces are one kernel in x̂ for all interpolations, pulled back by φ. The
/// inertia belongs to the interpolation.
pub trait Rotations<const NN: usize>: Clone + Debug + Send + Sync + Sized {
    /// The interpolation between nodes at these reference positions, with the inertia points of an
    /// element with mass.
    fn new(positions: &[Vector3<f64>; NN], masses: Option<[MassPoint<NN>; NN]>) -> Self;

    /// The nodes in interpolated coordinates, at coordinates x and velocities v (6·NN each; v empty
    /// at rest).
    fn seen(&self, x: &[f64], v: &[f64]) -> Seen<NN>;

    /// The section with the shape functions `N`: its rotation R (3×3) and the operators Θ_Ψᵢ (3×3)
    /// of δΘ = Σ Θ_Ψᵢ δΨᵢ, material.
    fn section(x: &[f64], N: &[f64; NN]) -> (Matrix3<f64>, [Matrix3<f64>; NN]);

    /// Adds the forces and tangents of the strains of a beam, [`Beam::strain`] in x̂.
    ///
    /// # Errors
    /// [`DomainError`] outside the domain of the interpolation or of the strains.
    fn pull_back(
        beam: &Beam<NN, Self>,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError>;

    /// Adds −f_acc, the drag α p with the momenta p, and their tangents.
    fn inertia(
        &self,
        at: &Motion<'_>,
        alpha: f64,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    );

    /// Kinetic energy.
    fn kinetic_energy(&self, at: &Motion<'_>) -> f64;
}

/// The nodes in interpolated coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Seen<const NN: usize> {
    /// Rotation R̂ to the fixed frame: sections are at R̂ R(Ψ̂).
    pub R: Matrix3<f64>,
    /// Coordinates x̂ = (d̂, Ψ̂) of each node.
    pub x: [[f64; 6]; NN],
    /// Their velocities; zero at rest.
    pub v: [[f64; 6]; NN],
}

/// Total rotation vectors: φ is the identity.
#[derive(Clone, Debug)]
pub struct Total<const NN: usize> {
    pub(super) masses: Option<[MassPoint<NN>; NN]>,
}

impl<const NN: usize> Rotations<NN> for Total<NN> {
    fn new(_: &[Vector3<f64>; NN], masses: Option<[MassPoint<NN>; NN]>) -> Self {
        Self { masses }
    }

    fn seen(&self, x: &[f64], v: &[f64]) -> Seen<NN> {
        let nodes = |x: &[f64]| {
            let mut out = [[0.0; 6]; NN];
            for (out, x) in out.as_flattened_mut().iter_mut().zip(x) {
                *out = *x;
            }
            out
        };
        Seen {
            R: Matrix3::identity(),
            x: nodes(x),
            v: nodes(v),
        }
    }

    fn section(x: &[f64], N: &[f64; NN]) -> (Matrix3<f64>, [Matrix3<f64>; NN]) {
        let nodes = x.chunks_exact(6).zip(N);
        let psi: Vector3<f64> = nodes.map(|(x, N)| three(x, 3) * *N).sum();
        let c = TangentQuotients::new(psi.norm_squared());
        let T = so3::T(&psi, &c);
        (so3::R(&psi, &c), N.map(|N| T * N))
    }

    #[inline]
    fn pull_back(
        beam: &Beam<NN, Self>,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        beam.strain(at, at.x, [r, &mut []], tangents)
    }

    #[inline]
    fn inertia(
        &self,
        at: &Motion<'_>,
        alpha: f64,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) {
        for p in self.masses.iter().flatten() {
            p.add(at, alpha, r, tangents);
        }
    }

    fn kinetic_energy(&self, at: &Motion<'_>) -> f64 {
        let masses = self.masses.iter().flatten();
        masses.map(|p| p.kinetic_energy(at)).sum()
    }
}
