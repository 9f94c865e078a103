//! A spring and damper along the line between two nodes.

use super::{SpringError, finite, not_negative};
use crate::blocks::{add, add_block, three};
use crate::element::{Abilities, Element, ElementEnergies, Motion, Properties, Response};
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::domain::DomainError;

/// A spring and damper along the line between the points of two frame nodes; dim 12.
///
/// With u = x₂ − x₁ of length l and direction e, its tension is
///
/// ```text
/// N = k (l − l₀) + c l̇,   l̇ = e·u̇
/// ```
///
/// and its energy ½ k (l − l₀)². It does not depend on rotations of the nodes; a point beside a
/// node needs a rigid link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxialSpring {
    /// x₂ − x₁ in the reference configuration.
    U: Vector3<f64>,
    k: f64,
    c: f64,
    /// |U| − l₀.
    tightness: f64,
}

/// Length, direction and rates at a motion.
struct Stretched {
    l: f64,
    /// l − l₀.
    elongation: f64,
    e: Vector3<f64>,
    /// u̇, zero in statics.
    u_dot: Vector3<f64>,
    /// l̇ = e·u̇.
    l_dot: f64,
}

impl AxialSpring {
    /// Between the nodes' reference `positions` (global components, L), with stiffness k (F/L) and
    /// damping c (F T/L); unstressed in the reference configuration.
    ///
    /// # Errors
    /// [`SpringError`] for numbers that are not finite, negative k or c, both zero, or coinciding
    /// positions.
    pub fn new(positions: &[Vector3<f64>; 2], k: f64, c: f64) -> Result<Self, SpringError> {
        not_negative("the stiffness k", k)?;
        not_negative("the damping c", c)?;
        if k == 0.0 && c == 0.0 {
            return Err(SpringError::Nothing);
        }
        for position in positions {
            finite("a position", position.as_slice())?;
        }
        let U = positions[1] - positions[0];
        let size = positions[0].amax().max(positions[1].amax());
        if U.norm() <= 1e-12 * size {
            return Err(SpringError::Coincide {
                at: positions[0].into(),
            });
        }
        Ok(Self {
            U,
            k,
            c,
            tightness: 0.0,
        })
    }

    /// The same spring with another unstressed length l₀ (L); zero is allowed.
    ///
    /// # Errors
    /// [`SpringError`] unless it is finite and not negative.
    pub fn with_rest_length(mut self, rest_length: f64) -> Result<Self, SpringError> {
        not_negative("the rest length", rest_length)?;
        self.tightness = self.U.norm() - rest_length;
        Ok(self)
    }

    /// Tension N at a motion, positive in tension (F).
    ///
    /// # Errors
    /// [`DomainError::Undefined`] if its ends coincide.
    pub fn tension(&self, at: &Motion<'_>) -> Result<f64, DomainError> {
        Ok(self.force(&self.stretched(at)?))
    }

    fn force(&self, s: &Stretched) -> f64 {
        self.k * s.elongation + self.c * s.l_dot
    }

    /// u = U + d₂ − d₁, its length l, and l − l₀.
    ///
    /// From l² − |U|² = d·(2 U + d) with d = d₂ − d₁: the difference of two lengths would have
    /// their rounding errors, which a stiff spring turns into forces larger than its own.
    fn between(&self, x: &[f64]) -> (Vector3<f64>, f64, f64) {
        let d = difference(x);
        let u = self.U + d;
        let l = u.norm();
        let change = d.dot(&(2.0 * self.U + d)) / (l + self.U.norm());
        (u, l, change + self.tightness)
    }

    fn stretched(&self, at: &Motion<'_>) -> Result<Stretched, DomainError> {
        let (u, l, elongation) = self.between(at.x);
        // At smaller lengths the direction is only round-off.
        if l <= 1e-12 * self.U.norm() {
            return Err(DomainError::Undefined(format!(
                "its ends coincide (length {l:.3e}): its force has no direction"
            )));
        }
        let e = u / l;
        let u_dot = if at.v.is_empty() {
            Vector3::zeros()
        } else {
            difference(at.v)
        };
        Ok(Stretched {
            l,
            elongation,
            e,
            u_dot,
            l_dot: e.dot(&u_dot),
        })
    }
}

/// Translations of the second node less those of the first.
fn difference(x: &[f64]) -> Vector3<f64> {
    three(x, 6) - three(x, 0)
}

/// Adds a matrix in u to one in (d₁, d₂): [D −D; −D D].
fn add_tangent(to: Option<&mut [f64]>, D: &Matrix3<f64>) {
    if let Some(to) = to {
        for (row, column, block) in [(0, 0, *D), (6, 0, -D), (0, 6, -D), (6, 6, *D)] {
            add_block(to, 12, row, column, &block);
        }
    }
}

impl Element for AxialSpring {
    fn dim(&self) -> usize {
        12
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let s = self.stretched(at)?;
        let N = self.force(&s);
        add(out.r, 0, &(s.e * N));
        add(out.r, 6, &(s.e * -N));
        let along = s.e * s.e.transpose();
        if out.K.is_some() {
            // D_u(N e) with D_u l = e and D_u e = (I − e⊗e)/l, so that D_u l̇ = (u̇ − l̇ e)/l.
            let l_dot_u = (s.u_dot - s.e * s.l_dot) / s.l;
            let D = along * self.k
                + s.e * l_dot_u.transpose() * self.c
                + (Matrix3::identity() - along) * (N / s.l);
            add_tangent(out.K.as_deref_mut(), &D);
        }
        add_tangent(out.C.as_deref_mut(), &(along * self.c));
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }

    fn properties(&self) -> Properties {
        Properties {
            sees_rotations: false,
            ..Properties::INTERNAL
        }
    }
}

impl ElementEnergies for AxialSpring {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        let (_, _, elongation) = self.between(at.x);
        0.5 * self.k * elongation.powi(2)
    }

    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.stretched(at)
            .map_or(0.0, |s| self.c * s.l_dot * s.l_dot)
    }
}
