//! Forces per length along a beam element, and its self-weight.

use crate::beam::shape::{gauss, lagrange};
use crate::beam::{BeamError, Geodesic, Interpolation, Rotations, Total};
use crate::blocks::{add, add_block, three};
use crate::element::{Abilities, Element, ElementEnergies, Motion, Properties, Response};
use crate::time::TimeFunction;
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::so3;

/// Largest number of nodes of an element.
const MOST: usize = 4;

/// R and the Θ_Ψᵢ of δΘ = Σ Θ_Ψᵢ δΨᵢ of the section with shape functions N.
type SectionAt = fn(x: &[f64], N: &[f64]) -> (Matrix3<f64>, [Matrix3<f64>; MOST]);

/// A force per unit reference length on a beam element, interpolated like the beam.
///
/// Self-weight is the dead load Aρ g.
#[derive(Debug)]
pub struct LineLoad {
    /// Shape functions and weights at the integration points, as many as nodes.
    points: Vec<(Vec<f64>, f64)>,
    nodes: usize,
    /// Share of each node in a dead load: ∫ Nᵢ.
    shares: Vec<f64>,
    follower: bool,
    section: SectionAt,
    force: Vector3<f64>,
    amplitude: Box<dyn TimeFunction>,
}

/// [`Rotations::section`] of an element of any number of nodes.
fn section<const NN: usize, I: Rotations<NN>>(
    x: &[f64],
    N: &[f64],
) -> (Matrix3<f64>, [Matrix3<f64>; MOST]) {
    let (R, own) = I::section(x, &std::array::from_fn(|i| N[i]));
    let mut Theta_psi = [Matrix3::zeros(); MOST];
    Theta_psi[..NN].copy_from_slice(&own);
    (R, Theta_psi)
}

impl LineLoad {
    /// The same load on an element with this interpolation of rotations: a follower load rotates
    /// with its cross-sections. [`Interpolation::Total`] by default.
    #[must_use]
    pub fn with_interpolation(mut self, interpolation: Interpolation) -> Self {
        self.section = match (interpolation, self.nodes) {
            (Interpolation::Total, 2) => section::<2, Total<2>>,
            (Interpolation::Total, 3) => section::<3, Total<3>>,
            (Interpolation::Total, _) => section::<4, Total<4>>,
            (Interpolation::Geodesic, 2) => section::<2, Geodesic<2>>,
            (Interpolation::Geodesic, 3) => section::<3, Geodesic<3>>,
            (Interpolation::Geodesic, _) => section::<4, Geodesic<4>>,
        };
        self
    }

    /// `force` per length times `amplitude` on an element through `positions`; a follower load
    /// rotates with the cross-sections.
    ///
    /// # Errors
    /// [`BeamError::Nodes`] unless there are two, three or four positions.
    pub fn new(
        positions: &[Vector3<f64>],
        force: [f64; 3],
        follower: bool,
        amplitude: impl Into<Box<dyn TimeFunction>>,
    ) -> Result<Self, BeamError> {
        let points = match positions.len() {
            2 => integration_points::<2>(positions),
            3 => integration_points::<3>(positions),
            4 => integration_points::<4>(positions),
            n => return Err(BeamError::Nodes(n)),
        };
        let share = |i: usize| points.iter().map(|(N, weight)| weight * N[i]).sum();
        let load = Self {
            shares: (0..positions.len()).map(share).collect(),
            points,
            nodes: positions.len(),
            follower,
            section: section::<2, Total<2>>,
            force: force.into(),
            amplitude: amplitude.into(),
        };
        Ok(load.with_interpolation(Interpolation::Total))
    }
}

fn integration_points<const NN: usize>(positions: &[Vector3<f64>]) -> Vec<(Vec<f64>, f64)> {
    gauss(NN)
        .into_iter()
        .map(|(xi, weight)| {
            let (N, dN) = lagrange::<NN>(xi);
            let slope: Vector3<f64> = positions.iter().zip(dN).map(|(p, d)| p * d).sum();
            (N.to_vec(), weight * slope.norm())
        })
        .collect()
}

impl Element for LineLoad {
    fn dim(&self) -> usize {
        6 * self.nodes
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let n = self.dim();
        let [amplitude, rate, _] = self.amplitude.at(at.t, at.inputs);
        if !self.follower {
            for (i, share) in self.shares.iter().enumerate() {
                add(out.r, 6 * i, &(self.force * (amplitude * share)));
                if let Some(r_t) = out.r_t.as_deref_mut() {
                    add(r_t, 6 * i, &(self.force * (rate * share)));
                }
            }
            return Ok(());
        }
        for (N, weight) in &self.points {
            let (R, Theta_psi) = (self.section)(at.x, N);
            let f = R * self.force;
            // δ(R f) = −R f~ δΘ.
            let D = R * so3::skew(&self.force) * -1.0;
            for (i, N) in N[..self.nodes].iter().enumerate() {
                let w = weight * N;
                add(out.r, 6 * i, &(f * (amplitude * w)));
                if let Some(r_t) = out.r_t.as_deref_mut() {
                    add(r_t, 6 * i, &(f * (rate * w)));
                }
                if let Some(K) = out.K.as_deref_mut() {
                    for (j, Theta_psi) in Theta_psi[..self.nodes].iter().enumerate() {
                        let D = D * Theta_psi * -(amplitude * w);
                        add_block(K, n, 6 * i, 6 * j + 3, &D);
                    }
                }
            }
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }

    fn kinks(&self) -> Vec<f64> {
        self.amplitude.kinks()
    }

    fn properties(&self) -> Properties {
        Properties {
            dead: !self.follower,
            time_independent: !self.follower && self.amplitude.constant().is_some(),
            symmetric: !self.follower,
            sees_rotations: self.follower,
            ..Properties::LOAD
        }
    }
}

impl ElementEnergies for LineLoad {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        if self.follower {
            return 0.0;
        }
        let nodes = at.x.chunks_exact(6).zip(&self.shares);
        let work: f64 = nodes
            .map(|(x, share)| share * self.force.dot(&three(x, 0)))
            .sum();
        -self.amplitude.at(at.t, at.inputs)[0] * work
    }
}
