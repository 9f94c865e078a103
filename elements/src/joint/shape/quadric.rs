//! Planes, cylinders and spheres as surfaces.

use crate::joint::Surface;
use crate::joint::axes::{AxisError, PARALLEL, across, direction};
use nalgebra::Vector3;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Quantity;
use std::f64::consts::FRAC_PI_2;

/// A plane, a cylinder or a sphere through the point where a joint starts, in components relative to the
/// parent's node. e₁ points from the centre to the start, and e₁, e₂, e₃ are orthonormal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quadric {
    /// x = start + u e₂ + v e₃, with the normal e₁.
    Plane {
        /// Where it starts.
        start: Vector3<f64>,
        /// e₂ and e₃.
        along: [Vector3<f64>; 2],
    },
    /// x = centre + r (cos u e₁ + sin u e₂) + v e₃, with the axis e₃.
    Cylinder {
        /// The point of the axis at the height of the start.
        centre: Vector3<f64>,
        /// r e₁, r e₂ and e₃.
        frame: [Vector3<f64>; 3],
    },
    /// x = centre + r (cos v (cos u e₁ + sin u e₂) + sin v e₃); v ends at ±π/2, a quarter of a turn
    /// from the start.
    Sphere {
        /// The centre.
        centre: Vector3<f64>,
        /// r e₁, r e₂, r e₃.
        frame: [Vector3<f64>; 3],
    },
}

impl Quadric {
    /// The plane of a normal.
    ///
    /// # Errors
    /// [`AxisError::Direction`].
    pub fn plane(start: [f64; 3], normal: [f64; 3]) -> Result<Self, AxisError> {
        let normal = direction(normal)?;
        let first = across(&normal);
        Ok(Self::Plane {
            start: start.into(),
            along: [first, normal.cross(&first)],
        })
    }

    /// The cylinder about the axis through `centre`.
    ///
    /// # Errors
    /// [`AxisError::Direction`]; [`AxisError::Radius`] if the start lies on the axis.
    pub fn cylinder(start: [f64; 3], centre: [f64; 3], axis: [f64; 3]) -> Result<Self, AxisError> {
        let axis = direction(axis)?;
        let from = Vector3::from(start) - Vector3::from(centre);
        let radius = from - axis * axis.dot(&from);
        if radius.norm() <= PARALLEL * from.norm() {
            return Err(AxisError::Radius);
        }
        Ok(Self::Cylinder {
            centre: Vector3::from(start) - radius,
            frame: [radius, axis.cross(&radius), axis],
        })
    }

    /// The sphere around `centre`.
    ///
    /// # Errors
    /// [`AxisError::Radius`] if the start is the centre.
    pub fn sphere(start: [f64; 3], centre: [f64; 3]) -> Result<Self, AxisError> {
        let radius = Vector3::from(start) - Vector3::from(centre);
        let e = direction(radius.into()).map_err(|_| AxisError::Radius)?;
        let second = across(&e) * radius.norm();
        Ok(Self::Sphere {
            centre: centre.into(),
            frame: [radius, second, e.cross(&second)],
        })
    }
}

impl Surface for Quadric {
    fn at<S: Scalar>(&self, u: S, v: S) -> Vector3<S> {
        let (from, parts, frame) = match self {
            Self::Plane { start, along } => {
                let [first, second] = along;
                return Vector3::from_fn(|i, _| u * first[i] + v * second[i] + start[i]);
            }
            Self::Cylinder { centre, frame } => (centre, [u.cos(), u.sin(), v], frame),
            Self::Sphere { centre, frame } => {
                let round = v.cos();
                (centre, [round * u.cos(), round * u.sin(), v.sin()], frame)
            }
        };
        Vector3::from_fn(|i, _| {
            let [first, second, third] = frame.each_ref().map(|e| e[i]);
            parts[0] * first + parts[1] * second + parts[2] * third + from[i]
        })
    }

    fn quantities(&self) -> [Quantity; 2] {
        match self {
            Self::Plane { .. } => [Quantity::Length; 2],
            Self::Cylinder { .. } => [Quantity::Angle, Quantity::Length],
            Self::Sphere { .. } => [Quantity::Angle; 2],
        }
    }

    fn margin(&self, _u: f64, v: f64) -> f64 {
        match self {
            Self::Sphere { .. } => FRAC_PI_2 - v.abs(),
            _ => f64::INFINITY,
        }
    }
}
