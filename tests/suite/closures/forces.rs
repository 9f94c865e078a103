//! One constraint, three methods: the map, multipliers and a penalty, against each other and against
//! closed-form kinematics, an equation of motion of one freedom, and Newton's laws for the pin.

use super::started_with;
use crate::support::closures::{arm, body_of, fixed};
use crate::support::dynamics::*;
use crate::support::loops::four_bar::*;
use crate::support::loops::linkage::*;
use crate::support::loops::*;
use crate::support::prelude::*;
use crate::support::program::{assert_says, number, recorded};
use nalgebra::{DMatrix, DVector};
use pullback::elements::constraint::PenaltyStiffness;
use pullback::integrators::linear_solver::{AutoSolver, LinearSolver, MatrixSymmetry, scaling};

/// With dampers, so that what vibrates at first does not stay.
fn penalty(p: f64) -> Closure {
    Closure::Penalty(PenaltyStiffness { p, tau: 1e-3 })
}

/// What a run leaves behind.
struct Outcome {
    /// Angles of crank, coupler and rocker, and their rates.
    end: Vec<f64>,
    /// Force of the coupler on the rocker at the end, as vectors at all times.
    force: Vec<Vector3<f64>>,
    /// Largest gap on the way.
    gap: f64,
}

/// The linkage, its joints, and its coordinates and velocities at the start.
fn under_way(by: Closure) -> (Context, [NodeId; 4], [Vec<f64>; 2]) {
    let mut b = ModelBuilder::new();
    let angles = linkage(&mut b, CRANK_START, at_once, by);
    let mut context = Context::new(b.build().unwrap());
    let start = started_with(&mut context, &[(angles[0], 0, CRANK_RATE)]);
    (context, angles, start)
}

fn go(by: Closure, [to, step]: [f64; 2]) -> Outcome {
    follow(by, tight(Scheme::chung_hulbert(0.8).unwrap(), to, step))
}

fn follow(by: Closure, mut options: DynamicOptions) -> Outcome {
    let (mut context, angles, [q, v]) = under_way(by);
    options.newton.absolute = 1e-12;
    let [tip, other, pin] =
        ["tip of the coupler", "tip of the rocker", "C"].map(|n| context.find(n).unwrap());
    let [coupler, rocker] = closed_form(BARS, CRANK_START);
    let (mut end, mut force, mut gap) = (Vec::new(), Vec::new(), 0.0_f64);
    observed(&mut context, [&q, &v], &options, &mut |context, step| {
        let [a, b, d] = [0, 1, 3].map(|k| context.coordinate(angles[k], 0).unwrap());
        end = vec![
            CRANK_START + a[0],
            coupler + a[0] + b[0],
            rocker + d[0],
            a[1],
            a[1] + b[1],
            d[1],
        ];
        gap =
            gap.max((context.node_state(tip).position - context.node_state(other).position).norm());
        let s = &step.progress.state;
        let at = point(s);
        force.push(context.forces(at).unwrap().joint_force(pin).unwrap()[0]);
    });
    Outcome { end, force, gap }
}

fn flat(force: &Vector3<f64>) -> Vector2<f64> {
    assert!(force.z.abs() < 1e-9, "{force}");
    force.xy()
}

/// Errors of angles, rates and the force at the end.
fn off(run: &Outcome, exact: &[f64], force: Vector2<f64>) -> [f64; 3] {
    [
        gap(&run.end[..3], &exact[..3]),
        gap(&run.end[3..], &exact[3..]),
        (flat(run.force.last().unwrap()) - force).norm(),
    ]
}

#[test]
fn multipliers_are_of_order_two_with_their_forces() {
    let to = 1.6;
    let exact = four_bar_exact(to);
    let force = pin_force(exact[0], exact[3]);
    for by in [Closure::Map, Closure::Multipliers] {
        let errors = [800, 1600, 3200].map(|n| {
            let run = go(by, [to, to / f64::from(n)]);
            assert!(run.gap < 1e-11, "{by:?}: {:e}", run.gap);
            off(&run, &exact, force).to_vec()
        });
        let names = ["angles", "rates", "force"];
        assert_slopes("four-bar", &names, &errors, 2.0, 0.2);
    }
}

