//! Errors that derivations by hand make, planted: the kit finds each, and names the law.

use crate::support::*;
use pullback_elements::constraint::{Penalty, PenaltyStiffness};

/// Laws that fail, each once.
fn failing(element: &dyn Element) -> Vec<String> {
    check::element(element).failing_laws()
}

/// Drag c ẋ³ on one coordinate, by hand: C = 3 c ẋ² and c ẋ⁴ lost, times what the author believes of the
/// tangent, the force and what is lost.
struct Drag(f64, f64, f64);

const DRAG: f64 = 0.8;

impl Element for Drag {
    fn dim(&self) -> usize {
        1
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        let v = at.v.first().copied().unwrap_or(0.0);
        out.r[0] -= self.1 * DRAG * v.powi(3);
        if let Some(C) = out.C.as_deref_mut() {
            C[0] += self.0 * self.1 * 3.0 * DRAG * v * v;
        }
        Ok(())
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }
}

impl ElementEnergies for Drag {
    fn dissipation(&self, at: &Motion<'_>) -> f64 {
        self.2 * self.1 * DRAG * at.v.first().map_or(0.0, |v| v.powi(4))
    }
}

/// The same by its dissipation: v·∂D/∂v = 4 D.
struct DragByEnergy;

impl EnergyElement<1> for DragByEnergy {
    fn dissipation<S: Scalar>(&self, _x: &SVector<S, 1>, v: &SVector<S, 1>) -> S {
        v[0] * v[0] * v[0] * v[0] * (0.25 * DRAG)
    }
}

const RIGHT: Drag = Drag(1.0, 1.0, 1.0);

#[test]
fn a_lost_factor_of_two_in_a_damping_term() {
    let twin = DragByEnergy.into_element();
    check::element(&twin).assert();
    check::element(&RIGHT).assert();
    check::same(&RIGHT, &twin).assert();
    let tangent = Drag(0.5, 1.0, 1.0);
    assert_eq!(failing(&tangent), ["C = -dr/dv"]);
    assert_eq!(check::same(&tangent, &twin).failing_laws(), ["C"]);
    // Lost in force and tangent alike it is another damper: only its twin tells.
    let force = Drag(1.0, 0.5, 1.0);
    assert!(failing(&force).is_empty());
    let against = check::same(&force, &twin);
    assert_eq!(against.failing_laws(), ["C", "dissipation", "r"]);
}

#[test]
fn a_wrong_dissipation() {
    let claiming = |lost| failing(&Drag(1.0, 1.0, lost));
    let power = "power of damping = -dissipation".to_owned();
    assert!(claiming(1.001).contains(&power));
    assert!(claiming(-1.0).contains(&"dissipation >= 0".to_owned()));
}

/// ½ v² + magnetic x v₂ + quartic v⁴.
struct Kinetic {
    magnetic: f64,
    quartic: f64,
}

impl EnergyElement<2> for Kinetic {
    fn kinetic<S: Scalar>(&self, x: &SVector<S, 2>, v: &SVector<S, 2>) -> S {
        let square = v.dot(v);
        square * 0.5 + x[0] * v[1] * self.magnetic + square * square * self.quartic
    }
}

#[test]
fn a_kinetic_energy_that_is_not_quadratic() {
    let of = |magnetic, quartic| Kinetic { magnetic, quartic }.into_element();
    check::element(&of(1.5, 0.0)).assert();
    assert_eq!(failing(&of(0.0, 0.25)), ["M the same at rest"]);
}

#[test]
fn another_inertia() {
    let body = |mass| RigidBody::new(mass, Matrix3::identity(), Vector3::x()).unwrap();
    let against = check::same(&body(2.3), &body(2.2));
    assert_eq!(against.failing_laws(), ["C", "K", "M", "r"]);
}

/// A force on one coordinate that claims not to depend on time: c + s t, with the potential −e c x − o t.
struct Claim {
    growth: f64,
    energy: f64,
    offset: f64,
}

impl Element for Claim {
    fn dim(&self) -> usize {
        1
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        out.r[0] += 2.0 + self.growth * at.t;
        if let Some(r_t) = out.r_t.as_deref_mut() {
            r_t[0] += self.growth;
        }
        Ok(())
    }

    fn properties(&self) -> Properties {
        Properties {
            time_independent: true,
            ..Properties::LOAD
        }
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities::of_energies(self)
    }
}

impl ElementEnergies for Claim {
    fn energy(&self, at: &Motion<'_>) -> f64 {
        -self.energy * (2.0 + self.growth * at.t) * at.x[0] - self.offset * at.t
    }
}

#[test]
fn a_load_that_is_not_steady_or_has_no_potential() {
    let claim = |growth, energy, offset| {
        failing(&Claim {
            growth,
            energy,
            offset,
        })
    };
    let steady = "a steady load does not change with time";
    assert!(claim(0.0, 1.0, 0.0).is_empty());
    assert_eq!(claim(0.3, 1.0, 0.0), [steady]);
    assert_eq!(claim(0.0, 1.0, 0.3), [steady]);
    assert_eq!(claim(0.0, 0.0, 0.0), ["r = -dE/dx"]);
}

/// A load with the energies that only internal elements have, and this mass.
struct Odd(f64);

impl EnergyElement<1> for Odd {
    fn kinetic<S: Scalar>(&self, _x: &SVector<S, 1>, v: &SVector<S, 1>) -> S {
        v[0] * v[0] * (0.5 * self.0)
    }

    fn dissipation<S: Scalar>(&self, _x: &SVector<S, 1>, v: &SVector<S, 1>) -> S {
        v[0] * v[0]
    }

    fn properties(&self) -> Properties {
        Properties::LOAD
    }
}

/// What a load dissipates is part of the power that it supplies.
#[test]
fn a_load_has_no_mass_and_dissipates_what_it_supplies() {
    assert_eq!(failing(&Odd(1.0).into_element()), ["a load has no mass"]);
    check::element(&Odd(0.0).into_element()).assert();
    let mut b = ModelBuilder::new();
    let x = b.coordinates("x", &[Quantity::Length]).unwrap();
    let law = CoordinateLaw {
        k: 1.0,
        ..CoordinateLaw::default()
    };
    b.element("spring", CoordinateSpring::new(law).unwrap(), &[x])
        .unwrap();
    b.element("brake", Odd(0.0).into_element(), &[x]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let at = point(0.0, [&[0.0], &[3.0], &[0.0]]);
    let energies = context.energies(at).unwrap();
    assert_eq!([energies.supplied, energies.dissipated], [-18.0, 0.0]);
    assert_eq!(context.dissipation(at).unwrap(), 0.0);
}

/// A wall that moves and turns: h = x cos t + y − sin 3t.
#[derive(Clone, Copy)]
struct Wall;

impl Implicit<2, 1> for Wall {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(x[0] * t.cos() + x[1] - (t * 3.0).sin())
    }
}

#[test]
fn a_damped_penalty_of_a_moving_wall() {
    let stiffness = PenaltyStiffness { p: 30.0, tau: 0.2 };
    let wall = Penalty::<_, 2, 1>::new(Equations(Wall), stiffness).unwrap();
    let report = check::element(&wall);
    let mut rows = (report.rows().iter())
        .filter(|row| row.law == "r_t = dr/dt" && row.at.ends_with("moving"))
        .peekable();
    assert!(rows.peek().is_some(), "{report}");
    assert!(rows.all(|row| row.passed), "{report}");
}
