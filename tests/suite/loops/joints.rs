//! Loops of joints: the builder finds which joint closes a loop, and its coordinates; against
//! closed-form kinematics and equations of motion of one freedom.

#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::dynamics::*;
use crate::support::loops::four_bar::*;
use crate::support::loops::linkage::*;
use crate::support::loops::*;
use nalgebra::Vector3;
use pullback::elements::model::{Closure, Context, ModelBuilder, NodeId};
use pullback::elements::spring::{CoordinateLaw, CoordinateSpring};
use pullback::elements::time::{Sine, TimeFunction};
use pullback::integrators::dynamics::{Progress, Scheme};
use pullback::integrators::statics::{StaticOptions, solve_statics};
use pullback::manifold::jet::Moving;
use pullback::manifold::scalar::Scalar;
use pullback::manifold::system::{Evaluation, Point, System};
use std::ops::ControlFlow;

struct Motion {
    end: Vec<f64>,
    residual: f64,
    drift: f64,
    notes: Vec<(f64, String)>,
    progress: Progress,
}

fn go(mut context: Context, angles: [NodeId; 4], rate: f64, [to, step]: [f64; 2]) -> Motion {
    let n = context.pattern().dim();
    let zero = vec![0.0; n];
    let mut v = zero.clone();
    let left = context
        .fit_coordinate_rates(&zero, &mut v, &[(angles[0], 0, rate)])
        .unwrap();
    assert!(left < 1e-12, "{left:e}");
    let mut options = tight(Scheme::default(), to, step);
    options.newton.absolute = 1e-13;
    let mut out = Motion {
        end: Vec::new(),
        residual: 0.0,
        drift: 0.0,
        notes: context
            .descriptions()
            .into_iter()
            .map(|n| (0.0, n))
            .collect(),
        progress: Progress::default(),
    };
    let tips = ["tip of the coupler", "tip of the rocker"].map(|n| context.find(n).unwrap());
    let frame = context.find("C").unwrap();
    let mut start = None;
    let (mut end, mut residual, mut drift, mut notes) =
        (Vec::new(), 0.0_f64, 0.0_f64, out.notes.clone());
    out.progress = observed(&mut context, [&zero, &v], &options, &mut |context, step| {
        let both = [0, 1, 3].map(|k| context.coordinate(angles[k], 0).unwrap());
        let [a, b, d] = both;
        end = vec![a[0], a[0] + b[0], d[0], a[1], a[1] + b[1], d[1]];
        let [p, q] = tips.map(|n| context.node_state(n).position);
        let turn = context.node_state(frame).R - context.node_state(tips[1]).R;
        residual = residual.max((p - q).norm()).max(turn.norm());
        let note = context.descriptions()[0].clone();
        if notes.last().is_none_or(|last| last.1 != note) {
            notes.push((step.progress.state.t, note));
        }
        let at = point(&step.progress.state);
        let audit = context.energies_and_momentum(at).unwrap();
        let energy = audit.energies.kinetic + audit.energies.stored + audit.load_potential;
        drift = drift.max((energy - *start.get_or_insert(energy)).abs());
    });
    (out.end, out.residual, out.drift, out.notes) = (end, residual, drift, notes);
    out
}

#[test]
fn a_four_bar_linkage_of_bodies_and_joints() {
    let to = 3.0;
    let exact = four_bar_exact(to);
    let [coupler, rocker] = closed_form(CRANK_START);
    let drawn = [CRANK_START, coupler, rocker, 0.0, 0.0, 0.0];
    let runs = [1200, 2400, 4800].map(|n| {
        let mut b = ModelBuilder::new();
        let angles = linkage(&mut b, CRANK_START, at_once);
        let context = Context::new(b.build().unwrap());
        assert_eq!(context.pattern().dim(), 1);
        go(context, angles, CRANK_RATE, [to, to / f64::from(n)])
    });
    for run in &runs {
        let end: Vec<f64> = run.end.iter().zip(drawn).map(|(x, d)| x + d).collect();
        println!(
            "gap {:.2e}, drift {:.2e}, residual {:.1e}, {} steps, {:?}",
            gap(&end, &exact),
            run.drift,
            run.residual,
            run.progress.summary.steps,
            run.notes
        );
        // One coordinate is good all the way round: it is kept, though others are better at times.
        assert_eq!(run.notes.len(), 1, "{:?}", run.notes);
        assert!(run.residual < 1e-13, "{:e}", run.residual);
    }
    let errors: Vec<Vec<f64>> = runs
        .iter()
        .map(|r| {
            let end: Vec<f64> = r.end.iter().zip(drawn).map(|(x, d)| x + d).collect();
            vec![gap(&end, &exact), r.drift]
        })
        .collect();
    assert_slopes("four-bar", &["motion", "energy"], &errors, 2.0, 0.2);
}

