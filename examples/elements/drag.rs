//! Drag in a wind, a load by hand.

use nalgebra::{Matrix3, Vector3};
use pullback_elements::element::{Element, Motion, Properties, Response};
use pullback_elements::time::TimeFunction;
use pullback_manifold::domain::DomainError;

/// Drag c |u| u of the air on a frame node, u = w − v the velocity of the wind relative to the node; dim 6.
#[derive(Debug)]
pub struct Drag {
    /// Half of density, drag coefficient and area, F T²/L².
    pub c: f64,
    /// Direction of the wind, global components.
    pub direction: Vector3<f64>,
    /// Speed of the wind, L/T.
    pub speed: Box<dyn TimeFunction>,
}

impl Element for Drag {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let [speed, speed_t, _] = self.speed.at(at.t, at.inputs);
        // In statics there are no velocities.
        let v = Vector3::from_fn(|i, _| at.v.get(i).copied().unwrap_or(0.0));
        let u = self.direction * speed - v;
        let force = u * u.norm() * self.c;
        // ∂f/∂u.
        let unit = u.try_normalize(0.0).unwrap_or_default();
        let D = (Matrix3::identity() + unit * unit.transpose()) * (self.c * u.norm());
        let force_t = D * self.direction * speed_t;
        for i in 0..3 {
            out.r[i] += force[i];
            if let Some(r_t) = out.r_t.as_deref_mut() {
                r_t[i] += force_t[i];
            }
            if let Some(C) = out.C.as_deref_mut() {
                // By columns, as all tangents.
                (0..3).for_each(|j| C[i + 6 * j] += D[(i, j)]);
            }
        }
        Ok(())
    }

    fn kinks(&self) -> Vec<f64> {
        self.speed.kinks()
    }

    fn properties(&self) -> Properties {
        Properties {
            sees_rotations: false,
            ..Properties::LOAD
        }
    }
}
