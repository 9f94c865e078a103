//! The conformance kit fails when it should: errors planted in maps and charts.

use crate::support::*;
use pullback_conformance::Measure;
use pullback_manifold::so3::{Quaternion, log_quaternion, quaternion};
use std::f64::consts::PI;

/// What can be wrong with a hand-written map.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Planted {
    Nothing,
    /// φ over plain numbers is not φ over jets.
    Phi,
    B,
    SmallErrorInB,
    XDot,
    XDdotWithoutTime,
    BDotHalf,
    BDdot,
    KSigmaSign,
    KSigmaNotSymmetric,
    NotANumber,
    NoDomain,
}

impl Map<3, 2> for Planted {
    fn phi<S: Scalar>(&self, t: S, q: &SVector<S, 3>) -> SVector<S, 2> {
        let slip = if *self == Self::Phi && S::ORDER == 0 {
            S::constant(1.0 + 1e-4)
        } else {
            S::one()
        };
        SVector::<S, 2>::new(
            (q[0] * q[1] * slip + t).sin() + q[2] * t * t,
            (q[1] + q[2] * q[0] * 0.3).exp() * (t + 1.0),
        )
    }

    fn domain(&self, _t: f64, _q: &SVector<f64, 3>) -> Result<f64, DomainError> {
        let margin = if *self == Self::NoDomain { 0.0 } else { 1.0 };
        DomainError::within(margin, CHART_EDGE)
    }

    fn tangent(&self, t: f64, q: &SVector<f64, 3>) -> Tangent<3, 2> {
        let mut out = derived::tangent(self, t, q);
        match self {
            Self::B => out.B[(1, 2)] += 0.1 * q[0],
            Self::SmallErrorInB => out.B[(1, 1)] *= 1.0 + 3e-5,
            _ => {}
        }
        out
    }

    fn kinematics(
        &self,
        t: f64,
        q: &SVector<f64, 3>,
        v: &SVector<f64, 3>,
        a: &SVector<f64, 3>,
    ) -> Kinematics<3, 2> {
        let mut out = derived::kinematics(self, t, q, v, a);
        match self {
            Self::XDot => out.x_dot = out.B * v,
            Self::XDdotWithoutTime => out.x_ddot = out.B * a + out.B_dot * v,
            Self::BDotHalf => out.B_dot *= 0.5,
            Self::BDdot => out.B_ddot -= out.B_dot,
            Self::NotANumber => out.B_ddot[(0, 0)] = f64::NAN,
            _ => {}
        }
        out
    }

    fn geometric_stiffness(
        &self,
        t: f64,
        q: &SVector<f64, 3>,
        f: &SVector<f64, 2>,
    ) -> SMatrix<f64, 3, 3> {
        let mut K = derived::geometric_stiffness(self, t, q, f);
        match self {
            Self::KSigmaSign => K = -K,
            Self::KSigmaNotSymmetric => K[(2, 0)] += 0.05,
            _ => {}
        }
        K
    }
}

#[test]
fn every_law_of_a_map_finds_its_error() {
    check::map(&Planted::Nothing).assert();
    let (motion, kinematics) = ("B_dot, B_ddot along the motion", "kinematics = derived");
    let (stiffness, derived) = ("K_sigma = d(B'f)/dq", "geometric_stiffness = derived");
    let at_rest = "x and B are the same at rest and in motion";
    let wrong_B = &[
        "B = dphi/dq",
        motion,
        stiffness,
        "tangent = derived",
        at_rest,
    ];
    let wrong_rates = &[kinematics, "x_dot, x_ddot along the motion"];
    let cases: [(Planted, &[&str]); 11] = [
        (Planted::Phi, &["x = phi"]),
        (Planted::B, wrong_B),
        (Planted::SmallErrorInB, wrong_B),
        (Planted::XDot, wrong_rates),
        (Planted::XDdotWithoutTime, wrong_rates),
        (Planted::BDotHalf, &[motion, kinematics]),
        (Planted::BDdot, &[motion, kinematics]),
        (Planted::KSigmaSign, &[stiffness, derived]),
        (
            Planted::KSigmaNotSymmetric,
            &[stiffness, "K_sigma symmetric", derived],
        ),
        (Planted::NotANumber, &["values are finite"]),
        (Planted::NoDomain, &["domain"]),
    ];
    for (planted, expected) in cases {
        let report = check::map(&planted);
        assert!(!report.is_ok(), "{planted:?}");
        assert_eq!(report.failing_laws(), expected, "{planted:?}\n{report}");
    }
}

#[test]
fn reports_are_deterministic_tables() {
    let report = check::map(&Planted::BDotHalf);
    assert_eq!(report, check::map(&Planted::BDotHalf));
    let text = report.to_string();
    assert!(text.starts_with("Planted\n"), "{text}");
    assert!(
        text.contains("FAIL  B_dot, B_ddot along the motion"),
        "{text}"
    );
    assert!(text.contains("ok    B = dphi/dq"), "{text}");
    // A lost factor in Ḃ leaves a remainder of first order.
    let slope = report.failures().into_iter().find_map(|r| match r.measure {
        Measure::Slope { slope, .. } if r.at.starts_with("random") => Some(slope),
        _ => None,
    });
    assert!(slope.is_some_and(|s| (s - 1.0).abs() < 0.1), "{slope:?}");
    assert!(!Report::new("nothing was checked").is_ok());
    let panic = std::panic::catch_unwind(|| check::map(&Planted::KSigmaSign).assert());
    assert!(panic.is_err());
}

