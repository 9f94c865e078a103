//! Linkages of rigid bars that are closed by h(t, x) = 0, against their closed-form kinematics and
//! the equation of motion of their one freedom, integrated here.

use crate::support::dynamics::*;
use crate::support::loops::*;
use crate::support::prelude::*;
use pullback::conformance as check;
use pullback::elements::constraint::{Multipliers, Penalty, PenaltyStiffness, Scaled};

// Slider-crank ---------------------------------------------------------------------------------

const CRANK: f64 = 0.4;
const ROD: f64 = 1.0;

/// Crank pin (x, y) and slider s: coordinates that all turn back in every revolution.
#[derive(Clone, Copy, Debug)]
struct SliderCrank;

impl Implicit<3, 2> for SliderCrank {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 3>) -> SVector<S, 2> {
        let along = x[2] - x[0];
        Vector2::new(
            x[0] * x[0] + x[1] * x[1] - CRANK * CRANK,
            along * along + x[1] * x[1] - ROD * ROD,
        )
    }

    fn coordinate(&self, k: usize) -> String {
        ["x", "y", "s"][k].to_owned()
    }
}

/// A point with two coordinates in the plane.
#[derive(Clone, Copy)]
struct InPlane;

impl Map<2, 6> for InPlane {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 2>) -> SVector<S, 6> {
        let o = S::zero();
        SVector::<S, 6>::new(q[0], q[1], o, o, o, o)
    }
}

const PIN: f64 = 1.5;
const SLIDER: f64 = 0.8;
const STIFF: f64 = 6.0;

/// With masses, weights and a spring on the coordinates (x, y, s).
fn slider_crank(choice: Choice) -> (Context, NodeId, Vec<f64>) {
    let mut b = ModelBuilder::new();
    let map = ImplicitMap::of(SliderCrank, 1, 0.0, [0.4, 0.0, 1.4], choice).unwrap();
    // The crank turns with 12 rad/s at the start.
    let rate = map.rates(&[0.0, 12.0 * CRANK, 0.0]);
    let q = b.coordinates("q", &[Quantity::Length]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Quantity::Length; 3], Box::new(map), &[q])
        .unwrap();
    let [px, py, s] = [0, 1, 2].map(|k| pick::<3>(&mut b, x, k, Quantity::Length));
    let zero = Linear::<1, 1>::ratio(0.0, 0.0).boxed();
    let height = b
        .mapped_coordinates("0", &[Quantity::Length], zero, &[s])
        .unwrap();
    for (name, at, m) in [("pin", [px, py], PIN), ("slider", [s, height], SLIDER)] {
        let frame = b.mapped_node(name, [0.0; 3], InPlane.boxed(), &at).unwrap();
        let mass = PointMass::new(m).unwrap();
        let weight = mass.weight(DOWN, Constant(1.0));
        b.element(name, mass, &[frame]).unwrap();
        b.element(format!("weight of {name}"), weight, &[frame])
            .unwrap();
    }
    let law = CoordinateLaw {
        k: STIFF,
        x0: 1.0,
        ..CoordinateLaw::default()
    };
    b.element("spring", CoordinateSpring::new(law).unwrap(), &[s])
        .unwrap();
    (Context::new(b.build().unwrap()), x, rate)
}

#[test]
fn the_same_equations_by_multipliers_and_by_a_penalty_obey_the_laws_of_elements() {
    // x is drawn at zero: the equations see it from where the crank points along the slide.
    let drawn = Equations(Drawn(Vector3::new(CRANK, 0.0, CRANK + ROD)));
    let h = Scaled::at(drawn, 0.0, &Vector3::zeros(), &Vector3::repeat(1.0));
    check::element(&Multipliers::<_, 3, 2>::new(h)).assert();
    // Of equations that are not scaled, which have no end: at all states.
    let damped = PenaltyStiffness { p: 7.0, tau: 0.3 };
    check::element(&Penalty::<_, 3, 2>::new(drawn, damped).unwrap()).assert();
}