/// Steps whose size changes have forces as exact as the motion: a hundredth of the tolerance leaves a tenth of the errors at
/// most, as the local error of order three allows twice as much.
#[test]
fn forces_of_multipliers_follow_the_tolerance_of_adaptive_steps() {
    let to = 1.6;
    let exact = four_bar_exact(to);
    let force = pin_force(exact[0], exact[3]);
    let errors = [1e-5, 1e-7].map(|tolerance| {
        let scheme = Scheme::chung_hulbert(0.9).unwrap();
        let options = DynamicOptions {
            adaptivity: Some(Adaptivity {
                tolerance,
                max_step: 0.1,
            }),
            ..tight(scheme, to, 1e-3)
        };
        off(&follow(Closure::Multipliers, options), &exact, force)
    });
    for (loose, tight) in errors[0].iter().zip(errors[1]) {
        assert!(tight < 0.1 * loose, "{errors:?}");
    }
    assert!(errors[1][2] < 1e-3 * force.norm(), "{errors:?}");
}

/// Two bars between ball joints, closed by a third one: rotation vectors that change their chart at half a turn have forces as
/// exact as those since the last step, which never do.
#[test]
fn forces_of_multipliers_pass_changes_of_chart() {
    let model = |scheme: &str, step: f64| {
        let ball = |name: &str, parent: &str, more: &str| {
            format!(
                "[[joints]]\nname = \"{name}\"\ntype = \"spherical\"\nparent = \"{parent}\"\n{more}\n"
            )
        };
        [
            "[nodes]\nbase = [0, 0, 0]\nfoot = [1.3, 1.1, 0]\n",
            &ball("A", "base", ""),
            &arm("a", "A", [1.0, 0.0, 0.2]),
            &ball("B", "a", ""),
            &arm("b", "B", [1.3, 1.1, 0.0]),
            &ball("C", "b", "child = \"foot\"\nclosure = \"multipliers\""),
            &body_of(
                "A",
                1.2,
                "center = [0.5, 0.1, 0.1]\ninertia = [0.1, 0.12, 0.2]",
            ),
            &body_of(
                "B",
                0.8,
                "center = [0.15, 0.5, -0.1]\ninertia = [0.09, 0.06, 0.1]",
            ),
            &fixed("base"),
            &fixed("foot"),
            // Each bar spins about the line between its ends.
            "[[initial]]\nnode = \"A\"\nangular_velocity = [6.0, 0.0, 1.2]\n",
            "[[initial]]\nnode = \"B\"\nangular_velocity = [3.6, 13.2, -2.4]\n",
            "[[probes]]\nname = \"F\"\nquantity = \"joint_force\"\njoint = \"C\"\n",
            &format!("[analysis.dynamic]\nto = 0.6\nstep = {step}\nscheme = \"{scheme}\"\n"),
            "[analysis.dynamic.newton]\nrelative = 1e-10\n",
        ]
        .concat()
    };
    let gaps = [0.0025, 0.00125, 0.000625].map(|step| {
        let runs = ["ga:0.8", "ul-ga:0.8"].map(|scheme| {
            let rows = recorded(&format!("spatial-{scheme}-{step}"), &model(scheme, step));
            let force = |row: &_| ["F.x", "F.y", "F.z"].map(|c| number(row, c));
            rows.iter().map(force).collect::<Vec<_>>()
        });
        let [total, since] = &runs;
        assert_eq!(total.len(), since.len());
        let off = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (a[k] - b[k]).abs()).sum::<f64>();
        total.iter().zip(since).map(off).fold(0.0, f64::max)
    });
    let names = ["force"];
    assert_slopes("bars", &names, &gaps.map(|gap| vec![gap]), 2.0, 0.2);
}

#[test]
fn a_penalty_is_of_order_one_in_its_compliance() {
    // At the same steps.
    let span = [0.4, 1e-4];
    let limit = go(Closure::Multipliers, span);
    let force = flat(limit.force.last().unwrap());
    let all = [1e6, 2e6, 4e6].map(|p| off(&go(penalty(p), span), &limit.end, force).to_vec());
    assert_slopes("penalty", &["angles", "rates", "force"], &all, 1.0, 0.1);
}

