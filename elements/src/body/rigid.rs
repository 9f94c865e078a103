//! The rigid body.

use crate::blocks::{add, add_block, three};
use crate::element::{Abilities, Element, ElementEnergies, Motion, Properties, Response};
use crate::inertia::{Inertia, InertiaError, centrifugal, check};
use crate::load::EccentricForce;
use crate::time::TimeFunction;
use nalgebra::{Matrix3, Vector3};
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::pose::orientation;
use pullback_manifold::so3::skew;

/// Tolerance of the largest principal moment beyond the sum of the others, relative to itself: the inertia of a flat
/// body written with six digits.
const FLAT: f64 = 1e-5;

/// A rigid body moving with a frame node; dim 6. \[M04\] (119), (147), (152) without the integral.
///
/// The node need not be the centre of mass. With the first moment s and the inertia J about the node, both in
/// global components,
///
/// ```text
/// f = −(m ẍ + l),        l = ω̇ × s + ω × (ω × s)
/// m = −(s × ẍ + h),      h = J ω̇ + ω × J ω
/// ```
///
/// with exact M, C (gyroscopic) and K (centrifugal, with the accelerations); no force in statics. It
/// [reads poses](Properties::reads_poses).
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
    /// [`InertiaError`] for numbers that are not finite, a negative mass, an inertia that is not
    /// symmetric (to 1e-12 of its largest entry), not positive semidefinite or impossible (the
    /// largest principal moment exceeds the sum of the others by more than 1e-5 of itself), and for
    /// neither mass nor inertia.
    pub fn new(
        mass: f64,
        inertia: Matrix3<f64>,
        center: Vector3<f64>,
    ) -> Result<Self, InertiaError> {
        let position = ("the centre of mass", &center);
        let principal = check(mass, position, &inertia, &Matrix3::zeros())?;
        let [a, b, c] = principal;
        if c - (a + b) > FLAT * c {
            return Err(InertiaError::Triangle { principal });
        }
        let symmetric = (inertia + inertia.transpose()) * 0.5;
        let inertia = Inertia::about_centre(mass, center, symmetric);
        // The inertia about a distant node does not replace a missing mass.
        if mass == 0.0 && symmetric == Matrix3::zeros() {
            return Err(InertiaError::Massless);
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
    pub fn weight(
        &self,
        g: [f64; 3],
        amplitude: impl Into<Box<dyn TimeFunction>>,
    ) -> EccentricForce {
        let force = Vector3::from(g) * self.inertia.mass;
        EccentricForce::new(force.into(), self.center.into(), amplitude)
    }
}

impl Element for RigidBody {
    fn dim(&self) -> usize {
        6
    }

    fn properties(&self) -> Properties {
        Properties {
            reads_poses: true,
            ..Properties::INTERNAL
        }
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        if at.v.is_empty() {
            return Ok(());
        }
        let Inertia { mass, S, J } = self.inertia;
        let R = orientation(at.x).rotation();
        let (s, J) = (R * S, R * J * R.transpose());
        let (x_ddot, omega, omega_dot) = (three(at.a, 0), three(at.v, 3), three(at.a, 3));
        let J_omega = J * omega;
        let l = omega_dot.cross(&s) + omega.cross(&omega.cross(&s));
        let h = J * omega_dot + omega.cross(&J_omega);
        let f = x_ddot * mass + l;
        let m = s.cross(&x_ddot) + h;
        add(out.r, 0, &-f);
        add(out.r, 3, &-m);
        let spin = skew(&omega);
        let first = skew(&s);
        if let Some(M) = out.M.as_deref_mut() {
            add_block(M, 6, 0, 0, &Matrix3::from_diagonal_element(mass));
            add_block(M, 6, 0, 3, &-first);
            add_block(M, 6, 3, 0, &first);
            add_block(M, 6, 3, 3, &J);
        }
        // Both forces rotate with the body; the rest is due to δθ˙ alone.
        if let Some(C) = out.C.as_deref_mut() {
            let gyroscopic = spin * J - skew(&J_omega) - J * spin;
            add_block(C, 6, 0, 3, &(centrifugal(&omega, &s) + first * spin));
            add_block(C, 6, 3, 3, &gyroscopic);
        }
        if let Some(K) = out.K.as_deref_mut() {
            add_block(K, 6, 0, 3, &-skew(&l));
            add_block(K, 6, 3, 3, &(skew(&x_ddot) * first - skew(&h)));
        }
        Ok(())
    }
}

impl ElementEnergies for RigidBody {
    fn kinetic_energy(&self, at: &Motion<'_>) -> Option<f64> {
        if at.v.is_empty() {
            return Some(0.0);
        }
        let (v, omega) = (three(at.v, 0), three(at.v, 3));
        let turn = orientation(at.x);
        let own = turn.conjugate().rotate(&omega);
        let [s, J_omega] = [self.inertia.S, self.inertia.J * own].map(|u| turn.rotate(&u));
        let energy = 0.5 * self.inertia.mass * v.norm_squared()
            + v.dot(&omega.cross(&s))
            + 0.5 * omega.dot(&J_omega);
        Some(energy)
    }
}
