//! What the kit says of one joint in one line, `check::joint(&joint)`, where the joint is not one:
//! each error is called what it is.

use crate::support::*;
use pullback_manifold::so3::Quaternion;
use std::f64::consts::FRAC_PI_2;

/// What is wrong with a joint on one frame that turns from it about e2.
#[derive(Clone, Copy, PartialEq)]
enum Planted {
    Nothing,
    /// Its quaternion is that of an axis of length 2.
    Long,
    /// Its quaternion is not a number.
    Unknown,
    /// It is turned at the start.
    Rotated,
    /// It moves along e1 by the square of its coordinate, and does not turn.
    Square,
    /// The same by the root of the square, and along e3.
    Root,
    /// Its domain is not a number.
    Unbounded,
}

#[derive(Clone)]
struct One(Planted);

fn along<S: Scalar>(x: S) -> Vector3<S> {
    Vector3::new(x, S::zero(), S::zero())
}

fn about<S: Scalar>(angle: S) -> Quaternion<S> {
    Quaternion::about(&Vector3::y(), angle)
}

impl Joint<1> for One {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> Pose<S> {
        let (q, still) = (q[0], about(S::zero()));
        let (way, turn) = match self.0 {
            Planted::Nothing | Planted::Unbounded => (Vector3::zeros(), about(q)),
            Planted::Long => {
                let half = q * 0.5;
                let (w, v) = (half.cos(), Vector3::y() * (half.sin() * 2.0));
                (Vector3::zeros(), Quaternion { w, v })
            }
            Planted::Unknown => {
                let (w, v) = (S::constant(f64::NAN), about(q).v);
                (Vector3::zeros(), Quaternion { w, v })
            }
            Planted::Rotated => (Vector3::zeros(), about(q + 0.5)),
            Planted::Square => (along(q * q), still),
            Planted::Root => (along((q * q).sqrt()) + Vector3::z() * q, still),
        };
        Pose::identity().translated(&way).rotated(&turn)
    }

    fn coordinates(&self) -> [JointCoordinate; 1] {
        [match self.0 {
            Planted::Square => ("s", Quantity::Other),
            Planted::Root => ("w", Quantity::Length),
            _ => ("a", Quantity::Angle),
        }]
    }

    fn domain(&self, _t: f64, _q: &SVector<f64, 1>) -> Result<f64, DomainError> {
        match self.0 {
            Planted::Unbounded => Ok(f64::NAN),
            _ => Ok(f64::INFINITY),
        }
    }
}

