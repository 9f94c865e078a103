//! Lines of beam elements, and their imperfections.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A line of beam elements from one node to another: straight, or an arc. Its inner nodes are
/// named `name/1`, `name/2`, ... and its elements `name:1`, `name:2`, ..., from start to end.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Name; no `/` and no `:`.
    pub name: String,
    /// Node at its start.
    pub from: String,
    /// Node at its end.
    pub to: String,
    /// Number of elements.
    #[schemars(range(min = 1))]
    pub elements: usize,
    /// Polynomial order of the elements: 1, 2 or 3 (two, three or four nodes each).
    #[serde(default = "super::count::<1>")]
    #[schemars(range(min = 1, max = 3))]
    pub order: usize,
    /// Name of its cross-section.
    pub section: String,
    /// How rotations are interpolated between the nodes of an element.
    #[serde(default, skip_serializing_if = "Interpolation::is_total")]
    pub interpolation: Interpolation,
    /// Node to whose frame the coordinates of the inner nodes are relative: a hub that rotates. By default they are
    /// displacements and rotations from the reference configuration.
    pub relative_to: Option<String>,
    /// Circular arc instead of a straight line.
    pub arc: Option<Arc>,
    /// Direction of the section axis E2 at the start (its part normal to the line counts). By
    /// default E3 is as close as possible to e3, or to e2 for a line along e3.
    pub second_axis: Option<[f64; 3]>,
    /// Pretwist: rotation of the section about a straight line from start to end, in degrees.
    #[serde(default)]
    pub twist_deg: f64,
}

/// How rotations are interpolated between the nodes of an element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Interpolation {
    /// Total rotation vectors: the fastest; strains change with a rigid rotation by the order of the mesh error.
    #[default]
    Total,
    /// Rotations relative to a node of the element: strains do not change with a rigid rotation.
    Geodesic,
}

impl Interpolation {
    fn is_total(&self) -> bool {
        *self == Self::Total
    }
}

/// A circular arc that starts at the line's `from` node.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Arc {
    /// Centre (any point on the axis of rotation).
    pub center: [f64; 3],
    /// Direction of the axis of rotation.
    pub axis: [f64; 3],
    /// Angle turned from start to end in degrees, positive about `axis` by the right-hand rule.
    pub angle_deg: f64,
}

/// A shape of buckling or vibration that displaces the reference configuration: nodes are moved, sections of lines
/// turned, without strains. Joints, springs and bodies keep their axes.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Imperfection {
    /// `buckling.json` or `modes.json` of a run of a model with the same nodes and lines; a relative path begins at the
    /// directory of the model file.
    pub shapes: String,
    /// Number of the mode there.
    #[serde(default = "super::count::<1>")]
    #[schemars(range(min = 1))]
    pub mode: usize,
    /// Largest displacement of a node; negative for the opposite one.
    pub amplitude: f64,
}
