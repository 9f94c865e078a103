//! Charts: coordinates of a configuration manifold, their domain, and changes between them.
//!
//! Leaves: [`Euclidean`] space, the [`Circle`] with an unbounded angle, rotations by
//! [`RotationVector`], and [`Product`]s such as [`Frame`], a position and an orientation.

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

/// The identity, transition of global charts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identity;

impl<const D: usize> Map<D, D> for Identity {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, D>) -> SVector<S, D> {
        *q
    }
}

/// Euclidean space E^D with Cartesian coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Euclidean;

impl<const D: usize> Chart<D> for Euclidean {
    type Point = SVector<f64, D>;
    type Transition = Identity;

    fn point(&self, q: &SVector<f64, D>) -> Self::Point {
        *q
    }

    fn coordinates(&self, point: &Self::Point, _near: &SVector<f64, D>) -> SVector<f64, D> {
        *point
    }
}

/// The circle with an unbounded angle: any number of turns, no change of chart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Circle;

impl Chart<1> for Circle {
    /// (cos φ, sin φ).
    type Point = [f64; 2];
    type Transition = Identity;

    fn point(&self, q: &SVector<f64, 1>) -> Self::Point {
        [q.x.cos(), q.x.sin()]
    }

    fn coordinates(&self, [c, s]: &Self::Point, near: &SVector<f64, 1>) -> SVector<f64, 1> {
        let angle = s.atan2(*c);
        let turns = ((near.x - angle) / TAU).round();
        SVector::<f64, 1>::new(angle + TAU * turns)
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

/// The product of two charts (or of two maps): coordinates one after the other.
///
/// A product of dimension D needs D = A + B; this is checked at compile time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Product<First, Second, const A: usize, const B: usize> {
    /// Chart of the first A coordinates.
    pub first: First,
    /// Chart of the next B coordinates.
    pub second: Second,
}

impl<First, Second, const A: usize, const B: usize> Product<First, Second, A, B> {
    fn split<S: Scalar, const D: usize>(q: &SVector<S, D>) -> (SVector<S, A>, SVector<S, B>) {
        const { assert!(A + B == D, "a product has the sum of the dimensions") };
        (
            SVector::from_fn(|i, _| q[i]),
            SVector::from_fn(|i, _| q[A + i]),
        )
    }

    fn join<S: Scalar, const D: usize>(a: &SVector<S, A>, b: &SVector<S, B>) -> SVector<S, D> {
        SVector::from_fn(|i, _| if i < A { a[i] } else { b[i - A] })
    }
}

impl<First, Second, const A: usize, const B: usize, const D: usize> Chart<D>
    for Product<First, Second, A, B>
where
    First: Chart<A>,
    Second: Chart<B>,
{
    type Point = (First::Point, Second::Point);
    type Transition = Product<Either<First::Transition>, Either<Second::Transition>, A, B>;

    fn point(&self, q: &SVector<f64, D>) -> Self::Point {
        let (a, b) = Self::split(q);
        (self.first.point(&a), self.second.point(&b))
    }

    fn coordinates(&self, point: &Self::Point, near: &SVector<f64, D>) -> SVector<f64, D> {
        let (a, b) = Self::split(near);
        Self::join(
            &self.first.coordinates(&point.0, &a),
            &self.second.coordinates(&point.1, &b),
        )
    }

    fn margin(&self, q: &SVector<f64, D>) -> f64 {
        let (a, b) = Self::split(q);
        self.first.margin(&a).min(self.second.margin(&b))
    }

    fn transition(&self, q: &SVector<f64, D>) -> Option<Self::Transition> {
        let (a, b) = Self::split(q);
        let first = self.first.transition(&a);
        let second = self.second.transition(&b);
        (first.is_some() || second.is_some()).then_some(Product {
            first: Either(first),
            second: Either(second),
        })
    }
}

impl<First, Second, const A: usize, const B: usize, const D: usize> Map<D, D>
    for Product<First, Second, A, B>
where
    First: Map<A, A>,
    Second: Map<B, B>,
{
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, D> {
        let (a, b) = Self::split(q);
        Self::join(&self.first.phi(t, &a), &self.second.phi(t, &b))
    }

    fn margin(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        let (a, b) = Self::split(q);
        self.first.margin(t, &a).min(self.second.margin(t, &b))
    }
}

/// A map, or the identity if there is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Either<M>(pub Option<M>);

impl<M: Map<D, D>, const D: usize> Map<D, D> for Either<M> {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, D>) -> SVector<S, D> {
        self.0.as_ref().map_or(*q, |map| map.phi(t, q))
    }

    fn margin(&self, t: f64, q: &SVector<f64, D>) -> f64 {
        let map = self.0.as_ref();
        map.map_or(f64::INFINITY, |map| map.margin(t, q))
    }
}

/// A position and an orientation, E³ × SO(3): the coordinates (d, Ψ) of a node.
pub type Frame = Product<Euclidean, RotationVector, 3, 3>;
