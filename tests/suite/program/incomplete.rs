//! A run that fails or is stopped keeps what has converged, and says that it is not all.

use super::resume::until_step;
use crate::support::program::*;
use pullback::output::Ending;
use pullback::run::run;
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::Path;

/// What result.json says of a run that did not end as planned, and in which way.
#[track_caller]
fn incomplete(out: &Path, kind: &str) -> Value {
    let results = results(out);
    assert_eq!(results["complete"], false);
    assert_eq!(results["ending"]["kind"], kind);
    results
}

#[test]
fn an_interrupted_run_keeps_its_steps_and_says_so() {
    let model = write(&directory("program_interrupted"), MODEL);
    let outcome = run(&model, None, &mut until_step(2)).unwrap();
    assert_eq!(outcome.ending, Ending::Interrupted { t: 0.5 });
    let results = incomplete(&outcome.directory, "interrupted");
    assert_eq!(results["ending"]["t"], 0.5);
    assert_eq!(results["last"]["t"], 0.5);
    assert_eq!(history(&outcome.directory).len(), 3);
    let expected = "deformed.html deformed.svg history.csv history.svg result.json \
                    step_0000.vtu step_0001.vtu step_0002.vtu steps.pvd";
    assert!(files(&outcome.directory).iter().eq(expected.split(' ')));
}

#[test]
fn while_a_run_goes_on_its_results_are_marked_incomplete() {
    let model = write(&directory("program_running"), MODEL);
    let out = model.with_extension("here");
    run(&model, Some(&out), &mut |_| {
        incomplete(&out, "running");
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(results(&out)["complete"], true);
}

#[test]
fn a_failed_run_keeps_its_steps_and_prints_the_whole_error() {
    // Two Newton iterations per step are not enough, and smaller steps are not allowed.
    let failing = with(
        "steps = 4",
        "first_step = 0.25\nmax_step = 0.25\nmin_step = 0.2\nnewton = { max_iterations = 2, relative = 1e-15 }",
    );
    let said = failed("program_failed", &failing);
    let words = [
        "step 1 failed",
        "did not converge in 2 iterations",
        "raise max_iterations",
        "largest moment out of balance",
        "node ",
        "marked incomplete",
    ];
    assert_says(&said, &words);
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("program_failed/model.out");
    let results = incomplete(&out, "failed");
    let message = results["ending"]["message"].as_str().unwrap();
    assert_says(message, &["step 1 failed"]);
    assert_eq!(history(&out).len(), 1);
    assert!(!files(&out).iter().any(|f| f.starts_with('.')));
}

#[cfg(unix)]
mod signals {
    use super::*;
    use crate::support::program::{number, spawned};
    use std::process::{Child, Command};
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    /// Sends a signal to a program under way.
    fn send(signal: &str, child: &Child) {
        let mut kill = Command::new("kill");
        let kill = kill.args([format!("-{signal}"), child.id().to_string()]);
        assert!(kill.status().unwrap().success());
    }

    /// Waits until something is so, for some seconds at most.
    fn wait(seconds: u64, mut until: impl FnMut() -> bool) {
        let start = Instant::now();
        while !until() && start.elapsed() < Duration::from_secs(seconds) {
            sleep(Duration::from_millis(20));
        }
    }

    #[test]
    fn signals_stop_after_a_step_and_keep_it() {
        for signal in ["INT", "TERM", "HUP"] {
            let directory = directory(&format!("program_signal_{signal}"));
            let long =
                with("steps = 4", "steps = 1000000").replace("elements = 8", "elements = 200");
            let model = write(&directory, &(long + "\n[output]\nparaview_every = 0\n"));
            let mut child = spawned(&["run"], &model);
            let out = directory.join("model.out");
            wait(30, || out.join("result.json").exists());
            sleep(Duration::from_millis(300));
            send(signal, &child);
            assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}");
            let results = incomplete(&out, "interrupted");
            let rows = history(&out);
            assert!(rows.len() > 1);
            assert_eq!(results["last"]["t"], number(rows.last().unwrap(), "t"));
            assert!(!files(&out).iter().any(|f| f.starts_with('.')));
        }
    }

    /// Three derivatives for each of 3000 coordinates take longer than the test waits.
    #[test]
    fn a_signal_stops_derivatives_of_outputs() {
        let directory = directory("program_signal_linearize");
        let model = write(&directory, &with("elements = 8", "elements = 500"));
        let mut child = spawned(&["linearize", "--first-order"], &model);
        sleep(Duration::from_secs(3));
        send("INT", &child);
        let mut ended = None;
        wait(10, || {
            ended = child.try_wait().unwrap();
            ended.is_some()
        });
        child.kill().ok();
        child.wait().unwrap();
        assert_eq!(ended.and_then(|status| status.code()), Some(130));
        assert_eq!(files(&directory), ["model.toml"]);
    }

    /// The model file is a pipe that nobody writes into: the program waits for it before its first step.
    #[test]
    fn a_signal_before_the_first_step_ends_the_program_at_once() {
        let pipe = directory("program_early_signal").join("pipe.toml");
        let made = Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let mut child = spawned(&["run"], &pipe);
        sleep(Duration::from_millis(500));
        send("TERM", &child);
        let mut ended = None;
        wait(5, || {
            ended = child.try_wait().unwrap();
            ended.is_some()
        });
        child.kill().ok();
        let status = child.wait().unwrap();
        assert!(ended.is_some() && !status.success(), "{ended:?}");
    }
}
