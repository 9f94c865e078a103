//! Elements by their energies: conformance, and agreement with what was derived by hand.

use crate::support::elastic_joint::ElasticJoint;
use crate::support::gravity::Gravity;
use crate::support::polynomial_spring::PolynomialSpring;
use crate::support::strain_beam::{FrameInertia, Reissner, strain_beam};
use crate::support::*;

fn positions() -> [Vector3<f64>; 2] {
    [Vector3::new(0.4, -0.9, 0.2), Vector3::new(1.5, 0.3, -0.4)]
}

fn frame() -> Matrix3<f64> {
    let [a, b] = positions();
    frame_along(&(b - a), Some(&Vector3::new(0.3, 0.2, 0.9)))
}

#[test]
fn reissners_beam_is_the_one_that_was_derived_by_hand() {
    for section in sections() {
        let hand = Beam::<2>::new(&positions(), &|_| frame(), &section).unwrap();
        let beam = strain_beam(Reissner, &positions(), &frame(), &section).unwrap();
        check::same(&beam, &hand).assert();
    }
}

#[test]
fn a_rigid_body_by_its_kinetic_energy() {
    let J = Matrix3::new(0.9, 0.1, -0.05, 0.1, 0.7, 0.02, -0.05, 0.02, 0.5);
    let hand = RigidBody::new(2.3, J, Vector3::new(0.2, 0.3, -0.2)).unwrap();
    let body = FrameInertia {
        inertia: *hand.inertia(),
        drag: 0.0,
    };
    check::element(&body.into_element()).assert();
    // By hand the statics of a body at the edge of its chart are not asked, so compare within.
    check::same(&body.into_element(), &hand).assert();
}

#[test]
fn springs() {
    let spring = PolynomialSpring {
        positions: positions(),
        rest_length: 1.1,
        k: [3.0, 0.0, 0.0],
        c: 0.7,
    };
    let hand = AxialSpring::new(&positions(), 3.0, 0.7).unwrap();
    let hand = hand.with_rest_length(1.1).unwrap();
    check::same(&spring.into_element(), &hand).assert();
    let hardening = PolynomialSpring {
        k: [3.0, -0.4, 0.9],
        positions: spring.positions,
        rest_length: 0.8,
        c: 0.3,
    };
    check::element(&hardening.into_element()).assert();
    // e = 2 at l = 2.8: N = 6 − 1.6 + 7.2, U = 6 − 0.4·8/3 + 0.9·4.
    let mut x = [0.0; 12];
    let along = (positions()[1] - positions()[0]).normalize();
    x[6..9].copy_from_slice((along * 2.8 + positions()[0] - positions()[1]).as_slice());
    let element = hardening.into_element();
    let r = residual(&element, &x, &[]).unwrap();
    for k in 0..3 {
        assert!((r[6 + k] + 11.6 * along[k]).abs() < 1e-13);
        assert!((r[k] - 11.6 * along[k]).abs() < 1e-13);
    }
    let energy = element.abilities().energy(&moving(&x, &[], &[]));
    assert!((energy - (6.0 - 3.2 / 3.0 + 3.6)).abs() < 1e-13);
    x[6..9].copy_from_slice((positions()[0] - positions()[1]).as_slice());
    refused! {
        residual(&element, &x, &[]) =>
            "its ends coincide (length 0.000e0): its force has no direction",
    }
}

/// The law of a [`CoordinateSpring`].
struct Cubic(CoordinateLaw);

impl EnergyElement<1> for Cubic {
    fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 1>) -> S {
        let square = (x[0] - self.0.x0).powi(2);
        (square * (0.25 * self.0.k3) + 0.5 * self.0.k) * square
    }

    fn dissipation<S: Scalar>(&self, _x: &SVector<S, 1>, v: &SVector<S, 1>) -> S {
        v[0] * v[0] * (0.5 * self.0.c)
    }
}

#[test]
fn a_coordinate_spring() {
    let hand = CoordinateSpring::new(LAW).unwrap();
    check::element(&hand).assert();
    check::same(&Cubic(LAW).into_element(), &hand).assert();
}

