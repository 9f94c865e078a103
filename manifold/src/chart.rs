//! Charts: coordinates of a configuration manifold, their domain, and changes between them.

#![allow(non_snake_case)]

use crate::map::{Kinematics, Map, Tangent};
use crate::scalar::Scalar;
use crate::so3::{self, Quaternion};
use nalgebra::{SMatrix, SVector, Vector3};
use std::f64::consts::{PI, TAU};

/// A chart of a manifold of dimension D.
///
/// Coordinates and points determine each other within the chart. Near its edge,
/// [`Chart::transition`] gives the map to a better chart, which transforms velocities,
/// accelerations and forces as well ([`Map::kinematics`], [`Map::geometric_stiffness`]).
pub trait Chart<const D: usize> {
    /// A point of the manifold, independent of coordinates.
    type Point;

    /// The change of chart.
    type Transition: Map<D, D> + Clone + 'static;

    /// The point with coordinates q.
    fn point(&self, q: &SVector<f64, D>) -> Self::Point;

    /// Coordinates of a point; those closest to `near` if several are possible.
    fn coordinates(&self, point: &Self::Point, near: &SVector<f64, D>) -> SVector<f64, D>;

    /// Distance of q to the edge of the chart: positive inside, infinite for a global chart.
    fn margin(&self, q: &SVector<f64, D>) -> f64 {
        let _ = q;
        f64::INFINITY
    }

    /// The change of chart at q, if another chart is better there.
    fn transition(&self, q: &SVector<f64, D>) -> Option<Self::Transition> {
        let _ = q;
        None
    }
}

/// Rotations by the rotation vector Ψ = ψ e, an open ball of radius 2π (\[M04\] definition 14).
///
/// The chart changes where ψ > π, by the [`Complement`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RotationVector;

impl Chart<3> for RotationVector {
    /// A unit quaternion; ±q are the same rotation.
    type Point = Quaternion<f64>;
    type Transition = Complement;

    fn point(&self, q: &Vector3<f64>) -> Self::Point {
        so3::quaternion(q)
    }

    fn coordinates(&self, point: &Self::Point, near: &Vector3<f64>) -> Vector3<f64> {
        if so3::quaternion(near).dot(point) < 0.0 {
            so3::log_quaternion(&point.opposite())
        } else {
            so3::log_quaternion(point)
        }
    }

    fn margin(&self, q: &Vector3<f64>) -> f64 {
        TAU - q.norm()
    }

    fn transition(&self, q: &Vector3<f64>) -> Option<Self::Transition> {
        (q.norm() > PI).then_some(Complement)
    }
}

/// The complement rotation vector Ψᶜ = Ψ − 2π Ψ/ψ, the same rotation in the other chart
/// (\[M04\] definition 15, 4.1.1). It is its own inverse, and undefined at ψ = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Complement;

impl Map<3, 3> for Complement {
    fn phi<S: Scalar>(&self, _t: S, q: &Vector3<S>) -> Vector3<S> {
        so3::complement(q)
    }

    fn margin(&self, _t: f64, q: &Vector3<f64>) -> f64 {
        let psi = q.norm();
        psi.min(TAU - psi)
    }

    fn tangent(&self, _t: f64, q: &Vector3<f64>) -> Tangent<3, 3> {
        Tangent {
            x: so3::complement(q),
            B: so3::B_s(q),
        }
    }

    fn kinematics(
        &self,
        _t: f64,
        q: &Vector3<f64>,
        v: &Vector3<f64>,
        a: &Vector3<f64>,
    ) -> Kinematics<3, 3> {
        let (B, B_dot) = (so3::B_s(q), so3::B_s_dot(v, q));
        Kinematics {
            x: so3::complement(q),
            x_dot: B * v,
            x_ddot: B * a + B_dot * v,
            B,
            B_dot,
            B_ddot: so3::B_s_ddot(a, v, q),
        }
    }

    fn geometric_stiffness(
        &self,
        _t: f64,
        q: &Vector3<f64>,
        f: &Vector3<f64>,
    ) -> SMatrix<f64, 3, 3> {
        so3::K_sigma_s(f, q)
    }
}
