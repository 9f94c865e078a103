//! Linkages of rigid bars that are closed by h(t, x) = 0, against their closed-form kinematics and
//! the equation of motion of their one freedom, integrated here.

#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::dynamics::*;
use crate::support::loops::four_bar::*;
use crate::support::loops::*;
use nalgebra::{SVector, Vector2, Vector3};
use pullback::conformance as check;
use pullback::elements::body::PointMass;
use pullback::elements::constraint::{Multipliers, Penalty, PenaltyStiffness, Scaled};

use pullback::elements::model::{Context, ModelBuilder, ModelError, NodeId};
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::elements::time::Constant;
use pullback::integrators::dynamics::Scheme;
use pullback::manifold::implicit::{Choice, Equations, Implicit, ImplicitMap};
use pullback::manifold::jet::Moving;
use pullback::manifold::map::{Linear, Map, Parametrization};
use pullback::manifold::scalar::Scalar;
use pullback::manifold::system::Quantity;

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

fn slider_crank(choice: Choice) -> (Context, NodeId, Vec<f64>) {
    let mut b = ModelBuilder::new();
    let map = ImplicitMap::of(SliderCrank, 1, 0.0, [0.4, 0.0, 1.4], choice).unwrap();
    // The crank turns with 12 rad/s at the start.
    let rate = map.rates(&[0.0, 12.0 * CRANK, 0.0]);
    let q = b.coordinates("q", &[Quantity::Length]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Quantity::Length; 3], Box::new(map), &[q])
        .unwrap();
    slider_crank_bodies(&mut b, x);
    (Context::new(b.build().unwrap()), x, rate)
}

/// Masses, weights and the spring on the coordinates (x, y, s).
fn slider_crank_bodies(b: &mut ModelBuilder, x: NodeId) {
    let [px, py, s] = [0, 1, 2].map(|k| pick::<3>(b, x, k, Quantity::Length));
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
}

#[test]
fn the_same_equations_by_multipliers_and_by_a_penalty() {
    // x is drawn at zero: the equations see it from where the crank points along the slide.
    let at = Vector3::new(CRANK, 0.0, CRANK + ROD);
    let h = Scaled::at(
        Equations(Drawn(at)),
        0.0,
        &Vector3::zeros(),
        &Vector3::repeat(1.0),
    );
    check::element(&Multipliers::<_, 3, 2>::new(h)).assert();
    let stiffness = |p: f64| PenaltyStiffness { p, tau: 1e-3 };
    let damped = PenaltyStiffness { p: 7.0, tau: 0.3 };
    // Of equations that are not scaled, which have no end: at all states.
    check::element(&Penalty::<_, 3, 2>::new(Equations(Drawn(at)), damped).unwrap()).assert();
    let to = 1.5;
    let exact = slider_crank_exact(to);
    let go = |n: u32, p: Option<f64>| {
        let mut b = ModelBuilder::new();
        let x = b.coordinates("x", &[Quantity::Length; 3]).unwrap();
        let shifted = b
            .mapped_coordinates("position", &[Quantity::Length; 3], Shift(at).boxed(), &[x])
            .unwrap();
        slider_crank_bodies(&mut b, shifted);
        match p {
            None => {
                let lambda = b.multipliers("lambda", 2).unwrap();
                b.element("h", Multipliers::<_, 3, 2>::new(h), &[x, lambda])
            }
            Some(p) => b.element("h", Penalty::<_, 3, 2>::new(h, stiffness(p)).unwrap(), &[x]),
        }
        .unwrap();
        let mut context = Context::new(b.build().unwrap());
        let (mut q, mut v) = (
            context.initial().to_vec(),
            vec![0.0; context.initial().len()],
        );
        v[1] = 12.0 * CRANK;
        assert!(context.project_state(0.0, &mut q, &mut v, &[1]).unwrap() < 1e-14);
        let scheme = Scheme::chung_hulbert(0.8).unwrap();
        let options = tight(scheme, to, to / f64::from(n));
        let mut end = Vec::new();
        observed(&mut context, [&q, &v], &options, &mut |context, _| {
            let both = [0, 1, 2].map(|k| context.coordinate(shifted, k).unwrap());
            end = (0..6).map(|k| both[k % 3][k / 3]).collect();
        });
        end
    };
    let errors: Vec<Vec<f64>> = [900, 1800, 3600]
        .iter()
        .map(|&n| {
            let end = go(n, None);
            println!("slider-crank by multipliers: {:.2e}", gap(&end, &exact));
            vec![gap(&end[..3], &exact[..3]), gap(&end[3..], &exact[3..])]
        })
        .collect();
    assert_slopes("slider-crank", &["x", "x_dot"], &errors, 2.0, 0.2);
    let limit = go(900, None);
    let errors: Vec<Vec<f64>> = [1e6, 2e6, 4e6]
        .iter()
        .map(|&p| {
            let end = go(900, Some(p));
            println!("slider-crank by a penalty: {:.2e}", gap(&end, &limit));
            vec![gap(&end[..3], &limit[..3]), gap(&end[3..], &limit[3..])]
        })
        .collect();
    assert_slopes("penalty", &["x", "x_dot"], &errors, 1.0, 0.1);
}

/// The slider-crank in coordinates that are zero where it is drawn.
#[derive(Clone, Copy, Debug)]
struct Drawn(Vector3<f64>);

impl Implicit<3, 2> for Drawn {
    fn h<S: Scalar>(&self, t: S, x: &SVector<S, 3>) -> SVector<S, 2> {
        SliderCrank.h(t, &(x + self.0.map(S::constant)))
    }
}

#[derive(Clone, Copy)]
struct Shift(Vector3<f64>);

