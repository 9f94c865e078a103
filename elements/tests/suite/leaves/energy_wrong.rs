//! Errors that derivations by hand make, planted: the kit finds each, and names the law.

#![allow(non_snake_case)]

use crate::support::polynomial_spring::PolynomialSpring;
use crate::support::strain_beam::FrameInertia;
use nalgebra::{Matrix3, SVector, Vector3};
use pullback_conformance as check;
use pullback_elements::body::RigidBody;
use pullback_elements::element::{Abilities, Element, ElementEnergies, Motion, Response};
use pullback_elements::energy::EnergyElement;
use pullback_elements::spring::AxialSpring;
use pullback_manifold::domain::DomainError;
use pullback_manifold::scalar::Scalar;

/// Laws that fail, each once.
fn failing(element: &dyn Element) -> Vec<String> {
    laws(&check::element(element))
}

fn laws(report: &pullback_conformance::Report) -> Vec<String> {
    let mut laws: Vec<String> = report.failures().iter().map(|r| r.law.clone()).collect();
    laws.sort();
    laws.dedup();
    laws
}

/// Drag c ẋ³ on one coordinate, by hand: C = 3 c ẋ², times what the author believes.
struct Drag {
    c: f64,
    tangent: f64,
    force: f64,
}

impl Element for Drag {
    fn dim(&self) -> usize {
        1
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let v = at.v.first().copied().unwrap_or(0.0);
        out.r[0] -= self.force * self.c * v.powi(3);
        if let Some(C) = out.C.as_deref_mut() {
            C[0] += self.tangent * self.force * 3.0 * self.c * v * v;
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }
}

impl ElementEnergies for Drag {
    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.force * self.c * at.v.first().map_or(0.0, |v| v.powi(4))
    }
}

/// The same by its dissipation: v·∂D/∂v = 4 D.
struct DragByEnergy(f64);

impl EnergyElement<1> for DragByEnergy {
    fn dissipation<S: Scalar>(&self, _x: &SVector<S, 1>, v: &SVector<S, 1>) -> S {
        v[0] * v[0] * v[0] * v[0] * (0.25 * self.0)
    }
}

#[test]
fn a_lost_factor_of_two_in_a_damping_term() {
    let drag = |tangent, force| Drag {
        c: 0.8,
        tangent,
        force,
    };
    let twin = DragByEnergy(0.8).into_element();
    check::element(&twin).assert();
    check::element(&drag(1.0, 1.0)).assert();
    check::same(&drag(1.0, 1.0), &twin).assert();
    assert_eq!(failing(&drag(0.5, 1.0)), ["C = -dr/dv"]);
    // Lost in force and tangent alike it is another damper: only its twin tells.
    assert!(failing(&drag(1.0, 0.5)).is_empty());
    let against = laws(&check::same(&drag(1.0, 0.5), &twin));
    assert_eq!(against, ["C", "dissipation", "r"]);
}

/// An axial spring with its geometric stiffness N/l (I − e⊗e) subtracted instead of added.
struct SwappedSign(AxialSpring, [Vector3<f64>; 2]);

impl Element for SwappedSign {
    fn dim(&self) -> usize {
        12
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        self.0.evaluate(at, out)?;
        let N = self.0.tension(at)?;
        let Some(K) = out.K.as_deref_mut() else {
            return Ok(());
        };
        let d = |i: usize| Vector3::new(at.x[i], at.x[i + 1], at.x[i + 2]);
        let u = self.1[1] - self.1[0] + d(6) - d(0);
        let e = u.normalize();
        let G = (Matrix3::identity() - e * e.transpose()) * (-2.0 * N / u.norm());
        for (i, j) in [(0, 0), (0, 6), (6, 0), (6, 6)] {
            let sign = if i == j { 1.0 } else { -1.0 };
            for r in 0..3 {
                for c in 0..3 {
                    K[i + r + 12 * (j + c)] += sign * G[(r, c)];
                }
            }
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            combined: None,
            energies: self.0.abilities().energies,
            enforced: None,
            sections: None,
        }
    }
}

#[test]
fn a_swapped_sign_in_a_geometric_stiffness() {
    let positions = [Vector3::new(0.4, -0.9, 0.2), Vector3::new(1.5, 0.3, -0.4)];
    let spring = AxialSpring::new(&positions, 3.0, 0.0).unwrap();
    let spring = spring.with_rest_length(1.1).unwrap();
    let twin = PolynomialSpring {
        positions,
        rest_length: 1.1,
        k: [3.0],
        c: 0.0,
    };
    check::same(&spring, &twin.into_element()).assert();
    let wrong = SwappedSign(spring, positions);
    let found = failing(&wrong);
    assert!(found.contains(&"K = -dr/dx".to_owned()), "{found:?}");
    assert_eq!(laws(&check::same(&wrong, &twin.into_element())), ["K"]);
}

/// A rigid body without its gyroscopic term: in C alone, or Ω×JΩ in the force as well.
struct WithoutGyroscope(RigidBody);

impl Element for WithoutGyroscope {
    fn dim(&self) -> usize {
        6
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        check::InCharts(&self.0).evaluate(at, out)?;
        if let Some(C) = out.C.as_deref_mut() {
            C.fill(0.0);
        }
        Ok(())
    }
}

/// The kinetic energy of a body that believes Ω = Ψ̇: self-consistent, but no rigid body.
struct SmallRotations(FrameInertia);

impl EnergyElement<6> for SmallRotations {
    fn kinetic<S: Scalar>(&self, _x: &SVector<S, 6>, v: &SVector<S, 6>) -> S {
        self.0.kinetic(&SVector::zeros(), v)
    }
}

#[test]
fn a_missing_gyroscopic_term() {
    let J = Matrix3::new(0.9, 0.1, -0.05, 0.1, 0.7, 0.02, -0.05, 0.02, 0.5);
    let body = RigidBody::new(2.3, J, Vector3::zeros()).unwrap();
    let twin = FrameInertia {
        inertia: *body.inertia(),
        drag: 0.0,
    };
    let wrong = WithoutGyroscope(body);
    assert_eq!(failing(&wrong), ["C = -dr/dv"]);
    assert_eq!(laws(&check::same(&wrong, &twin.into_element())), ["C"]);
    // Left out of the force too, every law of an element holds; the kinetic energy tells.
    let linear = SmallRotations(twin).into_element();
    assert!(failing(&linear).is_empty());
    let against = laws(&check::same(&linear, &twin.into_element()));
    assert_eq!(against, ["C", "K", "M", "r"]);
}
