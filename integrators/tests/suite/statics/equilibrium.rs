//! Statics on systems small enough to be solved by hand: no beam is known here.

use crate::support::statics::*;
use crate::support::*;

/// Options of a path with events, the last of which ends it.
fn with_events<const N: usize>(events: [Event; N]) -> ArcLengthOptions {
    let last = |(k, event)| (event, k + 1 == N);
    ArcLengthOptions {
        events: events.into_iter().enumerate().map(last).collect(),
        newton: TIGHT,
        ..ArcLengthOptions::default()
    }
}

/// What a function takes from each step along a path of the truss.
fn traced<T>(
    q: &mut Vec<f64>,
    options: &ArcLengthOptions,
    of: impl Fn(&Step<'_>) -> T,
) -> (Vec<T>, StaticSummary) {
    let mut seen = Vec::new();
    let summary = trace_path(&mut truss(), q, options, &mut |_, step| {
        seen.push(of(step));
        ControlFlow::Continue(())
    });
    (seen, summary.unwrap())
}

/// The events along a path, each with its load and w.
fn events(q: &mut Vec<f64>, options: &ArcLengthOptions) -> Vec<(usize, f64, f64)> {
    let (steps, summary) = traced(q, options, |step| Some((step.event?, step.t, step.q[0])));
    assert!(summary.finished, "{summary:?}");
    steps.into_iter().flatten().collect()
}

#[test]
fn the_truss_snaps_through_and_back() {
    let options = with_events([Event::TurningPoint, Event::Load(0.5)]);
    let mut q = vec![0.0];
    let there = events(&mut q, &options);
    let back_options = ArcLengthOptions {
        from: 0.5,
        forward: false,
        ..with_events([Event::TurningPoint, Event::Load(-0.5)])
    };
    let back = events(&mut q, &back_options);
    let root = 1.0 / 3.0_f64.sqrt();
    for (path, signs) in [(&there, [1.0, -1.0]), (&back, [-1.0, 1.0])] {
        assert_eq!(path.len(), 3);
        for (k, sign) in signs.into_iter().enumerate() {
            let (event, load, w) = path[k];
            assert_eq!(event, 0);
            assert!((load - sign * LIMIT).abs() < 1e-12, "{load}");
            assert!((w - (1.0 - sign * root)).abs() < 1e-5, "{w}");
        }
    }
    assert!((there[2].1 - 0.5).abs() < 1e-12);
    assert!((back[2].1 + 0.5).abs() < 1e-12);
}

#[test]
fn the_truss_is_unstable_between_its_limit_points() {
    let root = 1.0 / 3.0_f64.sqrt();
    let options = with_events([Event::TurningPoint, Event::Load(0.2), Event::Load(0.5)]);
    let row = |step: &Step<'_>| (step.event, step.unstable, step.q[0]);
    let mut seen = [0; 3];
    for (event, unstable, w) in traced(&mut vec![], &options, row).0 {
        let expected = usize::from((w - 1.0).abs() < root);
        let at_limit = event == Some(0);
        assert!(at_limit || unstable == Some(expected), "w = {w}");
        seen[if at_limit { 2 } else { expected }] += 1;
    }
    assert!(seen[0] > 5 && seen[1] > 5 && seen[2] == 2, "{seen:?}");
}

#[test]
fn no_step_along_a_path_is_longer_than_the_longest() {
    let options = ArcLengthOptions {
        first_step: 0.2,
        max_step: 0.01,
        ..with_events([Event::Load(0.1)])
    };
    let (sizes, _) = traced(&mut vec![0.0], &options, |step| step.step_size);
    assert!(sizes.iter().all(|ds| *ds <= 0.01), "{sizes:?}");
}

#[test]
fn load_steps_one_by_one_end_at_the_load() {
    let options = StaticOptions {
        to: 0.3,
        newton: TIGHT,
        ..StaticOptions::equal_steps(3)
    };
    let mut system = truss();
    let mut run = LoadSteps::new(&mut system, Vec::new(), &options).unwrap();
    let mut before = -1.0;
    while let Some(step) = run.step().unwrap() {
        let (t, w) = (step.t, step.q[0]);
        assert!(t > before && (w * (w - 1.0) * (w - 2.0) - t).abs() < 1e-12);
        before = t;
    }
    assert_eq!(before, 0.3);
    assert!(run.step().unwrap().is_none() && run.summary().finished);
}

#[test]
fn coordinates_are_located_as_often_as_they_are_passed() {
    let (unknown, value) = (0, 1.5);
    let options = with_events([Event::Coordinate { unknown, value }, Event::Load(0.5)]);
    let found = events(&mut vec![0.0], &options);
    assert_eq!(found.len(), 2);
    // f(1.5) = 1.5 · 0.5 · (−0.5).
    assert!((found[0].1 + 0.375).abs() < 1e-11);
}

#[test]
fn what_happens_exactly_at_the_end_of_a_step_is_located_once() {
    let path = |first: Event| {
        let options = with_events([first, Event::Load(0.5)]);
        let row = |step: &Step<'_>| (step.event, step.number, step.t, step.q[0]);
        traced(&mut vec![], &options, row).0
    };
    let (_, number, t, w) = path(Event::Load(9.0))[2];
    let there = Event::Coordinate {
        unknown: 0,
        value: w,
    };
    for event in [Event::Load(t), there] {
        let steps = path(event);
        let mut found = steps.iter().filter(|(event, ..)| *event == Some(0));
        assert_eq!(found.next(), Some(&(Some(0), number, t, w)));
        // The load is the same once more behind the first limit point, and once behind the second.
        let again = found.next().map(|(_, number, ..)| *number);
        let near = [Some(number), Some(number + 1)];
        assert!(!near.contains(&again), "{steps:?}");
    }
}

#[test]
fn load_control_stops_at_a_limit_point_and_says_where() {
    let options = StaticOptions {
        to: 0.5,
        max_step: 0.05,
        ..StaticOptions::default()
    };
    let outcome = solve_statics(&mut truss(), &mut vec![], &options, &mut |_, step| {
        // No step may have jumped across: the branch before the limit has w < 1 − 1/√3.
        assert!(step.t <= LIMIT || step.q[0] > 2.0);
        match step.q[0] > 1.0 {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    });
    // Beyond the limit load equilibrium exists on the far branch (w > 2): reaching it is right,
    // failing is right, anything else is not.
    match outcome {
        Ok(summary) => assert!(summary.t > LIMIT),
        Err(StaticsError::Step(failed)) => {
            assert!(failed.from <= LIMIT, "{failed}");
            assert!(failed.to >= LIMIT - 1e-4, "{failed}");
            assert!(failed.to_string().contains("the crown, downwards"));
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn easy_steps_grow_and_the_end_is_met_exactly() {
    let mut spring = Scalar::new(1.0, |w| [w, 1.0]);
    let mut steps = Vec::new();
    let mut q = vec![];
    let options = StaticOptions {
        first_step: 0.1,
        max_step: 0.4,
        ..StaticOptions::default()
    };
    let summary = solve_statics(&mut spring, &mut q, &options, &mut |_, step| {
        steps.push(step.step_size);
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(summary.finished);
    assert_eq!(summary.t, 1.0);
    assert_eq!(steps.len(), 5);
    for (step, wanted) in steps.iter().zip([0.0, 0.1, 0.2, 0.4, 0.3]) {
        assert!((step - wanted).abs() < 1e-15);
    }
    assert!((q[0] - 1.0).abs() < 1e-15);
}

/// A spring that has no force beyond w = 0.55.
fn bounded() -> Scalar {
    Scalar::new(1.0, |w| [if w > 0.55 { f64::NAN } else { w }, 1.0])
}

#[test]
fn a_value_that_is_not_finite_fails_with_its_name() {
    let failed = failed_step(equilibrium(&mut bounded(), &StaticOptions::default()));
    assert!(failed.from <= 0.55 && failed.from > 0.54, "{failed}");
    assert!(failed.rejected > 10);
    assert!(matches!(
        failed.cause,
        Cause::System(SystemError::NotFinite { .. })
    ));
    assert!(failed.to_string().contains("the spring"));
}

#[test]
fn a_table_of_iterations_has_the_quantities_that_occur() {
    let mut failed = failed_step(equilibrium(&mut bounded(), &StaticOptions::default()));
    failed.history = vec![Iteration {
        residual: [0.0, 0.25, 2.5],
        ratio: 10.0,
        correction: 0.5,
        damping: 1.0,
    }];
    let text = failed.to_string();
    let table: Vec<Vec<&str>> = (text.lines().rev().take(2))
        .map(|line| line.split_whitespace().collect())
        .collect();
    assert_eq!(table[1][..3], ["iteration", "moment", "residual"]);
    assert_eq!(table[0][..3], ["0", "2.500e-1", "2.500e0"]);
}

#[test]
fn after_a_failure_the_system_is_at_the_last_equilibrium() {
    let mut system = Configured::new(bounded());
    let mut run = LoadSteps::new(&mut system, vec![], &StaticOptions::default()).unwrap();
    refused! { run.finish() => ["the spring"] }
    assert!(run.q()[0] > 0.5 && run.system().q == run.q());
    let mut system = Configured::new(bounded());
    let mut run = PathSteps::new(&mut system, vec![], &ArcLengthOptions::default()).unwrap();
    refused! { run.finish() => ["the spring"] }
    assert!(run.q()[0] > 0.5 && run.system().q == run.q());
}

/// Two coordinates, of which nothing holds the second.
struct Loose(BlockPattern);

impl System for Loose {
    fn pattern(&self) -> &BlockPattern {
        &self.0
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        // A spring between the two and none to the ground.
        let f = at.q[0] - at.q[1];
        out.r.copy_from_slice(&[at.t - f, f]);
        if let Some((_, S)) = out.S {
            S.copy_from_slice(&[1.0, -1.0, -1.0, 1.0]);
        }
        if let Some(r_t) = out.r_t {
            r_t.copy_from_slice(&[1.0, 0.0]);
        }
        Ok(())
    }

    fn name(&self, i: usize) -> String {
        ["the cart", "the trailer"][i].to_owned()
    }
}

#[test]
fn a_mechanism_is_found_and_named() {
    let mut system = Loose(BlockPattern::new(&[1, 1], [[0, 1]]));
    let failed = failed_step(equilibrium(&mut system, &StaticOptions::default()));
    let Cause::Linear { mechanism, .. } = &failed.cause else {
        panic!("{failed}");
    };
    // The rigid motion: both move alike.
    assert_eq!(mechanism.len(), 2);
    assert!((mechanism[0].1 - mechanism[1].1).abs() < 1e-6);
    let text = failed.to_string();
    for name in ["the cart", "the trailer"] {
        assert!(text.contains(name), "{text}");
    }
}

#[test]
fn a_tangent_that_is_no_number_is_named() {
    let mut spring = Scalar::new(1.0, |w| [w, f64::NAN]);
    let error = equilibrium(&mut spring, &StaticOptions::default()).unwrap_err();
    let said = format!("{} gives a value that is not finite", spring.name(0));
    assert!(error.to_string().contains(&said), "{error}");
}

#[test]
fn senseless_options_are_refused_by_name() {
    let solved = |options: StaticOptions| equilibrium(&mut truss(), &options);
    let traced = |options| PathSteps::new(&mut truss(), vec![], &options).map(drop);
    let (steps, path) = (StaticOptions::default, ArcLengthOptions::default);
    refused! {
        solved(StaticOptions { first_step: f64::NAN, ..steps() }) => ["option first_step = NaN"],
        solved(StaticOptions { max_step: 0.0, ..steps() }) => ["option max_step = 0.0"],
        solved(StaticOptions { to: f64::INFINITY, ..steps() }) => ["option to = inf"],
        traced(ArcLengthOptions { first_step: -1.0, ..path() }) => ["option first_step = -1.0"],
        traced(ArcLengthOptions { target_iterations: 0, ..path() }) =>
            ["option target_iterations = 0.0"],
    }
}
