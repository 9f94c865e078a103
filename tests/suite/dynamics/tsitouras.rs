//! The explicit pair of Tsitouras on rigid bodies whose motion is known by Jacobi's elliptic functions, its
//! cost beside the default scheme, checkpoints, and what it refuses.

use crate::support::closures::hinge;
use crate::support::dynamics::{assert_slopes, configure, motion_of};
use crate::support::prelude::*;
use crate::support::program::assert_says;
use allocation_counter::measure;
use pullback::studies::compare::Sample;
use pullback::studies::gallery::exact;

const PENDULUM: [&str; 3] = [
    include_str!("../../../examples/models/pendulum.toml"),
    "pendulum",
    "rod",
];
const FREE_BODY: [&str; 3] = [
    include_str!("../../../examples/models/free_body.toml"),
    "free_body",
    "O",
];

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

/// Errors of position, rotation, velocity, angular velocity and acceleration of the node at the end.
fn errors([_, model, node]: [&str; 3], context: &mut Context, state: &State) -> Vec<f64> {
    configure(context, state);
    let found = context.node_state(context.find(node).unwrap());
    let names = ["pivot".to_owned(), node.to_owned()];
    let mut sample = Sample::unknown(state.t, names.len());
    exact(model, &names).unwrap().fill(&mut sample);
    let known = &sample.nodes[1];
    vec![
        (found.position - known.position).norm(),
        (found.R - known.R).norm(),
        (found.velocity - known.velocity).norm(),
        (found.omega - known.omega).norm(),
        (found.acceleration - known.acceleration).norm(),
    ]
}

/// The errors and the counts of a run.
fn run(
    case: [&str; 3],
    scheme: &str,
    change: impl Fn(DynamicOptions) -> DynamicOptions,
) -> (Vec<f64>, Summary) {
    let (mut context, state, options) = assemble(case[0], scheme);
    let options = change(options);
    let mut run = Simulation::new(&mut context, state, &options).unwrap();
    run.finish().unwrap();
    let progress = run.progress().clone();
    let errors = errors(case, &mut context, &progress.state);
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
fn a_pendulum_follows_jacobis_functions_with_order_five() {
    let names = ["position", "velocity", "acceleration"];
    let found = [400, 800, 1600].map(|n| {
        let (errors, _) = run(PENDULUM, "tsitouras", equal(10.0, n));
        vec![errors[0], errors[2], errors[4]]
    });
    assert_slopes("tsitouras", &names, &found, 5.0, 0.25);
    assert!(found[2][0] < 2e-11, "{found:?}");
}

#[test]
fn a_free_body_follows_jacobis_functions_with_order_five_across_changes_of_chart() {
    // Charts change at every half turn, and after every step.
    for (scheme, changes) in [("tsitouras", 8), ("ul-tsitouras", 1600)] {
        let found = [1600, 3200].map(|n| {
            let (errors, summary) = run(FREE_BODY, scheme, equal(6.0, n));
            assert!(summary.chart_changes >= changes, "{summary:?}");
            vec![errors[1], errors[3]]
        });
        assert_slopes(scheme, &["rotation", "omega"], &found, 5.0, 0.3);
        assert!(found[1][0] < 1e-10, "{found:?}");
    }
}

#[test]
fn a_free_body_costs_a_fraction_of_the_default_scheme() {
    let to = 3.9;
    for (tolerance, most, coarse, times) in [(1e-6, 5e-4, 1e-8, 20), (1e-8, 5e-6, 1e-11, 100)] {
        let (errors, cost) = run(FREE_BODY, "tsitouras", adaptive(to, tolerance));
        let (default, plain) = run(FREE_BODY, "ga:0.9", adaptive(to, coarse));
        // Rotation and angular velocity of the explicit run are the better ones.
        assert!(errors[1] < most && errors[1] < default[1], "{errors:?}");
        assert!(errors[3] < default[3], "{errors:?} {default:?}");
        let [few, many] = [cost.evaluations, plain.evaluations];
        assert!(times * few < many, "{few} {many}");
        let energy = cost.energy.unwrap();
        assert!(energy.largest_defect < 3.0 * tolerance * energy.start);
    }
}

#[test]
fn a_run_with_changes_of_chart_goes_on_from_a_checkpoint_to_the_last_bit() {
    for scheme in ["tsitouras", "ul-tsitouras"] {
        for change in [adaptive(2.0, 1e-6), adaptive(2.0, 1e-4)] {
            let (mut context, state, options) = assemble(FREE_BODY[0], scheme);
            let options = change(options);
            let mut run = Simulation::new(&mut context, state, &options).unwrap();
            let mut saved = Vec::new();
            while run.step().unwrap().is_some() {
                saved.push(run.save());
            }
            let end = run.progress().clone();
            assert!(end.summary.chart_changes >= 3 && end.summary.energy.is_some());
            for snapshot in saved.iter().step_by(7) {
                let mut system = snapshot.system.clone();
                let progress = snapshot.progress.clone();
                let mut run = Simulation::resume(&mut system, progress, &options).unwrap();
                run.finish().unwrap();
                let mut other = run.progress().clone();
                // Found where a run begins.
                other.summary.stable_step = end.summary.stable_step;
                assert_eq!(other, end);
            }
        }
    }
}

#[test]
fn steps_allocate_nothing() {
    let count = |to: f64| {
        let (mut context, state, options) = assemble(FREE_BODY[0], "tsitouras");
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
    let massless = format!("{}\n{idle}", PENDULUM[0]);
    let held = include_str!("../../../examples/models/four_bar.toml").replace(
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
    let said = refusal(FREE_BODY[0], equal(6.0, 6));
    assert!(said.contains("step 1.0 is too large"), "{said}");
    let spins = FREE_BODY[0].replace("{ newmark = [0.25, 0.5] }", "\"lie-tsitouras\"");
    let error = assemble_text("model", &spins).err().unwrap();
    let said = format!("{error:?}");
    assert!(said.contains("schemes with one stage"), "{said}");
}
