//! A dead force at a point beside the node, such as the weight of an eccentric mass.

use crate::blocks::{add, add_block};
use crate::element::{Abilities, Element, ElementEnergies, Motion, Properties, Response};
use crate::time::TimeFunction;
use nalgebra::Vector3;
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::pose::orientation;
use pullback_manifold::so3::skew;

/// A force n of fixed direction at the material offset e from a frame node; dim 6. \[M04\] (156)–(157).
///
/// The force n and the moment R e × n. It has the potential −n·(d + (R − I) e), zero in the reference
/// configuration, so that its tangent is symmetric in coordinates. It [reads
/// poses](Properties::reads_poses).
#[derive(Debug)]
pub struct EccentricForce {
    n: Vector3<f64>,
    e: Vector3<f64>,
    amplitude: Box<dyn TimeFunction>,
}

impl EccentricForce {
    /// `force` (F, global components) times `amplitude` at `offset` (L) from the node, global
    /// components of the reference configuration.
    pub fn new(
        force: [f64; 3],
        offset: [f64; 3],
        amplitude: impl Into<Box<dyn TimeFunction>>,
    ) -> Self {
        Self {
            n: force.into(),
            e: offset.into(),
            amplitude: amplitude.into(),
        }
    }
}

impl Element for EccentricForce {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let [amplitude, rate, _] = self.amplitude.at(at.t, at.inputs);
        let e = orientation(at.x).rotate(&self.e);
        let moment = e.cross(&self.n);
        add(out.r, 0, &(self.n * amplitude));
        add(out.r, 3, &(moment * amplitude));
        if let Some(r_t) = out.r_t.as_deref_mut() {
            add(r_t, 0, &(self.n * rate));
            add(r_t, 3, &(moment * rate));
        }
        if let Some(K) = out.K.as_deref_mut() {
            // δ(e × n) = (δθ × e) × n
            add_block(K, 6, 3, 3, &(skew(&self.n) * skew(&e) * -amplitude));
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
            time_independent: self.amplitude.constant().is_some(),
            reads_poses: true,
            ..Properties::LOAD
        }
    }
}

impl ElementEnergies for EccentricForce {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let d = Vector3::from_column_slice(&at.x[..3]);
        let moved = d + orientation(at.x).rotate(&self.e) - self.e;
        -self.amplitude.at(at.t, at.inputs)[0] * self.n.dot(&moved)
    }
}