/// The slider-crank in coordinates that are zero where it is drawn.
#[derive(Clone, Copy, Debug)]
struct Drawn(Vector3<f64>);

impl Implicit<3, 2> for Drawn {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, 3>) -> SVector<S, 2> {
        SliderCrank.h(t, &(x + self.0.map(S::constant)))
    }
}

/// (x, y, s) and their rates from the crank angle and its rate, in closed form.
fn slider_crank_exact(to: f64) -> Vec<f64> {
    let position = |angle: f64| {
        let angle = Moving::<0>::given([angle, 1.0, 0.0]);
        let (x, y) = (angle.cos() * CRANK, angle.sin() * CRANK);
        (x, y, x + (-(y * y) + ROD * ROD).sqrt())
    };
    let ode = |_: f64, z: &Vector2<f64>| {
        let (_, y, s) = position(z[0]);
        let M = Moving::<0>::given([
            PIN * CRANK * CRANK + SLIDER * s.x[1] * s.x[1],
            2.0 * SLIDER * s.x[1] * s.x[2],
            0.0,
        ]);
        let V = y * (PIN * G) + (s - 1.0) * (s - 1.0) * (0.5 * STIFF);
        Vector2::new(z[1], one_freedom(M, V, z[1]))
    };
    let z = integrate_ode(&ode, Vector2::new(0.0, 12.0), to, 20_000);
    let (x, y, s) = position(z[0]);
    assert!(
        z[0] > 2.0 * std::f64::consts::TAU,
        "the crank went {}",
        z[0]
    );
    let all = [x, y, s];
    let [at, rates] = [0, 1].map(|k| all.map(|x| x.x[k]));
    [at, rates.map(|rate| rate * z[1])].concat()
}

#[test]
fn a_slider_crank_in_coordinates_that_turn_back() {
    let to = 4.0;
    let exact = slider_crank_exact(to);
    for choice in [Choice::Split, Choice::Tangent] {
        let errors = [2400, 4800, 9600].map(|n| {
            let (context, x, v) = slider_crank(choice);
            let h = |x: &Vector3<f64>| SliderCrank.h(0.0, x).amax();
            let run = run(context, x, &v, &h, [to, to / f64::from(n)]);
            let changes = run.progress.summary.chart_changes;
            assert!(changes >= 6, "{changes} changes: {:?}", run.notes);
            assert!(run.residual < 1e-15, "{:e}", run.residual);
            vec![gap(&run.end, &exact), run.drift]
        });
        assert_slopes("slider-crank", &["motion", "energy"], &errors, 2.0, 0.2);
    }
}

#[test]
fn the_residual_stays_at_round_off_for_long() {
    // 20 000 steps, some hundred revolutions.
    let (context, x, v) = slider_crank(Choice::Split);
    let h = |x: &Vector3<f64>| SliderCrank.h(0.0, x).amax();
    let run = run(context, x, &v, &h, [100.0, 5e-3]);
    assert!(run.progress.summary.chart_changes > 100);
    assert!(run.residual < 1e-15, "{:e}", run.residual);
}

// What cannot be built -------------------------------------------------------------------------

#[test]
fn coordinates_that_change_their_meaning_are_nobody_elses() {
    let build = |choice: Choice| {
        let map = ImplicitMap::of(SliderCrank, 1, 0.0, [0.4, 0.0, 1.4], choice).unwrap();
        let mut b = ModelBuilder::new();
        let q = b.coordinates("q", &[Quantity::Length]).unwrap();
        let x = b
            .mapped_coordinates("x", &[Quantity::Length; 3], Box::new(map), &[q])
            .unwrap();
        pick::<3>(&mut b, x, 0, Quantity::Length);
        spring(&mut b, 1.0, q);
        b.build().map(|_| ())
    };
    let error = build(Choice::Split).unwrap_err();
    assert!(
        matches!(error, ModelError::Reparametrized { .. }),
        "{error}"
    );
    assert!(error.to_string().contains("element spring"), "{error}");
    assert_eq!(build(Choice::Fixed), Ok(()));
}