#[test]
fn a_bushing() {
    let [a, b] = positions();
    let joint = ElasticJoint {
        u0: b - a,
        K: full(0.3),
        D: full(1.7),
    };
    let hand = Bushing::new(&positions(), &Matrix3::identity(), &joint.K, &joint.D).unwrap();
    let joint = joint.into_element();
    check::element(&joint).assert();
    check::same(&joint, &hand).assert();
}

/// A dead force that changes with time: U = −f(t)·d.
struct Pull(Vector3<f64>, Sine);

impl EnergyElement<6> for Pull {
    fn potential<S: Scalar>(&self, t: S, x: &SVector<S, 6>) -> S {
        let sine = &self.1;
        let f = (t * sine.omega + sine.phase).sin() * sine.amplitude + sine.offset;
        -(x[0] * self.0.x + x[1] * self.0.y + x[2] * self.0.z) * f
    }

    fn properties(&self) -> Properties {
        Properties::LOAD
    }
}

#[test]
fn a_load_has_its_rate() {
    let sine = sine(1.7);
    let f = Vector3::new(0.8, -1.4, 2.2);
    let pull = Pull(f, sine).into_element();
    assert!(pull.properties().load);
    check::element(&pull).assert();
    let hand = NodalLoad::new(LoadKind::DeadForce, f.into(), sine);
    check::same(&pull, &hand).assert();
}

#[test]
fn gravity_pulls_with_the_square_of_the_distance() {
    let gravity = Gravity {
        position: Vector3::new(3.0, 0.0, 4.0),
        center: Vector3::zeros(),
        mu: 50.0,
        mass: 2.0,
    };
    let element = gravity.into_element();
    check::element(&element).assert();
    assert!(element.properties().load);
    let r = residual(&element, &[0.0; 6], &[]).unwrap();
    // 50·2/25 = 4 towards the centre.
    let expected = DVector::from_column_slice(&[-2.4, 0.0, -3.2, 0.0, 0.0, 0.0]);
    assert!((&r - expected).norm() < 1e-14, "{r:?}");
    assert!((element.abilities().energy(&moving(&[0.0; 6], &[], &[])) + 20.0).abs() < 1e-13);
    let there = [-3.0, 0.0, -4.0, 0.0, 0.0, 0.0];
    assert!(residual(&element, &there, &[]).is_err());
}

/// T = ½ v·M(x)v with a part linear in v: the force of a magnetic field.
struct Charged;

impl EnergyElement<2> for Charged {
    fn kinetic<S: Scalar>(&self, x: &SVector<S, 2>, v: &SVector<S, 2>) -> S {
        let mass = x[0].cos() * 0.5 + 2.0;
        v.dot(v) * mass * 0.5 + x[0] * v[1] * 3.0
    }
}

#[test]
fn a_kinetic_energy_linear_in_the_velocities_turns_the_motion() {
    let element = Charged.into_element();
    check::element(&element).assert();
    // At x₀ = 0 the mass is 2.5 and stationary: r = −2.5 a + 3 (v₁, −v₀).
    let (x, v, a) = ([0.0, 0.7], [0.4, -0.9], [1.0, 2.0]);
    let (r, _) = forces(&element, &moving(&x, &v, &a)).unwrap();
    assert!((r[0] - (-2.5 - 2.7)).abs() < 1e-14, "{r:?}");
    assert!((r[1] - (-5.0 - 1.2)).abs() < 1e-14, "{r:?}");
}

/// A spring to space or a steady load, in one type.
struct Mixed(bool);

impl EnergyElement<1> for Mixed {
    fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 1>) -> S {
        if self.0 { -x[0] } else { x[0] * x[0] }
    }

    fn properties(&self) -> Properties {
        match self.0 {
            true => Properties {
                time_independent: true,
                ..Properties::LOAD
            },
            false => Properties {
                objective: false,
                ..Properties::INTERNAL
            },
        }
    }
}

#[test]
fn points_are_a_load_only_if_all_of_them_are() {
    let points = |loads: [bool; 2]| {
        let one = SMatrix::identity();
        let sample = |load| EnergySample::new(Mixed(load), 1.0, SVector::zeros(), &one);
        ByEnergy::<1>::new(loads.map(sample)).properties()
    };
    for mixed in [[true, false], [false, true]] {
        let properties = points(mixed);
        assert!(!properties.load && !properties.time_independent && !properties.objective);
    }
    assert!(points([true; 2]).load && points([true; 2]).time_independent);
}
