//! Cross-sections.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A cross-section. Give exactly one of `stiffness`, `matrix`, `rectangle`, `circle`, `tube`; the
/// last three need a `material`. Section axes: E1 along the beam, E2 and E3 across.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Section {
    /// Diagonal law.
    pub stiffness: Option<Stiffness>,
    /// Full symmetric 6×6 law, row by row: normal force, two shear forces, torque, two bending moments.
    pub matrix: Option<[[f64; 6]; 6]>,
    /// Solid rectangle.
    pub rectangle: Option<Rectangle>,
    /// Solid circle.
    pub circle: Option<Circle>,
    /// Circular tube.
    pub tube: Option<Tube>,
    /// Material of a rectangle, circle or tube.
    pub material: Option<Material>,
    /// Mass per length; overrides what material and shape give. Needed for gravity and dynamics.
    pub mass: Option<Mass>,
    /// Viscous damping of a dynamic analysis; none by default.
    pub damping: Option<Damping>,
}

/// Rayleigh's damping.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Damping {
    /// Factor of the mass: a drag against the absolute velocity, in 1/time.
    pub mass: f64,
    /// Factor of the stiffness: stresses in proportion to the rates of strain (Kelvin and Voigt), in units of time.
    pub stiffness: f64,
}

/// Diagonal section law: N = diag(EA, GA₂, GA₃) Γ, M = diag(GJ, EI₂, EI₃) K.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stiffness {
    /// Axial stiffness.
    pub EA: f64,
    /// Shear stiffnesses along E2 and E3.
    pub GA: [f64; 2],
    /// Torsional stiffness.
    pub GJ: f64,
    /// Bending stiffnesses about E2 and E3.
    pub EI: [f64; 2],
}

/// A solid rectangle.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    /// Side along E2.
    pub width: f64,
    /// Side along E3.
    pub height: f64,
}

/// A solid circle.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Circle {
    /// Radius.
    pub radius: f64,
}

/// A circular tube.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tube {
    /// Inner radius.
    pub inner: f64,
    /// Outer radius.
    pub outer: f64,
}

/// An isotropic material.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus.
    pub E: f64,
    /// Poisson's ratio, in (-1, 0.5].
    pub nu: f64,
    /// Density; zero where weight and inertia do not matter.
    #[serde(default)]
    pub rho: f64,
}

/// Mass per reference length.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mass {
    /// Mass per length Aρ.
    pub A_rho: f64,
    /// Principal inertias per length about E1, E2, E3, about the mass centre. If absent, those of material and shape.
    pub J: Option<[f64; 3]>,
    /// Position of the mass centre in the cross-section, along E2 and E3; on the axis by default.
    pub center: Option<[f64; 2]>,
}
