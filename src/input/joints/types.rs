//! The joints of the library under their names in model files, with their keys.

use super::registry::Registry;
use nalgebra::Vector3;
use pullback_elements::joint::{self, Quadric, Spline};
use schemars::JsonSchema;
use serde::Deserialize;

/// A rigid link to a node at another position.
#[derive(Deserialize, JsonSchema)]
struct Offset {
    /// Position of the node of the joint, global like that of a node.
    position: [f64; 3],
}

/// A rigid connection at the same position.
#[derive(Deserialize, JsonSchema)]
struct Weld {}

/// Releases all displacements and rotations: a node whose coordinates are relative to its parent.
#[derive(Deserialize, JsonSchema)]
struct Free {
    /// Position of the node of the joint, global like that of a node.
    position: [f64; 3],
}

/// Releases the angle about an axis, any number of turns.
#[derive(Deserialize, JsonSchema)]
struct Revolute {
    /// Axis in global components of the reference configuration; the parent carries it.
    axis: [f64; 3],
}

/// Releases all rotations.
#[derive(Deserialize, JsonSchema)]
struct Spherical {}

/// Releases the arc length along lines.
#[derive(Deserialize, JsonSchema)]
struct Slide {
    /// Initial arc length, from the beginning of the first line.
    #[serde(default)]
    start: f64,
}

/// Releases the angles about two crossed axes.
#[derive(Deserialize, JsonSchema)]
struct Universal {
    /// Axis that the parent carries, in global components of the reference configuration.
    axis: [f64; 3],
    /// Axis fixed to the node of the joint.
    second_axis: [f64; 3],
}

/// Releases the tilt of two shafts that turn equally fast.
#[derive(Deserialize, JsonSchema)]
struct ConstantVelocity {
    /// Shaft of the parent, in global components of the reference configuration.
    axis: [f64; 3],
    /// Shaft fixed to the node of the joint.
    second_axis: [f64; 3],
}

/// Releases displacement and angle along and about an axis.
#[derive(Deserialize, JsonSchema)]
struct Cylindrical {
    /// Axis in global components of the reference configuration; the parent carries it.
    axis: [f64; 3],
}

/// Releases the displacement along an axis.
#[derive(Deserialize, JsonSchema)]
struct Prismatic {
    /// Axis in global components of the reference configuration; the parent carries it.
    axis: [f64; 3],
}

/// Releases two displacements in a plane, and the angle about its normal.
#[derive(Deserialize, JsonSchema)]
struct Planar {
    /// Normal of the plane in global components of the reference configuration; the parent carries it.
    axis: [f64; 3],
    /// Direction of the first displacement; its part in the plane counts.
    second_axis: [f64; 3],
}

/// Releases the angle of a screw, which moves along its axis as it turns.
#[derive(Deserialize, JsonSchema)]
struct Helical {
    /// Axis in global components of the reference configuration; the parent carries it.
    axis: [f64; 3],
    /// Displacement along the axis per turn.
    pitch: f64,
}

/// Releases the arc length along a curve, and all rotations.
#[derive(Deserialize, JsonSchema)]
struct OnCurve {
    /// Points of the curve, like positions of nodes; the parent carries them.
    through: Vec<[f64; 3]>,
    /// Whether the curve is closed from the last point to the first.
    #[serde(default)]
    closed: bool,
    /// Initial arc length: sum of the straight distances from point to point.
    #[serde(default)]
    start: f64,
}

/// Releases two parameters of a surface, and all rotations.
#[derive(Deserialize, JsonSchema)]
struct OnSurface {
    /// Initial position, global like that of a node.
    position: [f64; 3],
    /// The surface, fixed to the parent.
    surface: Shape,
}

/// A surface through the position where a joint starts.
#[derive(Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Shape {
    /// A plane.
    Plane {
        /// Its normal.
        normal: [f64; 3],
    },
    /// A cylinder.
    Cylinder {
        /// A point of its axis.
        center: [f64; 3],
        /// Direction of its axis.
        axis: [f64; 3],
    },
    /// A sphere, of which the hemisphere around the start is used.
    Sphere {
        /// Its centre.
        center: [f64; 3],
    },
}

/// A registry and the joints of the library.
pub(super) fn add_to(registry: Registry) -> Registry {
    registry
        .joint("offset", |at, keys: Offset| {
            let position = at.displaced(keys.position);
            at.builder.offset(at.name, at.parent, position)
        })
        .joint("weld", |at, _: Weld| {
            let position = at.builder.position(at.parent);
            at.builder.offset(at.name, at.parent, position.into())
        })
        .joint("free", |at, keys: Free| {
            let position = at.displaced(keys.position);
            at.builder.relative_node(at.name, at.parent, position)
        })
        .joint("revolute", |at, keys: Revolute| {
            at.join(joint::Revolute::new(keys.axis)?)
        })
        .joint("spherical", |at, _: Spherical| {
            at.builder.spherical(at.name, at.parent)
        })
        .joint_along("slide", |at, keys: Slide| {
            (at.builder).slide(at.name, at.chain, keys.start, at.interpolation)
        })
        .joint("universal", |at, keys: Universal| {
            at.join(joint::Universal::new([keys.axis, keys.second_axis])?)
        })
        .joint("constant_velocity", |at, keys: ConstantVelocity| {
            let axes = [keys.axis, keys.second_axis];
            at.join(joint::ConstantVelocity::new(axes)?)
        })
        .joint("cylindrical", |at, keys: Cylindrical| {
            at.join(joint::Cylindrical::new(keys.axis)?)
        })
        .joint("prismatic", |at, keys: Prismatic| {
            at.join(joint::Prismatic::new(keys.axis)?)
        })
        .joint("planar", |at, keys: Planar| {
            at.join(joint::Planar::new(keys.axis, keys.second_axis)?)
        })
        .joint("helical", |at, keys: Helical| {
            at.join(joint::Helical::new(keys.axis, keys.pitch)?)
        })
        .joint("on_curve", |at, keys: OnCurve| {
            let origin = at.builder.position(at.parent);
            let seen = |point: &[f64; 3]| (Vector3::from(*point) - origin).into();
            let points: Vec<_> = keys.through.iter().map(seen).collect();
            let curve = Spline::through(&points, keys.closed, keys.start)?;
            at.join_free(joint::OnCurve::new(curve))
        })
        .joint("on_surface", |at, keys: OnSurface| {
            let origin = at.builder.position(at.parent);
            let seen = |point: [f64; 3]| (Vector3::from(point) - origin).into();
            let start = seen(at.displaced(keys.position));
            let surface = match keys.surface {
                Shape::Plane { normal } => Quadric::plane(start, normal),
                Shape::Cylinder { center, axis } => Quadric::cylinder(start, seen(center), axis),
                Shape::Sphere { center } => Quadric::sphere(start, seen(center)),
            }?;
            at.join_free(joint::OnSurface::new(surface))
        })
}
