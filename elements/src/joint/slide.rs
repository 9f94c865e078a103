//! The slide: a frame that runs along a chain of two-node beam elements.

use super::shape::{Between, Chain};
use crate::beam::Interpolation;
use nalgebra::{SVector, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::Map;
use pullback_manifold::scalar::Scalar;
use std::f64::consts::TAU;

/// d_s = Σ Nᵢ(u)(Xᵢ + dᵢ) − X_s, Ψ_s = Σ Nᵢ(u) Ψᵢ with the shape functions of the beam element on
/// which the frame is (\[M04\] 4.1.3, (198)): parents (frame, frame, u). On geodesic elements its
/// rotation is theirs, R_s = R₁ exp(N₂(u) log(R₁ᵀ R₂)).
///
/// u is the arc length of the reference configuration from where the frame starts, positive towards
/// the end of the chain: one coordinate for all its elements, zero in the reference. A time step ends where
/// the frame passes from one element to the next; beyond the ends of the chain the joint is outside its
/// domain. For a closed ring the chain repeats its nodes as often as the frame may pass.
///
#[doc = include_str!("../../images/slide.svg")]
#[derive(Clone, Debug, PartialEq)]
pub struct Slide {
    /// The beams' axes in the reference configuration.
    pub(super) chain: Chain,
    pub(super) turn: Between,
}

impl Slide {
    /// A slide along elements with this interpolation of rotations.
    pub fn new(chain: Chain, interpolation: Interpolation) -> Self {
        let turn = Between::new(interpolation);
        Self { chain, turn }
    }
}

impl Map<13, 6> for Slide {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 13>) -> SVector<S, 6> {
        let three = |k: usize| Vector3::new(q[k], q[k + 1], q[k + 2]);
        let [a, b] = self.chain.shape(q[12]);
        let d = self.chain.displacement(q[12]) + three(0) * a + three(6) * b;
        let psi = self.turn.at([three(3), three(9)], [a, b]);
        SVector::<S, 6>::new(d.x, d.y, d.z, psi.x, psi.y, psi.z)
    }

    fn domain(&self, t: f64, q: &SVector<f64, 13>) -> Result<f64, DomainError> {
        let psi = self.phi(t, q).fixed_rows::<3>(3).norm();
        let margin = self.chain.room(q[12]).min(TAU - psi);
        DomainError::within(
            margin,
            "its chain of beams over an end: make the chain longer, or stop before",
        )
    }
}
