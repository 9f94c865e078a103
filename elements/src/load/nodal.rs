//! Forces and moments at a node (\[M04\] section 3.5; theory of conservative and follower loads).

use crate::blocks::{add, add_block};
use crate::element::{Abilities, Element, ElementEnergies, Motion, Properties, Response};
use crate::time::TimeFunction;
use nalgebra::Vector3;
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::pose::orientation;
use pullback_manifold::so3::skew;

/// Kind of a nodal load: its behaviour when the node rotates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LoadKind {
    /// Dead force f.
    DeadForce,
    /// Follower force R f; its tangent is not symmetric.
    FollowerForce,
    /// Spatial moment m of fixed direction; its tangent in coordinates, C₁(m,Ψ), is not symmetric, so it
    /// has no potential.
    SpatialMoment,
    /// Follower moment R M.
    FollowerMoment,
}

/// A force or moment at a frame node: a vector times a function of time. All but dead forces [read
/// poses](Properties::reads_poses).
#[derive(Debug)]
pub struct NodalLoad {
    which: LoadKind,
    vector: Vector3<f64>,
    amplitude: Box<dyn TimeFunction>,
}

impl NodalLoad {
    /// `vector` (global components; for follower loads those of the reference configuration)
    /// times `amplitude`.
    pub fn new(
        which: LoadKind,
        vector: [f64; 3],
        amplitude: impl Into<Box<dyn TimeFunction>>,
    ) -> Self {
        Self {
            which,
            vector: vector.into(),
            amplitude: amplitude.into(),
        }
    }
}

impl Element for NodalLoad {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let [amplitude, rate, _] = self.amplitude.at(at.t, at.inputs);
        let (first, follows) = match self.which {
            LoadKind::DeadForce => (0, false),
            LoadKind::FollowerForce => (0, true),
            LoadKind::SpatialMoment => (3, false),
            LoadKind::FollowerMoment => (3, true),
        };
        let f = match follows {
            true => orientation(at.x).rotate(&self.vector),
            false => self.vector,
        };
        add(out.r, first, &(f * amplitude));
        if let Some(K) = out.K.as_deref_mut().filter(|_| follows) {
            // δ(R f) = δθ × R f
            add_block(K, 6, first, 3, &(skew(&f) * amplitude));
        }
        if let Some(r_t) = out.r_t.as_deref_mut() {
            add(r_t, first, &(f * rate));
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
        let dead = self.which == LoadKind::DeadForce;
        Properties {
            dead,
            time_independent: dead && self.amplitude.constant().is_some(),
            symmetric: dead,
            sees_rotations: !dead,
            reads_poses: !dead,
            ..Properties::LOAD
        }
    }
}

impl ElementEnergies for NodalLoad {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        match self.which {
            LoadKind::DeadForce => {
                let d = Vector3::from_column_slice(&at.x[..3]);
                -self.amplitude.at(at.t, at.inputs)[0] * self.vector.dot(&d)
            }
            // No potential.
            _ => 0.0,
        }
    }
}
