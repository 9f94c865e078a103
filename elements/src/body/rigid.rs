//! The rigid body.

#![allow(non_snake_case)]

use super::BodyError;
use crate::element::{EDGE, Element, ElementError, Motion, Response};
use crate::inertia::{FrameMotion, Inertia};
use crate::load::EccentricForce;
use crate::time::TimeFunction;
use nalgebra::{Matrix3, Matrix6, Vector3};
use pullback_manifold::system::Weights;

/// Tolerance of a negative principal moment, relative to the largest: round-off.
const ROUND_OFF: f64 = 1e-12;

/// Tolerance of the largest principal moment beyond the sum of the others, relative to itself: the
/// inertia of a flat body written with six digits.
const FLAT: f64 = 1e-5;

/// A rigid body moving with a frame node; dim 6. \[M04\] (119), (147), (152) without the integral.
///
/// The node need not be the centre of mass. Residual −f_acc of [`Inertia`], exact M, C (gyroscopic)
/// and K (centrifugal, with the accelerations); no force in statics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidBody {
    inertia: Inertia,
    /// Centre of mass seen from the node, material components.
    center: Vector3<f64>,
}

impl RigidBody {
    /// From the mass m (M), the inertia about the **centre of mass** (full symmetric 3×3, M L²) and
    /// the offset c of the centre of mass from the node (L); components of both in the global frame
    /// with the body in its reference configuration.
    ///
    /// # Errors
    /// [`BodyError`] for numbers that are not finite, a negative mass, an inertia that is not
    /// symmetric (to 1e-12 of its largest entry), not positive semidefinite or impossible (the
    /// largest principal moment exceeds the sum of the others by more than 1e-5 of itself), and for
    /// neither mass nor inertia.
    pub fn new(mass: f64, inertia: Matrix3<f64>, center: Vector3<f64>) -> Result<Self, BodyError> {
        let finite = |quantity, values: &[f64]| match values.iter().find(|x| !x.is_finite()) {
            Some(&value) => Err(BodyError::NotFinite { quantity, value }),
            None => Ok(()),
        };
        finite("the mass", &[mass])?;
        finite("the inertia", inertia.as_slice())?;
        finite("the centre of mass", center.as_slice())?;
        if mass < 0.0 {
            return Err(BodyError::Mass {
                required: "zero or positive",
                mass,
            });
        }
        check_inertia(&inertia)?;
        let symmetric = (inertia + inertia.transpose()) * 0.5;
        let inertia = Inertia::about_centre(mass, center, symmetric);
        // The inertia about a distant node does not replace a missing mass.
        if mass == 0.0 && symmetric == Matrix3::zeros() {
            return Err(BodyError::Massless);
        }
        Ok(Self { inertia, center })
    }

    /// Mass, first moment and inertia about the node.
    #[must_use]
    pub fn inertia(&self) -> &Inertia {
        &self.inertia
    }

    /// Its weight in a field g (acceleration, global components) times `amplitude`: a load on the
    /// same node, the force m g at the centre of mass.
    #[must_use]
    pub fn weight(&self, g: [f64; 3], amplitude: Box<dyn TimeFunction>) -> EccentricForce {
        let force = Vector3::from(g) * self.inertia.mass;
        EccentricForce::boxed(force.into(), self.center.into(), amplitude)
    }

    /// Kinetic energy; zero in statics.
    #[must_use]
    pub fn kinetic_energy(&self, at: &Motion<'_>) -> f64 {
        if at.v.is_empty() {
            return 0.0;
        }
        self.inertia
            .kinetic_energy(&triple(at.v, 0), &triple(at.x, 3), &triple(at.v, 3))
    }
}

fn check_inertia(J: &Matrix3<f64>) -> Result<(), BodyError> {
    let size = J.amax();
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        if (J[(i, j)] - J[(j, i)]).abs() > 1e-12 * size {
            return Err(BodyError::NotSymmetric {
                row: i + 1,
                column: j + 1,
                upper: J[(i, j)],
                lower: J[(j, i)],
            });
        }
    }
    let mut principal: [f64; 3] = J.symmetric_eigenvalues().into();
    principal.sort_by(f64::total_cmp);
    let [a, b, c] = principal;
    if a < -ROUND_OFF * size {
        return Err(BodyError::NegativeInertia { principal });
    }
    if c - (a + b) > FLAT * c {
        return Err(BodyError::Triangle { principal });
    }
    Ok(())
}

fn triple(x: &[f64], first: usize) -> Vector3<f64> {
    Vector3::new(x[first], x[first + 1], x[first + 2])
}

/// Adds a 6×6 matrix to an entry, if requested.
fn add(to: Option<&mut [f64]>, matrix: &Matrix6<f64>) {
    if let Some(to) = to {
        for (to, m) in to.iter_mut().zip(matrix.iter()) {
            *to += m;
        }
    }
}

impl Element for RigidBody {
    fn dim(&self) -> usize {
        6
    }

    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        Some(RigidBody::kinetic_energy(self, at))
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), ElementError> {
        if at.v.is_empty() {
            return Ok(());
        }
        let motion = FrameMotion {
            psi: triple(at.x, 3),
            psi_dot: triple(at.v, 3),
            psi_ddot: triple(at.a, 3),
            x_dot: triple(at.v, 0),
            x_ddot: triple(at.a, 0),
        };
        let psi = motion.psi.norm();
        if psi.is_nan() || psi > EDGE {
            return Err(ElementError::OutsideChart { psi });
        }
        let moving = self.inertia.moving(&motion);
        for (r, f) in out.r.iter_mut().zip(moving.force().iter()) {
            *r -= f;
        }
        if out.K.is_none() && out.C.is_none() {
            add(out.M.as_deref_mut(), &moving.mass());
            return Ok(());
        }
        let one = |K, C, M| moving.tangent(Weights { K, C, M });
        add(out.M.as_deref_mut(), &moving.mass());
        add(out.C.as_deref_mut(), &one(0.0, 1.0, 0.0));
        add(out.K.as_deref_mut(), &one(1.0, 0.0, 0.0));
        Ok(())
    }
}
