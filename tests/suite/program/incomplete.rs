//! A run that fails or is stopped keeps what has converged, and says that it is not all.
#![allow(clippy::unwrap_used)]

use crate::support::program::{
    MODEL, directory, ended, files, history, number, program, results, with, write,
};
use pullback::output::Ending;
use pullback::run::run;
use std::ops::ControlFlow;
use std::process::Command;

#[test]
fn an_interrupted_run_keeps_its_steps_and_says_so() {
    let directory = directory("program_interrupted");
    let model = write(&directory, MODEL);
    let mut seen = 0;
    let outcome = run(&model, None, &mut |step| {
        seen = step.number;
        if step.number == 2 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })
    .unwrap();
    assert_eq!(seen, 2);
    assert_eq!(outcome.ending, Ending::Interrupted { t: 0.5 });
    let results = results(&outcome.directory);
    assert_eq!(results["complete"], false);
    assert_eq!(results["ending"]["kind"], "interrupted");
    assert_eq!(results["ending"]["t"], 0.5);
    assert_eq!(results["last"]["t"], 0.5);
    assert_eq!(history(&outcome.directory).len(), 3);
    let expected = [
        "deformed.html",
        "deformed.svg",
        "history.csv",
        "history.svg",
        "result.json",
        "step_0000.vtu",
        "step_0001.vtu",
        "step_0002.vtu",
        "steps.pvd",
    ];
    assert_eq!(files(&outcome.directory), expected);
}

#[test]
fn while_a_run_goes_on_its_results_are_marked_incomplete() {
    let directory = directory("program_running");
    let model = write(&directory, MODEL);
    let out = directory.join("here");
    run(&model, Some(&out), &mut |_| {
        let results = results(&out);
        assert_eq!(results["complete"], false);
        assert_eq!(results["ending"]["kind"], "running");
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(results(&out)["complete"], true);
}

/// One Newton iteration per step is not enough, and smaller steps are not allowed.
fn failing() -> String {
    with(
        "steps = 4",
        "first_step = 0.25\nmax_step = 0.25\nmin_step = 0.2\nnewton = { max_iterations = 1, relative = 1e-15 }",
    )
}

#[test]
fn a_failed_run_keeps_its_steps_and_prints_the_whole_error() {
    let directory = directory("program_failed");
    let model = write(&directory, &failing());
    let output = program(&[&model]);
    let said = ended(&output, 1);
    for part in [
        "step 1 failed",
        "did not converge",
        "largest moment out of balance",
        "node ",
        "iteration",
        "marked incomplete",
    ] {
        assert!(said.contains(part), "{part:?} is not in\n{said}");
    }
    let out = directory.join("model.out");
    let results = results(&out);
    assert_eq!(results["complete"], false);
    assert_eq!(results["ending"]["kind"], "failed");
    assert!(
        results["ending"]["message"]
            .as_str()
            .unwrap()
            .contains("step 1 failed")
    );
    assert_eq!(history(&out).len(), 1);
    assert!(!files(&out).iter().any(|f| f.starts_with('.')));
}

#[cfg(unix)]
#[test]
fn signals_stop_after_a_step_and_keep_it() {
    for signal in ["INT", "TERM", "HUP"] {
        stopped_by(signal);
    }
}

#[cfg(unix)]
fn stopped_by(signal: &str) {
    use std::process::Stdio;
    use std::time::{Duration, Instant};
    let directory = directory(&format!("program_signal_{signal}"));
    let long = with("steps = 4", "steps = 1000000").replace("elements = 8", "elements = 200");
    let long = long + "\n[output]\nparaview_every = 0\n";
    let model = write(&directory, &long);
    let mut child = Command::new(env!("CARGO_BIN_EXE_pullback"))
        .arg("run")
        .arg(&model)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let out = directory.join("model.out");
    let start = Instant::now();
    while !out.join("result.json").exists() && start.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(300));
    let killed = Command::new("kill")
        .args([&format!("-{signal}"), &child.id().to_string()])
        .status();
    assert!(killed.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130), "{signal}");
    let results = results(&out);
    assert_eq!(results["complete"], false);
    assert_eq!(results["ending"]["kind"], "interrupted");
    let rows = history(&out);
    assert!(rows.len() > 1);
    assert_eq!(
        results["last"]["t"].as_f64().unwrap(),
        number(rows.last().unwrap(), "t")
    );
    assert!(!files(&out).iter().any(|f| f.starts_with('.')));
}

/// The model file is a pipe that nobody writes into: the program waits for it before its first step.
#[cfg(unix)]
#[test]
fn a_signal_before_the_first_step_ends_the_program_at_once() {
    use std::time::{Duration, Instant};
    let pipe = directory("program_early_signal").join("pipe.toml");
    let made = Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let mut child = Command::new(env!("CARGO_BIN_EXE_pullback"))
        .arg("run")
        .arg(&pipe)
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(500));
    let killed = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status();
    assert!(killed.unwrap().success());
    let start = Instant::now();
    let mut ended = None;
    while ended.is_none() && start.elapsed() < Duration::from_secs(5) {
        std::thread::sleep(Duration::from_millis(20));
        ended = child.try_wait().unwrap();
    }
    child.kill().ok();
    let status = child.wait().unwrap();
    assert!(ended.is_some() && !status.success(), "{ended:?}");
}