// In equilibrium -------------------------------------------------------------------------------

/// Crank angle and pin force of the linkage under its weights, a spring on the rocker.
fn equilibrium(by: Closure) -> (f64, Vector2<f64>) {
    let mut b = ModelBuilder::new();
    let angles = linkage(&mut b, CRANK_START, growing, by);
    spring(&mut b, 300.0, angles[3]);
    let mut context = Context::new(b.build().unwrap());
    assert_eq!(context.free_motion(), None);
    let mut q = context.initial().to_vec();
    let options = StaticOptions {
        newton: StaticNewtonOptions {
            relative: 1e-13,
            ..StaticNewtonOptions::default()
        },
        ..StaticOptions::default()
    };
    solve_statics(&mut context, &mut q, &options, &mut |_, _| {
        ControlFlow::Continue(())
    })
    .unwrap();
    let (t, v, a) = (1.0, &[][..], &[][..]);
    let pin = context.find("C").unwrap();
    let forces = context.forces(Point { t, q: &q, v, a }).unwrap();
    let force = forces.joint_force(pin).unwrap()[0];
    let crank = context.coordinate(angles[0], 0).unwrap()[0];
    (CRANK_START + crank, flat(&force))
}

#[test]
fn a_loop_in_equilibrium_all_three_ways() {
    let (crank, force) = equilibrium(Closure::Map);
    assert!((crank - CRANK_START).abs() > 0.05, "it hardly moves");
    // The slope of the potential over its curvature is how far the crank is off.
    let bars = by_crank(crank);
    let twist = bars[2] - closed_form(BARS, CRANK_START)[1];
    let V = mass_and_potential(BARS, bars)[1] + twist * twist * (0.5 * 300.0);
    assert!((V.x[1] / V.x[2]).abs() < 1e-8, "{V:?}");
    // The rocker in balance about its foot: r × F + (r/2) × weight = k times its turn.
    let [_, rocker] = closed_form(BARS, crank);
    let turn = rocker - closed_form(BARS, CRANK_START)[1];
    let r = Vector2::new(rocker.cos(), rocker.sin()) * BARS[2];
    let weight = Vector2::new(0.0, -G * MASSES[2]);
    let balance = r.perp(&force) + (r * 0.5).perp(&weight) - 300.0 * turn;
    assert!(balance.abs() < 1e-8, "{balance:e}");
    let (by_multipliers, its_force) = equilibrium(Closure::Multipliers);
    assert!((crank - by_multipliers).abs() < 1e-11);
    assert!((force - its_force).norm() < 1e-9 * force.norm());
    let all = [1e6, 2e6, 4e6].map(|p| {
        let (other, its_force) = equilibrium(penalty(p));
        vec![(other - crank).abs(), (its_force - force).norm()]
    });
    assert_slopes("statics", &["crank", "force"], &all, 1.0, 0.02);
}

// Steps ----------------------------------------------------------------------------------------

