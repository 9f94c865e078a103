//! What the kit says of one joint in one line, `check::joint(&joint)`, where the joint is not one:
//! each error is called what it is.

use crate::support::*;
use pullback_manifold::so3::Quaternion;
use std::f64::consts::FRAC_PI_2;

type Posed<S> = (Vector3<S>, Quaternion<S>);

/// Joints on one frame, that move and turn from it by what a function of their own coordinates says.
macro_rules! joint {
    ($name:ident, $dim:literal, |$q:ident| $pose:expr, $released:expr) => {
        #[derive(Clone)]
        struct $name;

        impl Joint<$dim> for $name {
            fn pose<S: Scalar>(&self, _t: S, $q: &SVector<S, $dim>) -> Pose<S> {
                let (way, turn): Posed<S> = $pose;
                Pose::identity().translated(&way).rotated(&turn)
            }

            fn coordinates(&self) -> [JointCoordinate; $dim] {
                $released
            }
        }
    };
}

fn still<S: Scalar>() -> Quaternion<S> {
    Quaternion::about(&Vector3::y(), S::zero())
}

fn along<S: Scalar>(x: S) -> Vector3<S> {
    Vector3::new(x, S::zero(), S::zero())
}

fn about<S: Scalar>(angle: S) -> Posed<S> {
    (Vector3::zeros(), Quaternion::about(&Vector3::y(), angle))
}

/// As by hand with an axis of length 2.
fn long<S: Scalar>(angle: S) -> Posed<S> {
    let half = angle * 0.5;
    let v = Vector3::new(S::zero(), half.sin() * 2.0, S::zero());
    (Vector3::zeros(), Quaternion { w: half.cos(), v })
}

joint!(Right, 1, |q| about(q[0]), [("a", Quantity::Angle)]);
joint!(
    Twins,
    2,
    |q| (along(q[1]), about(q[0]).1),
    [("a", Quantity::Angle), ("a", Quantity::Length)]
);
joint!(Long, 1, |q| long(q[0]), [("a", Quantity::Angle)]);
joint!(
    Idle,
    2,
    |q| about(q[0]),
    [("a", Quantity::Angle), ("b", Quantity::Length)]
);
joint!(
    Turning,
    1,
    |q| (along(q[0] * q[0]), still()),
    [("s", Quantity::Other)]
);
joint!(
    Root,
    1,
    |q| (along((q[0] * q[0]).sqrt()) + Vector3::z() * q[0], still()),
    [("w", Quantity::Length)]
);

joint!(
    Unknown,
    1,
    |q| {
        let (way, mut turn) = about(q[0]);
        turn.w = S::constant(f64::NAN);
        (way, turn)
    },
    [("a", Quantity::Angle)]
);
joint!(Rotated, 1, |q| about(q[0] + 0.5), [("a", Quantity::Angle)]);

/// A joint with a domain that is no number.
#[derive(Clone)]
struct Unbounded;

impl Joint<1> for Unbounded {
    fn pose<S: Scalar>(&self, t: S, q: &SVector<S, 1>) -> Pose<S> {
        Right.pose(t, q)
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        Right.coordinates()
    }

    fn domain(&self, _t: f64, _q: &SVector<f64, 1>) -> Result<f64, DomainError> {
        Ok(f64::NAN)
    }
}

const NAMED: &str = "coordinates have names of their own";
const UNIT: &str = "the pose's quaternion has unit length";
const START: &str = "the child has the axes of its parent at q = 0";
const MOVES: &str = "moves with its coordinates";
const FINITE: &str = "values are finite";

/// The only law that fails, where, and what is said of it first.
fn only(report: &Report) -> (String, Vec<String>, String) {
    let failures = report.failures();
    let first = failures.first().unwrap_or_else(|| panic!("{report}"));
    let (law, why) = (first.law.clone(), first.measure.to_string());
    assert!(failures.iter().all(|row| row.law == law), "{report}");
    (
        law,
        failures.iter().map(|row| row.at.clone()).collect(),
        why,
    )
}