impl Map<3, 3> for Shift {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 3>) -> SVector<S, 3> {
        q + self.0.map(S::constant)
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
        let runs = [2400, 4800, 9600].map(|n| {
            let (context, x, v) = slider_crank(choice);
            let h = |x: &Vector3<f64>| SliderCrank.h(0.0, x).amax();
            run(context, x, &v, &h, [to, to / f64::from(n)])
        });
        for run in &runs {
            let changes = run.progress.summary.chart_changes;
            println!(
                "{choice:?}: {changes} changes, gap {:.2e}, drift {:.2e}, residual {:.1e}",
                gap(&run.end, &exact),
                run.drift,
                run.residual
            );
            assert!(changes >= 6, "{changes} changes: {:?}", run.notes);
            assert!(run.residual < 1e-15, "{:e}", run.residual);
        }
        let errors: Vec<Vec<f64>> = runs
            .iter()
            .map(|r| vec![gap(&r.end, &exact), r.drift])
            .collect();
        assert_slopes("slider-crank", &["motion", "energy"], &errors, 2.0, 0.2);
    }
}

// Four-bar linkage -----------------------------------------------------------------------------

/// Angles of crank, coupler and rocker.
#[derive(Clone, Copy, Debug)]
struct FourBar;

impl Implicit<3, 2> for FourBar {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 3>) -> SVector<S, 2> {
        let [a, b, c] = BARS;
        Vector2::new(
            x[0].cos() * a + x[1].cos() * b - x[2].cos() * c - BASE,
            x[0].sin() * a + x[1].sin() * b - x[2].sin() * c,
        )
    }

    fn coordinate(&self, k: usize) -> String {
        ["crank", "coupler", "rocker"][k].to_owned()
    }
}

fn four_bar() -> (Context, NodeId, Vec<f64>) {
    let [coupler, rocker] = closed_form(CRANK_START);
    let guess = [CRANK_START + 0.05, coupler - 0.05, rocker];
    let assembled = |guess| ImplicitMap::of(FourBar, 1, 0.0, guess, Choice::Split).unwrap();
    // From the assembled configuration to the one that is wanted: the crank as q.
    let mut map = assembled(guess).with_independent(&[0]).unwrap();
    let (mut x, mut B) = ([0.0; 3], [0.0; 3]);
    let q = [CRANK_START - map.reference()[0]];
    map.evaluate(0.0, [&q, &[], &[]], &mut [[&mut x, &mut B]]);
    let mut map = assembled(x);
    assert!(gap(&map.reference(), &[CRANK_START, coupler, rocker]) < 1e-15);
    map.evaluate(0.0, [&[0.0], &[], &[]], &mut [[&mut x, &mut B]]);
    let rate = CRANK_RATE / B[0];
    let (mut b, ground) = grounded();
    let q = b.coordinates("q", &[Quantity::Angle]).unwrap();
    let x = b
        .mapped_coordinates("x", &[Quantity::Angle; 3], Box::new(map), &[q])
        .unwrap();
    let crank = pick::<3>(&mut b, x, 0, Quantity::Angle);
    let relative = Linear::sum([-1.0, 1.0, 0.0], 0.0).boxed();
    let coupler = b
        .mapped_coordinates("relative", &[Quantity::Angle], relative, &[x])
        .unwrap();
    let third = pick::<3>(&mut b, x, 2, Quantity::Angle);
    let first = bar(&mut b, ground, [0.0; 3], crank, BARS[0], MASSES[0]);
    bar(
        &mut b,
        first,
        [BARS[0], 0.0, 0.0],
        coupler,
        BARS[1],
        MASSES[1],
    );
    bar(&mut b, ground, [BASE, 0.0, 0.0], third, BARS[2], MASSES[2]);
    (Context::new(b.build().unwrap()), x, vec![rate])
}

#[test]
fn a_four_bar_linkage_goes_around() {
    let to = 3.0;
    let exact = four_bar_exact(to);
    let runs = [2400, 4800, 9600].map(|n| {
        let (context, x, v) = four_bar();
        let h = |x: &Vector3<f64>| FourBar.h(0.0, x).amax();
        run(context, x, &v, &h, [to, to / f64::from(n)])
    });
    for run in &runs {
        println!(
            "gap {:.2e}, drift {:.2e}, residual {:.1e}, {:?}",
            gap(&run.end, &exact),
            run.drift,
            run.residual,
            run.notes
        );
        // Not before the first step, but on the way.
        let changed = run.notes.iter().any(|(t, _)| *t > 0.01 * to);
        assert!(changed, "no change: {:?}", run.notes);
        assert!(run.residual < 1e-14, "{:e}", run.residual);
    }
    let errors: Vec<Vec<f64>> = runs
        .iter()
        .map(|r| vec![gap(&r.end, &exact), r.drift])
        .collect();
    assert_slopes("four-bar", &["motion", "energy"], &errors, 2.0, 0.2);
}

#[test]
fn the_residual_stays_at_round_off_for_long() {
    // 20 000 steps, some hundred revolutions.
    let (context, x, v) = slider_crank(Choice::Split);
    let h = |x: &Vector3<f64>| SliderCrank.h(0.0, x).amax();
    let run = run(context, x, &v, &h, [100.0, 5e-3]);
    println!(
        "long: {} changes, residual {:.1e}, drift {:.1e}",
        run.progress.summary.chart_changes, run.residual, run.drift
    );
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
        let law = CoordinateLaw {
            k: 1.0,
            ..CoordinateLaw::default()
        };
        b.element("spring", CoordinateSpring::new(law).unwrap(), &[q])
            .unwrap();
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
