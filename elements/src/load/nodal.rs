//! Forces and moments at a node (\[M04\] section 3.5; theory of conservative and follower loads).

#![allow(non_snake_case)]

use crate::element::{Element, ElementError, Motion, Properties, Response};
use crate::time::TimeFunction;
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::quotients::Quotients;
use pullback_manifold::so3;

/// Kind of a nodal load: its behaviour when the node rotates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadKind {
    /// Dead force f: covector f for d.
    DeadForce,
    /// Follower force R f; its tangent −R f~ T is not symmetric.
    FollowerForce,
    /// Spatial moment m of fixed direction: covector T m for Ψ; its tangent C₁(m,Ψ) is not
    /// symmetric, so it has no potential.
    SpatialMoment,
    /// Follower moment R M: covector Tᵀ M, tangent C₂(M,Ψ).
    FollowerMoment,
}

/// A force or moment at a frame node: a vector times a function of time.
#[derive(Debug)]
pub struct NodalLoad {
    which: LoadKind,
    vector: Vector3<f64>,
    amplitude: Box<dyn TimeFunction>,
}

impl NodalLoad {
    /// `vector` (global components; for follower loads those of the reference configuration)
    /// times `amplitude`.
    pub fn new(which: LoadKind, vector: [f64; 3], amplitude: impl TimeFunction + 'static) -> Self {
        Self::boxed(which, vector, Box::new(amplitude))
    }

    /// As [`NodalLoad::new`], for a boxed amplitude.
    pub fn boxed(which: LoadKind, vector: [f64; 3], amplitude: Box<dyn TimeFunction>) -> Self {
        Self {
            which,
            vector: vector.into(),
            amplitude,
        }
    }

    /// The covector of the unit amplitude, and its derivative D_Ψ: (first row 0 or 3, f, D).
    fn covector(&self, psi: &Vector3<f64>) -> (usize, Vector3<f64>, Matrix3<f64>) {
        let V = &self.vector;
        let q = Quotients::new(psi.norm());
        let c = q.tangent();
        match self.which {
            LoadKind::DeadForce => (0, *V, Matrix3::zeros()),
            LoadKind::FollowerForce => {
                let R = so3::R(psi, &c);
                (0, R * V, R * so3::skew(V) * so3::T(psi, &c) * -1.0)
            }
            LoadKind::SpatialMoment => (3, so3::T(psi, &c) * V, so3::C1(V, psi, &q)),
            LoadKind::FollowerMoment => (3, so3::T(psi, &c).tr_mul(V), so3::C2(V, psi, &q)),
        }
    }
}

impl Element for NodalLoad {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        let psi = Vector3::from_column_slice(&at.x[3..6]);
        let [amplitude, rate, _] = self.amplitude.at(at.t);
        let (first, f, D) = self.covector(&psi);
        for k in 0..3 {
            out.r[first + k] += amplitude * f[k];
        }
        if let Some(K) = out.K.as_deref_mut() {
            for c in 0..3 {
                for r in 0..3 {
                    K[first + r + (3 + c) * 6] -= amplitude * D[(r, c)];
                }
            }
        }
        if let Some(r_t) = out.r_t.as_deref_mut() {
            for k in 0..3 {
                r_t[first + k] += rate * f[k];
            }
        }
        Ok(())
    }

    fn energy(&self, at: &Motion<'_>) -> f64 {
        match self.which {
            LoadKind::DeadForce => {
                let d = Vector3::from_column_slice(&at.x[..3]);
                -self.amplitude.at(at.t)[0] * self.vector.dot(&d)
            }
            // No potential.
            _ => 0.0,
        }
    }

    fn kinks(&self) -> Vec<f64> {
        self.amplitude.kinks()
    }

    fn properties(&self) -> Properties {
        // A follower moment's D = C₂(M,Ψ) is not symmetric either.
        let dead = self.which == LoadKind::DeadForce;
        Properties {
            dead,
            steady: dead && self.amplitude.constant().is_some(),
            symmetric: dead,
            ..Properties::LOAD
        }
    }
}
