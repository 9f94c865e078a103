//! Composition of two maps.

#![allow(non_snake_case)]

use super::{Kinematics, Map, Tangent};
use crate::scalar::Scalar;
use nalgebra::{SMatrix, SVector};

/// The composed map `outer` ∘ `inner`: E^D → E^M → E^N.
///
/// Its pull-back is the pull-back of the pull-back.
#[derive(Clone, Copy, Debug)]
pub struct Composed<Outer, Inner, const M: usize> {
    /// Applied last, E^M → E^N.
    pub outer: Outer,
    /// Applied first, E^D → E^M.
    pub inner: Inner,
}

impl<Outer, Inner, const D: usize, const M: usize, const N: usize> Map<D, N>
    for Composed<Outer, Inner, M>
where
    Outer: Map<M, N>,
    Inner: Map<D, M>,
{
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, N> {
        self.outer.phi(t, &self.inner.phi(t, q))
    }

    fn margin(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        let inner = self.inner.margin(t, q);
        if inner > 0.0 {
            inner.min(self.outer.margin(t, &self.inner.phi(t, q)))
        } else {
            inner
        }
    }

    fn tangent(&self, t: f64, q: &SVector<f64, D>) -> Tangent<D, N> {
        let inner = self.inner.tangent(t, q);
        let outer = self.outer.tangent(t, &inner.x);
        Tangent {
            x: outer.x,
            B: outer.B * inner.B,
        }
    }

    fn kinematics(
        &self,
        t: f64,
        q: &SVector<f64, D>,
        v: &SVector<f64, D>,
        a: &SVector<f64, D>,
    ) -> Kinematics<D, N> {
        let i = self.inner.kinematics(t, q, v, a);
        let o = self.outer.kinematics(t, &i.x, &i.x_dot, &i.x_ddot);
        Kinematics {
            x: o.x,
            x_dot: o.x_dot,
            x_ddot: o.x_ddot,
            B: o.B * i.B,
            B_dot: o.B_dot * i.B + o.B * i.B_dot,
            B_ddot: o.B_ddot * i.B + o.B_dot * i.B_dot * 2.0 + o.B * i.B_ddot,
        }
    }

    fn geometric_stiffness(
        &self,
        t: f64,
        q: &SVector<f64, D>,
        f: &SVector<f64, N>,
    ) -> SMatrix<f64, D, D> {
        let inner = self.inner.tangent(t, q);
        let outer = self.outer.tangent(t, &inner.x);
        let middle = self.outer.geometric_stiffness(t, &inner.x, f);
        inner.B.transpose() * middle * inner.B
            + self
                .inner
                .geometric_stiffness(t, q, &(outer.B.transpose() * f))
    }
}
