//! The explicit pair of Tsitouras on a free body whose motion is known by Jacobi's elliptic functions, its
//! cost beside the default scheme, and what it refuses.

use crate::support::closures::hinge;
use crate::support::dynamics::{assert_slopes, configure, motion_of};
use crate::support::prelude::*;
use crate::support::program::{assert_says, example};
use allocation_counter::measure;
use pullback::studies::compare::Sample;
use pullback::studies::gallery::exact;

/// A model of the gallery with another scheme, its start, and options for nearly exact balance.
fn assemble(text: &str, scheme: &str) -> (Context, State, DynamicOptions) {
    let text = text.replace(
        "scheme = { newmark = [0.25, 0.5] }",
        &format!("scheme = \"{scheme}\""),
    );
    let (context, state, mut options) = motion_of(&text);
    options.newton.relative = 1e-12;
    (context, state, options)
}

/// Errors of rotation and angular velocity of the free body at the end of a run, and its counts.
fn run(scheme: &str, change: impl Fn(DynamicOptions) -> DynamicOptions) -> (Vec<f64>, Summary) {
    let (mut context, state, options) = assemble(&example("free_body"), scheme);
    let options = change(options);
    let mut run = Simulation::new(&mut context, state, &options).unwrap();
    run.finish().unwrap();
    let progress = run.progress().clone();
    configure(&mut context, &progress.state);
    let found = context.node_state(context.find("O").unwrap());
    let mut sample = Sample::unknown(progress.state.t, 1);
    let known = exact("free_body", &["O".to_owned()]).unwrap();
    known.fill(&mut sample);
    let known = &sample.nodes[0];
    let errors = vec![
        (found.R - known.R).norm(),
        (found.omega - known.omega).norm(),
    ];
    (errors, progress.summary)
}

fn equal(to: f64, n: u32) -> impl Fn(DynamicOptions) -> DynamicOptions {
    move |options| DynamicOptions {
        to,
        step: to / f64::from(n),
        ..options
    }
}

fn adaptive(to: f64, tolerance: f64) -> impl Fn(DynamicOptions) -> DynamicOptions {
    move |options| DynamicOptions {
        to,
        step: 0.01,
        adaptivity: Some(Adaptivity {
            tolerance,
            max_step: 1.0,
        }),
        ..options
    }
}

#[test]
fn a_free_body_follows_jacobis_functions_with_order_five_across_changes_of_chart() {
    // Charts change at every half turn, and after every step.
    for (scheme, changes) in [("tsitouras", 8), ("ul-tsitouras", 1600)] {
        let found = [1600, 3200].map(|n| {
            let (errors, summary) = run(scheme, equal(6.0, n));
            assert!(summary.chart_changes >= changes, "{summary:?}");
            errors
        });
        assert_slopes(scheme, &["rotation", "omega"], &found, 5.0, 0.3);
        assert!(found[1][0] < 1e-10, "{found:?}");
    }
}

#[test]
fn a_free_body_costs_a_fraction_of_the_default_scheme() {
    let to = 3.9;
    for (tolerance, most, coarse, times) in [(1e-6, 5e-4, 1e-8, 20), (1e-8, 5e-6, 1e-11, 100)] {
        let (errors, cost) = run("tsitouras", adaptive(to, tolerance));
        let (default, plain) = run("ga:0.9", adaptive(to, coarse));
        // Rotation and angular velocity of the explicit run are the better ones.
        assert!(errors[0] < most && errors[0] < default[0], "{errors:?}");
        assert!(errors[1] < default[1], "{errors:?} {default:?}");
        let [few, many] = [cost.evaluations, plain.evaluations];
        assert!(times * few < many, "{few} {many}");
        let energy = cost.energy.unwrap();
        assert!(energy.largest_defect < 3.0 * tolerance * energy.start);
    }
}

#[test]
fn steps_allocate_nothing() {
    let count = |to: f64| {
        let (mut context, state, options) = assemble(&example("free_body"), "tsitouras");
        let options = adaptive(to, 1e-7)(options);
        let mut summary = Summary::default();
        let counted = measure(|| {
            let mut run = Simulation::new(&mut context, state.clone(), &options).unwrap();
            run.finish().unwrap();
            summary = run.progress().summary;
        });
        (counted.count_total, summary)
    };
    // What the first run in a process sets up is not counted.
    count(0.1);
    let ((few, short), (many, long)) = (count(1.0), count(2.0));
    assert!(long.steps > short.steps + 20 && long.chart_changes > short.chart_changes);
    assert_eq!(few, many);
}

/// Why the scheme refuses a model.
fn refusal(text: &str, change: impl Fn(DynamicOptions) -> DynamicOptions) -> String {
    let (mut context, state, options) = assemble(text, "tsitouras");
    let error = Simulation::new(&mut context, state, &change(options)).err();
    error.unwrap().to_string()
}

#[test]
fn what_it_cannot_integrate_is_refused() {
    // Nothing but a spring and a damper, of the first order.
    let idle = hinge("idle", "ground", "spring = { k = 1, c = 2 }");
    let massless = example("pendulum") + &idle;
    let held = example("four_bar").replace(
        "child = \"rocker tip\"",
        "child = \"rocker tip\"\nclosure = \"multipliers\"",
    );
    for adapt in [false, true] {
        let change = |options| match adapt {
            true => adaptive(1.0, 1e-6)(options),
            false => options,
        };
        let words = ["needs mass in every coordinate", "idle"];
        assert_says(&refusal(&massless, change), &words);
        let words = ["scheme Tsitouras 5(4)", "multipliers"];
        assert_says(&refusal(&held, change), &words);
    }
    let said = refusal(&example("free_body"), equal(6.0, 6));
    assert!(said.contains("step 1.0 is too large"), "{said}");
}