#[test]
fn a_right_joint_passes_and_its_own_laws_are_looked_at() {
    let report = check::joint(&Right);
    report.assert();
    for law in [NAMED, UNIT, START, MOVES] {
        assert!(report.rows().iter().any(|row| row.law == law), "{report}");
    }
}

#[test]
fn two_coordinates_of_one_name() {
    let (law, _, why) = only(&check::joint(&Twins));
    assert_eq!((law.as_str(), why.as_str()), (NAMED, "two have the name a"));
}

#[test]
fn a_quaternion_that_is_not_of_unit_length() {
    let report = check::joint(&Long);
    let first = &report.failures()[0];
    assert_eq!(first.law, UNIT, "{report}");
    // cos² + 4 sin² − 1 = 3 sin² of half the angle, which is zero at the origin only.
    assert_eq!(first.at, "random 1", "{report}");
}

#[test]
fn a_quaternion_that_is_no_number() {
    let report = check::joint(&Unknown);
    assert!(report.failing_laws().contains(&UNIT.to_owned()), "{report}");
    let failures = report.failures();
    for law in [UNIT, "domain"] {
        let failed = failures.iter().filter(|row| row.law == law);
        assert_eq!(failed.count(), 8, "{report}");
    }
}

#[test]
fn a_domain_that_is_no_number() {
    let report = check::joint(&Unbounded);
    assert_eq!(report.failing_laws(), ["domain"], "{report}");
    let why = "the distance to the edge of the domain is not a number";
    assert_eq!(report.failures()[0].measure.to_string(), why);
}

#[test]
fn a_pose_that_is_rotated_at_the_start() {
    let (law, positions, _) = only(&check::joint(&Rotated));
    assert_eq!(
        (law.as_str(), positions),
        (START, vec!["the reference".to_owned()])
    );
}

#[test]
fn a_model_with_one_is_refused_at_its_evaluation() {
    for turns_freely in [false, true] {
        let mut builder = ModelBuilder::new();
        let ground = builder.node("ground", [0.0; 3]).unwrap();
        builder.support(ground, &Dof::ALL);
        let child = match turns_freely {
            true => builder.attach_free("child", ground, Long).unwrap(),
            false => builder.attach("child", ground, Long).unwrap(),
        };
        let body = PointMass::new(1.0).unwrap();
        builder.element("body", body, &[child.frame]).unwrap();
        let mut context = Context::new(builder.build().unwrap());
        let dim = context.pattern().dim();
        let mut at = |q: f64| context.configure(Point::statics(0.0, &[q, 0.0, 0.0, 0.0][..dim]));
        at(0.0).unwrap();
        // cos² + 4 sin² of half the angle is 5/2 at a right angle.
        let length = 2.5_f64.sqrt();
        let error = at(FRAC_PI_2).unwrap_err().to_string();
        let expected = format!(
            "joint at node child: the quaternion of its pose has length {length:.6}: make it a unit quaternion"
        );
        assert_eq!(error, expected);
    }
}

#[test]
fn coordinates_without_effect() {
    let report = check::joint(&Idle);
    let (law, positions, why) = only(&report);
    assert_eq!((law.as_str(), positions.len()), (MOVES, 8), "{report}");
    assert_eq!(why, "it does not move with b (coordinate 2) there");
    let (law, positions, why) = only(&check::joint(&Turning));
    assert_eq!((law.as_str(), positions), (MOVES, vec!["0".to_owned()]));
    assert_eq!(why, "it does not move with s (coordinate 1) there");
}

/// √q² has no derivative at 0, and no number is one over jets: those of all other coordinates get lost
/// with it.
#[test]
fn entries_that_are_no_numbers() {
    let report = check::joint(&Root);
    let first = report.failures()[0];
    assert_eq!([&first.law[..], &first.at[..]], [FINITE, "0"], "{report}");
    let expected = "B is NaN in the row of coordinates 1 to 3 (1): phi has no derivative there; it has \
                    beside, in coordinate 7";
    assert_eq!(first.measure.to_string(), expected);
    assert!(first.blocks.is_empty(), "{report}");
    let there = report.failures().into_iter().filter(|row| row.at == "0");
    assert_eq!(there.count(), 1, "{report}");
}