/// Rotation vectors with an error.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PlantedChart {
    Nothing,
    /// Coordinates that are not those of the quaternion.
    Coordinates,
    /// A quaternion that is no unit.
    Size,
    /// Coordinates of the shorter rotation vector for both quaternions.
    Short,
    /// No point is inside.
    Empty,
    /// c = tan(ψ/2) e, the same for both quaternions.
    Half,
    /// The chart ends at half a turn.
    Near,
}

impl RotationChart for PlantedChart {
    fn quaternion<S: Scalar>(&self, c: &Vector3<S>) -> Quaternion<S> {
        if *self == Self::Half {
            let w = (c.dot(c) + 1.0).sqrt().recip();
            return Quaternion { w, v: c * w };
        }
        let mut turn = quaternion(c);
        if *self == Self::Size {
            turn.w *= S::constant(1.0 + 1e-9);
        }
        turn
    }

    fn coordinates<S: Scalar>(&self, rotation: &Quaternion<S>) -> Vector3<S> {
        let c = log_quaternion(rotation);
        let other = rotation.opposite();
        match self {
            Self::Coordinates => c * S::constant(1.0 + 1e-9),
            Self::Half => rotation.v * rotation.w.recip(),
            Self::Short if rotation.w.re() < 0.0 => log_quaternion(&other),
            _ => c,
        }
    }

    fn margin(&self, c: &Vector3<f64>) -> f64 {
        match self {
            Self::Empty => f64::NAN,
            Self::Half => f64::INFINITY,
            Self::Near => PI - c.norm(),
            _ => TAU - c.norm(),
        }
    }
}

#[test]
fn every_law_of_a_chart_finds_its_error() {
    check::chart(&PlantedChart::Nothing).assert();
    let recovered = "coordinates(quaternion(c)) = c";
    for (chart, law) in [
        (PlantedChart::Coordinates, recovered),
        (PlantedChart::Coordinates, "rotation vector to chart"),
        (PlantedChart::Coordinates, "chart to opposite"),
        (PlantedChart::Size, "the quaternion is a unit"),
        (PlantedChart::Short, recovered),
    ] {
        let laws = check::chart(&chart).failing_laws();
        assert!(laws.contains(&law.to_owned()), "{chart:?}: {laws:?}");
    }
    for chart in [PlantedChart::Half, PlantedChart::Near] {
        let laws = check::chart(&chart).failing_laws();
        let expected = "rotations beyond half a turn have coordinates";
        assert_eq!(laws, [expected], "{chart:?}");
    }
    let laws = check::chart(&PlantedChart::Empty).failing_laws();
    assert_eq!(laws, ["domain"]);
}

/// q, and one more than that beyond 0.5 where no piece is kept; solved from equations or not.
#[derive(Clone)]
struct Leap {
    kept: bool,
    solved: Option<ImplicitMap>,
}

/// x = 0.
#[derive(Clone)]
struct Zero;

impl Implicit<1, 1> for Zero {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 1>) -> SVector<S, 1> {
        *x
    }
}

impl Map<1, 1> for Leap {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> SVector<S, 1> {
        let beyond = !self.kept && q[0].re() > 0.5;
        q.add_scalar(S::constant(f64::from(beyond)))
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl MapState for Leap {
    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        self.kept = at.is_some_and(|(_, q)| q[0] <= 0.5);
    }

    fn implicit(&mut self) -> Option<&mut ImplicitMap> {
        self.solved.as_mut()
    }
}

/// The size of q, by the sign that q had at the last change of charts, which is saved or forgotten.
#[derive(Clone)]
struct Size {
    negative: bool,
    saved: bool,
}

impl Map<1, 1> for Size {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> SVector<S, 1> {
        if self.negative { -q } else { *q }
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl MapState for Size {
    fn change_charts(&mut self, _t: f64, q: &[f64]) -> ChartChanges {
        let before = std::mem::replace(&mut self.negative, q[0] < 0.0);
        ChartChanges::of(usize::from(before != self.negative))
    }

    fn save(&self) -> Vec<f64> {
        let state = self.saved.then_some(f64::from(self.negative));
        state.into_iter().collect()
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        if let [negative] = saved {
            self.negative = *negative == 1.0;
        }
        saved.len() == usize::from(self.saved)
    }
}

#[test]
fn a_state_that_is_not_saved_is_found() {
    for saved in [true, false] {
        let negative = false;
        let laws = check::parametrization(&*Size { negative, saved }.boxed()).failing_laws();
        let expected = ["state saved and restored"];
        assert_eq!(laws, &expected[usize::from(saved)..]);
    }
}

#[test]
fn pieces_are_those_of_formulas_and_no_branches_of_equations() {
    let zero = ImplicitMap::of(Zero, 0, 0.0, [0.0], Choice::Split).unwrap();
    for solved in [None, Some(zero)] {
        let explicit = solved.is_none();
        let kept = false;
        let map = Leap { kept, solved }.boxed();
        let mut report = Report::new("leap");
        let layout = check::Layout::plain(1);
        let of = check::Mapped {
            map: &*map,
            rows: &layout,
            columns: &layout,
        };
        let x = nalgebra::DVector::zeros(1);
        let state = check::TestState::statics(0.0, x);
        check::pieces(&mut report, of, "there", &state, &mut check::Random::new(1));
        assert_eq!(report.failures().len(), usize::from(explicit), "{report}");
    }
}
