//! A dead force at a point beside the node, such as the weight of an eccentric mass.

#![allow(non_snake_case)]

use crate::element::{Element, ElementError, Motion, Properties, Response};
use crate::time::TimeFunction;
use nalgebra::Vector3;
use pullback_manifold::quotients::Quotients;
use pullback_manifold::so3::{self, skew};

/// A force n of fixed direction at the material offset e from a frame node; dim 6. \[M04\] (156)–(157).
///
/// Covector n for d and Tᵀ e~ Rᵀn for Ψ. It has the potential −n·(d + (R − I) e), zero in the
/// reference configuration, so that its tangent is symmetric.
#[derive(Debug)]
pub struct EccentricForce {
    n: Vector3<f64>,
    e: Vector3<f64>,
    amplitude: Box<dyn TimeFunction>,
}

impl EccentricForce {
    /// `force` (F, global components) times `amplitude` at `offset` (L) from the node, global
    /// components of the reference configuration.
    pub fn new(force: [f64; 3], offset: [f64; 3], amplitude: impl TimeFunction + 'static) -> Self {
        Self::boxed(force, offset, Box::new(amplitude))
    }

    /// As [`EccentricForce::new`], for a boxed amplitude.
    pub fn boxed(force: [f64; 3], offset: [f64; 3], amplitude: Box<dyn TimeFunction>) -> Self {
        Self {
            n: force.into(),
            e: offset.into(),
            amplitude,
        }
    }
}

impl Element for EccentricForce {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        let psi = Vector3::from_column_slice(&at.x[3..6]);
        let [amplitude, rate, _] = self.amplitude.at(at.t);
        let quotients = Quotients::new(psi.norm());
        let c = quotients.tangent();
        let T = so3::T(&psi, &c);
        let n = so3::R(&psi, &c).tr_mul(&self.n);
        let moment = self.e.cross(&n);
        let f = T.tr_mul(&moment);
        for k in 0..3 {
            out.r[k] += amplitude * self.n[k];
            out.r[3 + k] += amplitude * f[k];
        }
        if let Some(r_t) = out.r_t.as_deref_mut() {
            for k in 0..3 {
                r_t[k] += rate * self.n[k];
                r_t[3 + k] += rate * f[k];
            }
        }
        if let Some(K) = out.K.as_deref_mut() {
            // [M04] (157): D_Ψ(Tᵀ e~ Rᵀn).
            let D = so3::C2(&moment, &psi, &quotients) + T.tr_mul(&(skew(&self.e) * skew(&n) * T));
            for c in 0..3 {
                for r in 0..3 {
                    K[3 + r + (3 + c) * 6] -= amplitude * D[(r, c)];
                }
            }
        }
        Ok(())
    }

    fn energy(&self, at: &Motion<'_>) -> f64 {
        let d = Vector3::from_column_slice(&at.x[..3]);
        let psi = Vector3::from_column_slice(&at.x[3..6]);
        let moved = d + so3::rotation(&psi) * self.e - self.e;
        -self.amplitude.at(at.t)[0] * self.n.dot(&moved)
    }

    fn kinks(&self) -> Vec<f64> {
        self.amplitude.kinks()
    }

    fn properties(&self) -> Properties {
        Properties {
            steady: self.amplitude.constant().is_some(),
            ..Properties::LOAD
        }
    }
}
