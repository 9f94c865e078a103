//! Gravity of a point mass.

use nalgebra::{SVector, Vector3};
use pullback_elements::element::Properties;
use pullback_elements::energy::EnergyElement;
use pullback_manifold::domain::DomainError;
use pullback_manifold::scalar::Scalar;

/// Newton's gravity of a fixed centre on a mass at a frame node; dim 6.
///
/// Potential −μ m/‖x − c‖. Only the attraction: the mass itself is a
/// `PointMass` at the same node. A uniform field is the weight of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gravity {
    /// The node's position in the reference configuration, global components, L.
    pub position: Vector3<f64>,
    /// The position c of the centre, L.
    pub center: Vector3<f64>,
    /// Strength μ of the centre, the constant of gravity times its mass, L³/T².
    pub mu: f64,
    /// The mass m at the node, M.
    pub mass: f64,
}

impl EnergyElement<6> for Gravity {
    const KINETIC: bool = false;
    const DISSIPATION: bool = false;

    fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 6>) -> S {
        let reference = self.position - self.center;
        let r = Vector3::from_fn(|i, _| x[i] + reference[i]);
        -r.dot(&r).sqrt().recip() * (self.mu * self.mass)
    }

    fn domain(&self, x: &SVector<f64, 6>) -> Result<(), DomainError> {
        let length = (self.position - self.center + x.fixed_rows::<3>(0)).norm();
        if length > 0.0 {
            Ok(())
        } else {
            Err(DomainError::Undefined("it is at the centre".to_owned()))
        }
    }

    fn properties(&self) -> Properties {
        Properties {
            time_independent: true,
            ..Properties::LOAD
        }
    }
}
