//! One model, several contexts: in threads, and continued from a snapshot.
#![allow(clippy::unwrap_used)]

use pullback::elements::model::{Context, Model};
use pullback::input::{self, Plan};
use pullback::integrators::dynamics::{DynamicOptions, Progress, State, integrate, start};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Mechanisms whose loops change their split, and beams that turn beyond their first chart.
const MODELS: [&str; 2] = [
    include_str!("../../../examples/models/four_bar_flexible.toml"),
    include_str!("../../../examples/models/top_beam.toml"),
];
const STEPS: usize = 60;

/// The context at the start of a model file, with its initial state and options.
fn setup(text: &str) -> (Context, Progress, DynamicOptions) {
    let file = input::parse("model.toml", text).unwrap();
    let job = input::job("model.toml", &file).unwrap();
    let Plan::Dynamic(plan) = job.plan else {
        panic!("a motion");
    };
    let first = start(&job.model, 0.0, &job.start.q, &job.start.v).unwrap();
    (job.model, Progress::new(first), plan.options)
}

/// The coordinates after some more steps.
fn steps(
    context: &mut Context,
    progress: &mut Progress,
    options: &DynamicOptions,
    count: usize,
) -> Vec<u64> {
    let mut left = count;
    integrate(context, progress, options, &mut |_, _| {
        left -= 1;
        match left {
            0 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    })
    .unwrap();
    let State { q, v, a, .. } = &progress.state;
    let all = q.iter().chain(v).chain(a);
    all.map(|x| x.to_bits()).collect()
}

#[test]
fn a_model_is_shared_between_threads() {
    fn shared<T: Clone + Send + Sync>() {}
    shared::<Model>();
    shared::<Context>();
    for text in MODELS {
        let (mut context, mut progress, options) = setup(text);
        let model = Arc::clone(context.model());
        let first = progress.clone();
        let alone = steps(&mut context, &mut progress, &options, STEPS);
        std::thread::scope(|scope| {
            let threads = [0; 2].map(|_| {
                scope.spawn(|| {
                    let mut context = Context::new(Arc::clone(&model));
                    steps(&mut context, &mut first.clone(), &options, STEPS)
                })
            });
            for thread in threads {
                assert!(thread.join().unwrap() == alone);
            }
        });
    }
}

#[test]
fn a_clone_of_the_state_is_a_snapshot() {
    for text in MODELS {
        let (mut context, mut progress, options) = setup(text);
        steps(&mut context, &mut progress, &options, STEPS);
        let (state, at) = (context.state().clone(), progress.clone());
        let once = steps(&mut context, &mut progress, &options, STEPS);
        // Back in the same context, and in a new one.
        context.set_state(state.clone());
        assert!(steps(&mut context, &mut at.clone(), &options, STEPS) == once);
        let mut other = Context::new(Arc::clone(context.model()));
        other.set_state(state);
        assert!(steps(&mut other, &mut at.clone(), &options, STEPS) == once);
    }
}