/// It turns by its first coordinate, and moves by a second one of a name, or not.
#[derive(Clone)]
struct Two(&'static str, bool);

impl Joint<2> for Two {
    fn pose<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> Pose<S> {
        let way = if self.1 { q[1] } else { S::zero() };
        let pose = Pose::identity().translated(&along(way));
        pose.rotated(&about(q[0]))
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [("a", Quantity::Angle), (self.0, Quantity::Length)]
    }
}

const NAMED: &str = "coordinates have names of their own";
const UNIT: &str = "the pose's quaternion has unit length";
const START: &str = "the child has the axes of its parent at q = 0";
const MOVES: &str = "moves with its coordinates";
const FINITE: &str = "values are finite";

/// The only law that fails, where, and what is said of it first.
fn only(report: &Report) -> [String; 3] {
    let failures = report.failures();
    let first = failures.first().unwrap_or_else(|| panic!("{report}"));
    assert!(failures.iter().all(|row| row.law == first.law), "{report}");
    let positions: Vec<&str> = failures.iter().map(|row| &row.at[..]).collect();
    let why = first.measure.to_string();
    [first.law.clone(), positions.join(", "), why]
}

#[test]
fn a_right_joint_passes_and_its_own_laws_are_looked_at() {
    let report = check::joint(&One(Planted::Nothing));
    report.assert();
    for law in [NAMED, UNIT, START, MOVES] {
        assert!(report.rows().iter().any(|row| row.law == law), "{report}");
    }
}

#[test]
fn two_coordinates_of_one_name() {
    let found = only(&check::joint(&Two("a", true)));
    assert_eq!(found, [NAMED, "everywhere", "two have the name a"]);
}

#[test]
fn a_quaternion_that_is_not_of_unit_length() {
    let report = check::joint(&One(Planted::Long));
    let first = &report.failures()[0];
    assert_eq!(first.law, UNIT, "{report}");
    // cos² + 4 sin² − 1 = 3 sin² of half the angle, which is zero at the origin only.
    assert_eq!(first.at, "random 1", "{report}");
}

#[test]
fn a_quaternion_that_is_no_number() {
    let report = check::joint(&One(Planted::Unknown));
    assert!(report.failing_laws().contains(&UNIT.to_owned()), "{report}");
    let failures = report.failures();
    for law in [UNIT, "domain"] {
        let failed = failures.iter().filter(|row| row.law == law);
        assert_eq!(failed.count(), 8, "{report}");
    }
}

#[test]
fn a_domain_that_is_no_number() {
    let [law, _, why] = only(&check::joint(&One(Planted::Unbounded)));
    let expected = "the distance to the edge of the domain is not a number";
    assert_eq!([law, why], ["domain", expected]);
}

#[test]
fn a_pose_that_is_rotated_at_the_start() {
    let [law, at, _] = only(&check::joint(&One(Planted::Rotated)));
    assert_eq!([law, at], [START, "the reference"]);
}

/// A point mass that a joint holds to the ground, turning freely or not.
fn held(joint: One, turns_freely: bool) -> Context {
    let mut b = ModelBuilder::new();
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    let child = match turns_freely {
        true => b.attach_free("child", ground, joint).unwrap(),
        false => b.attach("child", ground, joint).unwrap(),
    };
    mass(&mut b, child.frame);
    Context::new(b.build().unwrap())
}

#[test]
fn a_model_with_one_is_refused_at_its_evaluation() {
    for turns_freely in [false, true] {
        let mut context = held(One(Planted::Long), turns_freely);
        let dim = context.pattern().dim();
        let mut at = |q: f64| context.configure(Point::statics(0.0, &[q, 0.0, 0.0, 0.0][..dim]));
        at(0.0).unwrap();
        // cos² + 4 sin² of half the angle is 5/2 at a right angle.
        let length = 2.5_f64.sqrt();
        let error = at(FRAC_PI_2).unwrap_err().to_string();
        let expected = format!(
            "joint at node child: the quaternion of its pose has length {length:.12}: make it a unit quaternion"
        );
        assert_eq!(error, expected);
    }
}

#[test]
fn a_pose_that_is_no_number_is_named() {
    let mut context = held(One(Planted::Unknown), false);
    let refused = context.configure(Point::statics(0.0, &[0.1])).unwrap_err();
    let said = "joint at node child: its pose is not finite";
    assert_eq!(refused.to_string(), said);
    // A step that has lost its way is too large.
    let refused = context
        .configure(Point::statics(0.0, &[f64::NAN]))
        .unwrap_err();
    assert!(refused.to_string().contains("take smaller steps"));
}

#[test]
fn coordinates_without_effect() {
    let [law, positions, why] = only(&check::joint(&Two("b", false)));
    let still = "it does not move with b (coordinate 2) there";
    assert_eq!([law, why], [MOVES, still]);
    assert_eq!(positions.split(", ").count(), 8, "{positions}");
    let found = only(&check::joint(&One(Planted::Square)));
    let still = "it does not move with s (coordinate 1) there";
    assert_eq!(found, [MOVES, "0", still]);
}

/// √q² has no derivative at 0, and no number is one over jets: those of all other coordinates get lost
/// with it.
#[test]
fn entries_that_are_no_numbers() {
    let report = check::joint(&One(Planted::Root));
    let first = report.failures()[0];
    assert_eq!([&first.law[..], &first.at[..]], [FINITE, "0"], "{report}");
    let expected = "B is NaN in the row of coordinates 1 to 3 (1): phi has no derivative there; it has \
                    beside, in coordinate 7";
    assert_eq!(first.measure.to_string(), expected);
    assert!(first.blocks.is_empty(), "{report}");
    let there = report.failures().into_iter().filter(|row| row.at == "0");
    assert_eq!(there.count(), 1, "{report}");
}