/// A pendulum on the tip of the coupler, so that something is free where the crank is driven.
fn pendulum(b: &mut ModelBuilder) -> NodeId {
    let tip = b.find("tip of the coupler").unwrap();
    let from: [f64; 3] = b.position(tip).into();
    let to = [from[0] + 0.3, from[1] - 0.2, 0.0];
    link(b, "pendulum", tip, [from, to], (0.4, at_once)).coordinates[0]
}

#[test]
fn a_driven_crank_takes_the_loop_along() {
    let mut b = ModelBuilder::new();
    let angles = linkage(&mut b, CRANK_START, at_once);
    pendulum(&mut b);
    let drive = Sine {
        amplitude: 0.5,
        omega: 3.0,
        phase: 0.0,
        offset: 0.0,
    };
    b.prescribe_coordinate(angles[0], 0, drive);
    let mut context = Context::new(b.build().unwrap());
    assert_eq!(context.pattern().dim(), 1);
    assert!(
        context.descriptions()[0].contains("nothing is free"),
        "{:?}",
        context.descriptions()
    );
    let drawn = closed_form(CRANK_START);
    let options = tight(Scheme::default(), 2.5, 5e-3);
    let mut worst = 0.0_f64;
    observed(
        &mut context,
        [&[0.0], &[0.0]],
        &options,
        &mut |context, step| {
            let s = &step.progress.state;
            let at = point(s);
            context.configure(at).unwrap();
            let [x, x_dot, x_ddot] = drive.at(s.t, &[]);
            let crank = Moving::<0>::given([CRANK_START + x, x_dot, x_ddot]);
            let exact = closed_form(crank);
            let [a, b, d] = [0, 1, 3].map(|k| context.coordinate_motion(angles[k], 0).unwrap());
            for k in 0..3 {
                let of = |x: Moving<0>| x.x[k];
                let [first, second] = if k == 0 { drawn } else { [0.0; 2] };
                let (coupler, rocker) = (first + a[k] + b[k], second + d[k]);
                worst = worst.max((coupler - of(exact[0])).abs());
                worst = worst.max((rocker - of(exact[1])).abs());
            }
        },
    );
    println!("driven: {worst:.1e}");
    assert!(worst < 1e-11, "{worst:e}");
}

