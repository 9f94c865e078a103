//! What an element is: one evaluation that fills a residual and the requested tangents.

#![allow(non_snake_case)]

use crate::constraint::Enforced;
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::system::Weights;

/// Time, coordinates, velocities and accelerations of an element: those of its nodes, one after
/// the other. A frame node has six, (d, Ψ): displacement from its reference position and rotation
/// vector from its reference orientation, both in global components.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Time, or load parameter in statics.
    pub t: f64,
    /// Coordinates.
    pub x: &'a [f64],
    /// Velocities; zero in statics.
    pub v: &'a [f64],
    /// Accelerations; zero in statics.
    pub a: &'a [f64],
}

/// What an evaluation fills. Everything is zero on entry and the element **adds** to it.
///
/// Matrices are n×n, column by column, n = [`Element::dim`].
pub struct Response<'a> {
    /// Residual covector r = f_ext − f_int − f_acc.
    pub r: &'a mut [f64],
    /// K = −∂r/∂x, when asked for.
    pub K: Option<&'a mut [f64]>,
    /// C = −∂r/∂ẋ, when asked for.
    pub C: Option<&'a mut [f64]>,
    /// M = −∂r/∂ẍ, when asked for.
    pub M: Option<&'a mut [f64]>,
    /// Partial derivative ∂r/∂t at a fixed motion, when asked for.
    pub r_t: Option<&'a mut [f64]>,
}

/// Why an element cannot be evaluated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ElementError {
    /// A rotation vector has reached the edge of its chart, ψ = 2π.
    #[error("rotation angle {psi:.6} rad is at the edge of its chart (2π)")]
    OutsideChart {
        /// The rotation angle in radians.
        psi: f64,
    },
    /// Two nodes have turned against each other by a whole turn.
    #[error("its nodes have turned against each other by {psi:.6} rad, nearly a whole turn (2π)")]
    Overturned {
        /// The angle of the relative rotation in radians.
        psi: f64,
    },
    /// The equations that it enforces are outside of their domain.
    #[error("it left {edge}")]
    OutsideDomain {
        /// What it left, and what to do about it.
        edge: &'static str,
        /// Distance to the edge, ≤ 0.
        margin: f64,
    },
    /// The two ends of a spring coincide.
    #[error("its ends coincide (length {length:.3e}): its force has no direction")]
    ZeroLength {
        /// The distance of its ends.
        length: f64,
    },
}

/// An element that forms the combined tangent of an integrator faster than its parts K, C and M.
pub trait Combined {
    /// Adds the residual to `r` and cK·K + cC·C + cM·M to `S` (n×n, column by column): the sums of
    /// what [`Element::evaluate`], or [`Element::evaluate_from`] with a `previous` iterate, adds.
    /// Both are zero on entry.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    fn evaluate_combined(
        &self,
        previous: Option<&[f64]>,
        at: &Motion<'_>,
        weights: Weights,
        r: &mut [f64],
        S: &mut [f64],
    ) -> Result<(), ElementError>;
}

/// Rotations beyond this angle are refused: T is singular at 2π, T⁻¹ unbounded.
pub(crate) const EDGE: f64 = std::f64::consts::TAU - 1e-3;

/// Forces at one position of an element, for output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionState {
    /// Position of the cross-section's centre in the reference configuration, global components.
    pub reference: Vector3<f64>,
    /// Current position, global components.
    pub position: Vector3<f64>,
    /// Current orientation R(Ψ)R₀: section axes e₁, e₂, e₃ as columns, global components.
    pub frame: Matrix3<f64>,
    /// Strains Γ (elongation and two shears), components in the section axes.
    pub Gamma: Vector3<f64>,
    /// Curvatures K (twist and two bendings) per unit length, components in the section axes.
    pub K: Vector3<f64>,
    /// Normal force and two shear forces, components in the section axes.
    pub N: Vector3<f64>,
    /// Torque and two bending moments, components in the section axes.
    pub M: Vector3<f64>,
}

/// An element, or a load: anything that contributes to the residual through its nodes.
///
/// The same trait serves beams, bodies, springs and loads; the coordinates may be those of free
/// nodes or come out of any constraint map, the element does not know.
pub trait Element: Send + Sync {
    /// Number of coordinates: the sum of its nodes' dimensions.
    fn dim(&self) -> usize;

    /// Adds the residual, and the tangents asked for, at the given motion.
    ///
    /// # Errors
    /// [`ElementError`] when the motion is outside the element's domain.
    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError>;

    /// As [`Element::evaluate`], but K may use stresses extrapolated linearly from the previous
    /// iterate instead of those at `at`.
    ///
    /// The residual is the same, and K differs by terms of the second order in the step, so that
    /// Newton's method stays quadratic. What it gains is a tangent free of the large spurious
    /// stresses that a big step leaves in a slender element (Magisano, Leonetti & Garcea 2017,
    /// Comput. Methods Appl. Mech. Eng. 313). Ignored by default.
    ///
    /// # Errors
    /// As [`Element::evaluate`].
    fn evaluate_from(
        &self,
        previous: &[f64],
        at: &Motion<'_>,
        out: &mut Response<'_>,
    ) -> Result<(), ElementError> {
        let _ = previous;
        self.evaluate(at, out)
    }

    /// The combined tangent, where there is a faster way to it than through its parts.
    fn combined(&self) -> Option<&dyn Combined> {
        None
    }

    /// Whether the residual depends on time alone: all tangents are zero.
    fn is_dead(&self) -> bool {
        false
    }

    /// Stored (strain or load) energy; zero for elements without one.
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let _ = at;
        0.0
    }

    /// Kinetic energy, where there is a faster way to it than ½ ẋ·M ẋ; asked only in motion.
    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        let _ = at;
        None
    }

    /// Power lost in damping, ≥ 0; zero for elements without damping.
    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        let _ = at;
        0.0
    }

    /// Times at which a function of time inside has a kink; none by default.
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Whether K is symmetric at rest, wherever the element can be.
    fn is_symmetric(&self) -> bool {
        true
    }

    /// Whether its forces turn with a rigid motion of all its nodes, as internal ones do; what is
    /// tied to space besides its nodes says no. So do loads by default.
    fn is_objective(&self) -> bool {
        !self.is_load()
    }

    /// Whether rotations of its nodes matter to it; one that takes their positions alone says no, and
    /// leaves them free to turn against each other as often as they like.
    fn sees_rotations(&self) -> bool {
        true
    }

    /// The name of its type, for reports.
    fn kind(&self) -> &'static str {
        std::any::type_name::<Self>()
    }

    /// Whether it stands for applied loads, which set the scale of a convergence test.
    fn is_load(&self) -> bool {
        false
    }

    /// Whether it is a load with a potential, its energy, that is the same function of its coordinates at all
    /// times. What it does to a motion is then known exactly, and not to the order of a scheme alone.
    fn is_steady(&self) -> bool {
        false
    }

    /// The equations that it enforces on its coordinates, where there are such; none by default.
    fn enforced(&self) -> Option<&dyn Enforced> {
        None
    }

    /// As [`Element::enforced`], to change what is enforced.
    fn enforced_mut(&mut self) -> Option<&mut dyn Enforced> {
        None
    }

    /// Appends the states of its cross-sections, for output; nothing by default.
    fn section_states(&self, at: &Motion<'_>, out: &mut Vec<SectionState>) {
        let _ = (at, out);
    }
}