#[test]
fn conditioning_does_not_depend_on_the_step() {
    let (mut context, _, [q, v]) = under_way(Closure::Multipliers);
    let n = q.len();
    let a = vec![0.0; n];
    let (t, q, v, a) = (0.0, &q, &v, &a);
    let at = Point { t, q, v, a };
    let pattern = context.pattern().clone();
    let mut conditions = [Vec::new(), Vec::new()];
    for k in 2..8 {
        let h = 10.0_f64.powi(-k);
        let weights = Weights {
            K: 1.0,
            C: 2.0 / h,
            M: 4.0 / (h * h),
        };
        let (mut r, mut S) = (vec![0.0; n], vec![0.0; pattern.len()]);
        let out = Evaluation::with_tangent(&mut r, weights, &mut S);
        context.evaluate(at, out).unwrap();
        let mut scales = vec![1.0; n];
        let dense = |scales: &[f64]| {
            let scales = DMatrix::from_diagonal(&DVector::from_column_slice(scales));
            &scales * pattern.matrix(&S) * &scales
        };
        let condition = |A: DMatrix<f64>| {
            let values = A.singular_values();
            values.max() / values.min()
        };
        let raw = condition(dense(&scales));
        // The solver takes zeros on the diagonal, whatever the step: against a dense solution.
        let b: Vec<f64> = (0..n).map(|i| (1.3 * i as f64).sin()).collect();
        let mut solver = AutoSolver::new(&pattern, MatrixSymmetry::General).unwrap();
        solver.factorise(&S).unwrap();
        let mut x = b.clone();
        solver.solve(Some(&S), &mut x).unwrap();
        scaling::equilibrate(&pattern, &S, &mut scales, &mut vec![0.0; n]).unwrap();
        let scaled = DVector::from_fn(n, |i, _| b[i] * scales[i]);
        let exact = dense(&scales).lu().solve(&scaled).unwrap();
        let found = DVector::from_fn(n, |i, _| x[i] / scales[i]);
        assert!((found - &exact).amax() < 1e-12 * exact.amax());
        conditions[0].push(raw);
        conditions[1].push(condition(dense(&scales)));
    }
    let spread = |c: &[f64]| {
        let least = c.iter().copied().fold(f64::INFINITY, f64::min);
        c.iter().copied().fold(0.0, f64::max) / least
    };
    let [raw, solved] = conditions.map(|c| spread(&c));
    assert!(raw > 1e8 && solved < 10.0, "{raw:.1e} {solved:.1e}");
}

// What is refused ------------------------------------------------------------------------------

#[test]
fn a_scheme_that_damps_nothing_is_refused_by_name() {
    let run = |scheme: Scheme, by: Closure| {
        let (mut context, _, [q, v]) = under_way(by);
        let first = start(&context, 0.0, &q, &v).unwrap();
        Simulation::new(&mut context, first, &tight(scheme, 0.01, 1e-3))?.finish()
    };
    for scheme in [
        Scheme::default(),
        Scheme::newmark(0.3, 0.6).unwrap(),
        Scheme::wbz(1.0).unwrap(),
        Scheme::chung_hulbert(1.0).unwrap(),
        Scheme::hht(0.0).unwrap(),
    ] {
        let error = run(scheme, Closure::Multipliers).unwrap_err();
        assert!(matches!(error, DynamicsError::Undamped { .. }), "{error}");
        let said = error.to_string();
        assert_says(&said, &[scheme.name, "multipliers of C", "ga:0.8"]);
        run(scheme, Closure::Map).unwrap();
    }
    // (γ + ½)²/4: damped.
    run(Scheme::newmark(0.3025, 0.6).unwrap(), Closure::Multipliers).unwrap();
}

#[test]
fn an_equation_that_followed_at_a_singular_start_only_is_named() {
    // All bars on one line: there the gap across it follows from nothing else, but the loop is
    // drawn where its equations have no full rank.
    let (mut b, ground) = grounded();
    let [O, P, Q, D] = [0.0, 1.0, 2.5, 1.5].map(|x| [x, 0.0, 0.0]);
    let A = link(&mut b, "A", ground, [O, P], (1.0, at_once));
    let B = link(&mut b, "B", A.frame, [P, Q], (1.0, at_once));
    let rocker = link(&mut b, "D", ground, [D, Q], (1.0, at_once));
    let tip = b.offset("tip", B.frame, Q).unwrap();
    let C = revolute(&mut b, "C", tip, E3);
    let end = b.offset("end", rocker.frame, Q).unwrap();
    b.close_by(C.frame, end, Closure::Multipliers).unwrap();
    let mut context = Context::new(b.build().unwrap());
    let note = context.descriptions()[0].clone();
    assert!(note.contains("the gap along e1"), "{note}");
    let zero = vec![0.0; context.pattern().dim()];
    let first = start(&context, 0.0, &zero, &zero).unwrap();
    let options = tight(Scheme::chung_hulbert(0.5).unwrap(), 0.5, 1e-3);
    let run = Simulation::new(&mut context, first, &options);
    let error = run.and_then(|mut run| run.finish()).unwrap_err();
    let said = error.to_string();
    let words = [
        "the gap along e1 of element closure of C",
        "singular position",
    ];
    assert_says(&said, &words);
}