#[test]
fn a_loop_in_equilibrium() {
    // A torsional spring on the rocker against all weights.
    let stiffness = 300.0;
    let mut b = ModelBuilder::new();
    let angles = linkage(&mut b, CRANK_START, growing);
    let law = CoordinateLaw {
        k: stiffness,
        ..CoordinateLaw::default()
    };
    let spring = CoordinateSpring::new(law).unwrap();
    b.element("spring", spring, &[angles[3]]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    context.check_supports().unwrap();
    let mut q = Vec::new();
    let options = StaticOptions::default();
    solve_statics(&mut context, &mut q, &options, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap();
    let (t, v, a) = (1.0, &[][..], &[][..]);
    context.configure(Point { t, q: &q, v, a }).unwrap();
    let found = CRANK_START + context.coordinate(angles[0], 0).unwrap()[0];
    // The same by bisection of the slope of the potential.
    let drawn = closed_form(CRANK_START)[1];
    let slope = |crank: f64| {
        let crank = Moving::<0>::given([crank, 1.0, 0.0]);
        let [coupler, rocker] = closed_form(crank);
        let ([a, b, c], [m1, m2, m3]) = (BARS, MASSES);
        let turn = rocker - drawn;
        let V = crank.sin() * ((0.5 * m1 + m2) * G * a)
            + coupler.sin() * (0.5 * m2 * G * b)
            + rocker.sin() * (0.5 * m3 * G * c)
            + turn * turn * (0.5 * stiffness);
        V.x[1]
    };
    let (mut low, mut high) = (found - 0.2, found + 0.2);
    assert!(
        slope(low) * slope(high) < 0.0,
        "{} {}",
        slope(low),
        slope(high)
    );
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if slope(low) * slope(middle) <= 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    println!("equilibrium: crank {found}, exact {low}");
    assert!(
        (found - CRANK_START).abs() > 0.05,
        "it hardly moves: {found}"
    );
    assert!((found - low).abs() < 1e-8, "{found} {low}");
}

/// The linkage as another tree: the coupler on the rocker, closed at B.
fn other_tree(b: &mut ModelBuilder, crank: f64) -> NodeId {
    let [coupler, rocker] = closed_form(crank);
    let P = [BARS[0] * crank.cos(), BARS[0] * crank.sin(), 0.0];
    let Q = [BASE + BARS[2] * rocker.cos(), BARS[2] * rocker.sin(), 0.0];
    assert!((P[0] + BARS[1] * coupler.cos() - Q[0]).abs() < 1e-14);
    let ground = ground(b);
    let A = link(b, "A", ground, [[0.0; 3], P], (MASSES[0], at_once));
    let D = link(b, "D", ground, [[BASE, 0.0, 0.0], Q], (MASSES[2], at_once));
    let C = link(b, "C", D.frame, [Q, P], (MASSES[1], at_once));
    let tip = b.offset("tip of the coupler", C.frame, P).unwrap();
    let B = revolute(b, "B", tip, E3);
    let end = b.offset("tip of the crank", A.frame, P).unwrap();
    b.close(B.frame, end).unwrap();
    A.coordinates[0]
}

#[test]
fn forces_do_not_depend_on_where_the_loop_is_closed() {
    let forces = |mut context: Context, crank: NodeId| {
        let mut v = [0.0];
        context
            .fit_coordinate_rates(&[0.0], &mut v, &[(crank, 0, CRANK_RATE)])
            .unwrap();
        let nodes = ["B", "C"].map(|n| context.find(n).unwrap());
        let mut out = Vec::new();
        let options = tight(Scheme::default(), 0.3, 1e-2);
        observed(
            &mut context,
            [&[0.0], &v],
            &options,
            &mut |context, step| {
                let at = point(&step.progress.state);
                context.energies_and_momentum(at).unwrap();
                let mut r = [0.0];
                context.evaluate(at, Evaluation::residual(&mut r)).unwrap();
                out.push(nodes.map(|n| context.joint_force(n).unwrap()[0]));
            },
        );
        out
    };
    let mut b = ModelBuilder::new();
    let angles = linkage(&mut b, CRANK_START, at_once);
    let one = forces(Context::new(b.build().unwrap()), angles[0]);
    let mut b = ModelBuilder::new();
    let crank = other_tree(&mut b, CRANK_START);
    let other = forces(Context::new(b.build().unwrap()), crank);
    assert_eq!(one.len(), other.len());
    let mut size = 0.0_f64;
    for ([b, c], [d, e]) in one.iter().zip(&other) {
        // B acts on the coupler in one tree and on the crank in the other; C on the rocker, and on the
        // coupler. The crank's angle is the coordinate of both.
        size = size.max(b.norm());
        assert!((b + d).norm() < 1e-10 * (1.0 + b.norm()), "{b} {d}");
        assert!((c + e).norm() < 1e-10 * (1.0 + c.norm()), "{c} {e}");
    }
    assert!(size > 10.0, "{size}");
    // At the start both are at the same state: to rounding.
    let start = |mut context: Context, crank: NodeId| {
        let mut v = [0.0];
        context
            .fit_coordinate_rates(&[0.0], &mut v, &[(crank, 0, CRANK_RATE)])
            .unwrap();
        let mut options = tight(Scheme::default(), 0.0, 1e-2);
        options.to = 1e-9;
        options.step = 1e-9;
        options.min_step = 1e-12;
        let nodes = ["B", "C"].map(|n| context.find(n).unwrap());
        let mut out = [Vector3::zeros(); 2];
        observed(
            &mut context,
            [&[0.0], &v],
            &options,
            &mut |context, step| {
                let at = point(&step.progress.state);
                let mut r = [0.0];
                context.evaluate(at, Evaluation::residual(&mut r)).unwrap();
                out = nodes.map(|n| context.joint_force(n).unwrap()[0]);
            },
        );
        out
    };
    let mut b = ModelBuilder::new();
    let angles = linkage(&mut b, CRANK_START, at_once);
    let [one_b, one_c] = start(Context::new(b.build().unwrap()), angles[0]);
    let mut b = ModelBuilder::new();
    let crank = other_tree(&mut b, CRANK_START);
    let [other_b, other_c] = start(Context::new(b.build().unwrap()), crank);
    println!("B {one_b} {other_b} C {one_c} {other_c}");
    assert!(
        (one_b + other_b).norm() < 1e-6 * one_b.norm(),
        "{one_b} {other_b}"
    );
    assert!(
        (one_c + other_c).norm() < 1e-6 * one_c.norm(),
        "{one_c} {other_c}"
    );
}

#[test]
fn ball_joints_in_a_loop_change_their_charts() {
    // Crank about e3 and rocker about e1, with a coupler between two ball joints that may spin.
    let runs = [500, 1000, 2000].map(|n| {
        let mut b = ModelBuilder::new();
        let (rotation, e) = balls(&mut b, Closure::Map);
        let mut context = Context::new(b.build().unwrap());
        // Eight unknowns, six equations: the mechanism's freedom and the spin of the coupler.
        assert_eq!(context.pattern().dim(), 2);
        let zero = [0.0; 2];
        let mut v = zero;
        let spin = [0, 1, 2].map(|k| (rotation, k, 7.0 * e[k]));
        let left = context.fit_coordinate_rates(&zero, &mut v, &spin).unwrap();
        assert!(left < 1e-12, "{left:e}");
        let mut options = tight(Scheme::default(), 2.0, 2.0 / f64::from(n));
        options.newton.absolute = 1e-13;
        let names = ["coupler end", "rocker end"].map(|n| context.find(n).unwrap());
        let (mut residual, mut drift, mut start, mut turned) = (0.0_f64, 0.0_f64, None, 0.0_f64);
        let mut position = Vector3::zeros();
        let progress = observed(&mut context, [&zero, &v], &options, &mut |context, step| {
            let at = point(&step.progress.state);
            let audit = context.energies_and_momentum(at).unwrap();
            let [p, q] = names.map(|n| context.node_state(n).position);
            position = p;
            residual = residual.max((p - q).norm());
            turned = turned.max(context.coordinate(rotation, 0).unwrap()[0].abs());
            let energy = audit.energies.kinetic + audit.load_potential;
            drift = drift.max((energy - *start.get_or_insert(energy)).abs());
        });
        let changes = progress.summary.chart_changes;
        println!("balls: drift {drift:.2e}, residual {residual:.1e}, {changes} changes");
        assert!(residual < 1e-13, "{residual:e}");
        assert!(
            changes >= 2 && turned <= std::f64::consts::PI,
            "{changes} {turned}"
        );
        (vec![drift], position)
    });
    let drifts: Vec<Vec<f64>> = runs.iter().map(|r| r.0.clone()).collect();
    assert_slopes("balls", &["energy"], &drifts, 2.0, 0.25);
    let positions = runs.map(|r| r.1);
    let order =
        ((positions[0] - positions[1]).norm() / (positions[1] - positions[2]).norm()).log2();
    assert!((order - 2.0).abs() < 0.25, "{order}");
}
