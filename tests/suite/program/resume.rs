//! A motion that was stopped goes on from its checkpoint to the very same bits.
#![allow(clippy::unwrap_used)]

use crate::support::program::{directory, ended, files, program, read, results, write};
use pullback::output::{Ending, ResumeError};
use pullback::run::{RunError, resume, run};
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::Path;

/// Two flexible links on a driven hub that makes more than a turn, with a ball joint between them
/// and a hand on a spring: changes of chart, a kink, joints, damping.
const MODEL: &str = r#"
[sections.link]
stiffness = { EA = 1e5, GA = [1e5, 1e5], GJ = 1e3, EI = [1e3, 1e3] }
mass = { A_rho = 1, J = [2, 1, 1] }
damping = { stiffness = 1e-4 }

[nodes]
hub = [0, 0, 0]
middle = [1, 0, 0]
tip = [2, 0, 0]

[[lines]]
name = "first"
from = "hub"
to = "middle"
elements = 2
section = "link"

[[joints]]
name = "ball"
type = "spherical"
parent = "middle"

[[lines]]
name = "second"
from = "ball"
to = "tip"
elements = 2
section = "link"

[[joints]]
name = "pin"
type = "revolute"
parent = "tip"
axis = [0, 1, 0]
spring = { k = 3.0, c = 0.1 }

[[bodies]]
name = "hand"
node = "pin"
mass = 0.5
inertia = [0.1, 0.2, 0.3]
center = [0.1, 0, 0]

[[supports]]
node = "hub"
fix = ["x", "y", "z", "rx", "ry"]
prescribed = { rz = { table = [[0, 0], [0.4, 8], [2, 20]] } }

[[loads]]
gravity = [0, 0, -9.81]

[analysis.dynamic]
to = 1.0
step = 0.01
checkpoint_every = 7
record_every = 2

[output]
paraview_every = 5

[[probes]]
name = "turn"
node = "tip"
quantity = "rotation"

[[probes]]
name = "hold"
node = "ball"
quantity = "joint_force"

[[probes]]
name = "push"
node = "hub"
quantity = "reaction_force"
"#;

/// The results of a run, without the time that it took.
fn timeless(out: &Path) -> Value {
    let mut results = results(out);
    results["statistics"]["seconds"] = Value::Null;
    results["model"] = Value::Null;
    results["files"] = Value::Null;
    results
}

fn assert_same(one: &Path, other: &Path) {
    assert_eq!(files(one), files(other));
    for name in files(one) {
        if ["result.json", "checkpoint.json"].contains(&name.as_str()) {
            continue;
        }
        assert!(
            read(one.join(&name)) == read(other.join(&name)),
            "{name} differs"
        );
    }
    assert_eq!(timeless(one), timeless(other));
}

fn go_on(_: &pullback::solve::Advance<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn a_resumed_run_gives_the_same_bits() {
    for scheme in ["ga:0.9", "ul-ga:0.9", "lie-ga:0.9", "spin-newmark"] {
        let text = MODEL.replace("to = 1.0", &format!("to = 1.0\nscheme = \"{scheme}\""));
        resumed(&scheme.replace(':', "_"), &text, [3, 14, 55], 6);
    }
}

#[test]
fn a_resumed_loop_gives_the_same_bits() {
    let loops = include_str!("../../../examples/models/four_bar.toml");
    // The rocker's angle is independent at first, and not any more at the last interruption.
    let text = loops
        .replace("to = 4", "to = 2.4\ncheckpoint_every = 50")
        .replace("rate = 4.5\n", "")
        .replace(
            "name = \"D\"\n",
            "name = \"D\"\nrate = 4.0\nspring = { k = 0.5 }\n",
        );
    resumed("map", &text, [3, 120, 610], 1);
    let child = "child = \"rocker tip\"";
    let text = loops
        .replace(child, &format!("{child}\nclosure = \"multipliers\""))
        .replace("newmark = [0.25, 0.5]", "generalised-alpha = 0.8")
        .replace("to = 4", "to = 0.2\ncheckpoint_every = 50");
    resumed("multipliers", &text, [3, 55, 110], 0);
}

fn resumed(name: &str, text: &str, stops: [usize; 3], least_changes: u64) {
    let directory = directory(&format!("program_resume_{name}"));
    let model = write(&directory, text);
    let whole = directory.join("whole");
    run(&model, Some(&whole), &mut go_on).unwrap();
    let statistics = &results(&whole)["statistics"];
    assert!(
        statistics["chart_changes"].as_u64().unwrap() >= least_changes,
        "{statistics}"
    );

    // Stopped three times, between rows, between checkpoints and in the middle of a turn.
    let parts = directory.join("parts");
    let mut stops = stops.into_iter();
    let mut stop = stops.next().unwrap();
    let outcome = run(&model, Some(&parts), &mut until_step(stop)).unwrap();
    assert!(matches!(outcome.ending, Ending::Interrupted { .. }));
    assert_eq!(results(&parts)["complete"], false);
    for next in stops {
        stop = next;
        resume(&model, Some(&parts), &mut until_step(stop)).unwrap();
    }
    let outcome = resume(&model, Some(&parts), &mut go_on).unwrap();
    assert_eq!(outcome.ending, Ending::Complete);
    assert_same(&whole, &parts);
}

#[test]
fn a_killed_run_goes_on_from_its_last_checkpoint() {
    let directory = directory("program_killed");
    let model = write(&directory, MODEL);
    let whole = directory.join("whole");
    run(&model, Some(&whole), &mut go_on).unwrap();
    // A copy of the directory as it was after step 40 is what a killed program leaves behind: its
    // last checkpoint is that of step 35.
    let (parts, killed) = (directory.join("parts"), directory.join("killed"));
    run(&model, Some(&parts), &mut |step| {
        if step.number == 40 {
            std::fs::create_dir_all(&killed).unwrap();
            for name in files(&parts) {
                std::fs::copy(parts.join(&name), killed.join(&name)).unwrap();
            }
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    // And it was killed while it wrote the rows of the next one.
    let log = killed.join("checkpoint.log");
    let more = read(&log) + "[{\"step\":36,\"event\":nu";
    std::fs::write(&log, more).unwrap();
    let mut first = None;
    resume(&model, Some(&killed), &mut |step| {
        first.get_or_insert(step.number);
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(first, Some(36));
    assert_same(&whole, &killed);
}

#[test]
fn a_finished_run_can_be_made_longer() {
    let directory = directory("program_longer");
    let short = MODEL.replace("to = 1.0", "to = 0.5");
    let model = write(&directory, &short);
    run(&model, None, &mut go_on).unwrap();
    write(&directory, MODEL);
    let outcome = resume(&model, None, &mut go_on).unwrap();
    assert_eq!(outcome.t, 1.0);
    let error = resume(&model, None, &mut go_on).unwrap_err();
    assert!(matches!(
        error,
        RunError::Resume(ResumeError::Passed { .. })
    ));
}

#[test]
fn a_run_that_was_killed_before_its_results_were_written_gets_them() {
    let out = directory("resume-results");
    // The last of 51 rows has a ParaView file only because it is the last.
    let model = write(
        &out,
        &MODEL.replace("paraview_every = 5", "paraview_every = 7"),
    );
    let [whole, killed] = ["whole", "killed"].map(|name| out.join(name));
    for directory in [&whole, &killed] {
        assert!(run(&model, Some(directory), &mut go_on).is_ok());
    }
    let again = resume(&model, Some(&killed), &mut go_on);
    assert!(matches!(
        again,
        Err(RunError::Resume(ResumeError::Passed { .. }))
    ));
    std::fs::remove_file(killed.join("history.csv")).unwrap();
    let text = read(killed.join("result.json"));
    let running = text.replace("\"complete\": true", "\"complete\": false");
    assert_ne!(running, text);
    std::fs::write(killed.join("result.json"), running).unwrap();
    let again = resume(&model, Some(&killed), &mut go_on).unwrap();
    assert_eq!(again.ending, Ending::Complete);
    assert_same(&whole, &killed);
}

#[test]
fn what_cannot_be_resumed_is_refused_by_name() {
    let directory = directory("program_not_resumed");
    let model = write(&directory, MODEL);
    let refusal = || {
        let output = program(&[Path::new("--resume"), &model]);
        ended(&output, 2)
    };
    assert!(refusal().contains("checkpoint.json"), "{}", refusal());
    run(&model, None, &mut |step| {
        if step.number == 20 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })
    .unwrap();
    let before = read(directory.join("model.out/history.csv"));
    write(&directory, &MODEL.replace("mass = 0.5", "mass = 0.6"));
    assert!(refusal().contains("`bodies` has changed"), "{}", refusal());
    let scheme = "step = 0.01\nscheme = { hht = -0.1 }";
    write(&directory, &MODEL.replace("step = 0.01", scheme));
    assert!(refusal().contains("`analysis.dynamic.scheme` has changed"));
    write(&directory, crate::support::program::MODEL);
    assert!(refusal().contains("only a dynamic analysis can be resumed"));
    write(&directory, MODEL);
    std::fs::write(directory.join("model.out/checkpoint.json"), "{\"rows\": 3}").unwrap();
    assert!(refusal().contains("is no checkpoint"), "{}", refusal());
    // A refusal touches nothing.
    assert_eq!(read(directory.join("model.out/history.csv")), before);
}

#[test]
fn a_run_that_ended_at_a_jump_goes_on_behind_it() {
    let directory = directory("program_at_a_jump");
    let text = |to: f64, step: f64| {
        format!(
            "[nodes]\na = [0, 0, 0]\n\n[[bodies]]\nname = \"b\"\nnode = \"a\"\nmass = 1\n\n[[loads]]\n\
             node = \"a\"\nforce = [1, 0, 0]\ntime = {{ pulse = {{ end = 0.3 }} }}\n\n[[loads]]\nnode = \
             \"a\"\nforce = [1, 0, 0]\ntime = {{ pulse = {{ start = 0.30000000000000004, end = 1 }} }}\n\n\
             [analysis.dynamic]\nto = {to}\nstep = {step}\nscheme = {{ newmark = [0.25, 0.5] }}\n"
        )
    };
    for step in [0.1, 0.5] {
        let model = write(&directory, &text(1.0, step));
        let outcome = run(&model, None, &mut go_on).unwrap();
        // The work of a constant force over one unit of length; nothing else.
        let energy = outcome.counts.energy.unwrap();
        assert!(
            (energy.work - 0.5).abs() < 1e-12 && energy.largest_defect < 1e-12,
            "{energy:?}"
        );
        let speed = |out: &Path| {
            results(out)["last"]["nodes"]["a"]["velocity"][0]
                .as_f64()
                .unwrap()
        };
        assert!((speed(&outcome.directory) - 1.0).abs() < 1e-12);
        write(&directory, &text(2.0, step));
        let outcome = resume(&model, None, &mut go_on).unwrap();
        assert!((speed(&outcome.directory) - 1.0).abs() < 1e-12);
        assert_eq!(outcome.t, 2.0);
    }
}

#[test]
fn a_checkpoint_that_was_tampered_with_is_refused() {
    let directory = directory("program_tampered");
    let model = write(&directory, MODEL);
    run(&model, None, &mut until_step(20)).unwrap();
    let path = directory.join("model.out/checkpoint.json");
    let whole = read(&path);
    let edits: [(&str, Edit); 5] = [
        ("checksum", |c| {
            c["progress"]["state"]["a"].as_array_mut().unwrap().pop();
        }),
        ("checksum", |c| c["log"]["rows"] = 5.into()),
        ("checksum", |c| c["log"]["bytes"] = 0.into()),
        ("another version", |c| {
            c["program"] = "pullback 0.0.9".into()
        }),
        ("checksum", |c| c["progress"]["state"]["t"] = (-5.0).into()),
    ];
    for (what, edit) in edits {
        let mut edited: Value = serde_json::from_str(&whole).unwrap();
        edit(&mut edited);
        std::fs::write(&path, edited.to_string()).unwrap();
        let error = resume(&model, None, &mut go_on).unwrap_err().to_string();
        assert!(
            error.contains(what) && error.contains("checkpoint.json"),
            "{error}"
        );
    }
    std::fs::write(&path, whole).unwrap();
    let path = directory.join("model.out/checkpoint.log");
    let whole = read(&path);
    let edits = [
        (whole[..whole.len() - 3].to_owned(), "ends before"),
        (whole.replacen("{\"step\":", "{\"stop\":", 1), "checksum"),
    ];
    for (edited, what) in edits {
        std::fs::write(&path, edited).unwrap();
        let error = resume(&model, None, &mut go_on).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    std::fs::remove_file(&path).unwrap();
    let error = resume(&model, None, &mut go_on).unwrap_err().to_string();
    assert!(error.contains("cannot read"), "{error}");
    assert!(error.contains("checkpoint.log"), "{error}");
}

#[test]
fn a_checkpoint_with_a_single_damaged_byte_is_refused() {
    let directory = directory("program_damaged");
    let model = write(&directory, MODEL);
    run(&model, None, &mut until_step(20)).unwrap();
    for name in ["checkpoint.json", "checkpoint.log"] {
        let path = directory.join("model.out").join(name);
        let whole = std::fs::read(&path).unwrap();
        for k in 0..125 {
            let mut damaged = whole.clone();
            let byte = &mut damaged[k * whole.len() / 125];
            // Another digit is as good JSON as the one before.
            *byte = match *byte {
                digit @ b'0'..=b'9' => b'0' + (digit - b'0' + 1) % 10,
                other => other ^ 1,
            };
            std::fs::write(&path, damaged).unwrap();
            let resumed = resume(&model, None, &mut go_on);
            assert!(
                matches!(resumed, Err(RunError::Resume(_))),
                "{name}, damage {k}: {resumed:?}"
            );
        }
        std::fs::write(&path, whole).unwrap();
    }
    // Undamaged again it is taken.
    assert!(resume(&model, None, &mut go_on).is_ok());
}

#[test]
fn a_checkpoint_costs_the_same_however_many_rows_there_are() {
    let directory = directory("program_checkpoint_cost");
    let text = MODEL
        .replace("checkpoint_every = 7", "checkpoint_every = 1")
        .replace("record_every = 2", "record_every = 1")
        .replace("step = 0.01", "step = 0.00125");
    let model = write(&directory, &text);
    let out = directory.join("model.out");
    let size = |name: &str| std::fs::metadata(out.join(name)).unwrap().len();
    let mut seen = Vec::new();
    let mut log = String::new();
    run(&model, None, &mut |step| {
        // Shapes are thinned out from 129 to 65 after 128, 256 and 512 rows: equally many of them.
        if [200, 400, 800].contains(&step.number) {
            seen.push((size("checkpoint.json"), size("checkpoint.log")));
        }
        let now = read(out.join("checkpoint.log"));
        assert!(now.starts_with(&log), "rewritten in step {}", step.number);
        assert_eq!(now.lines().count(), step.number + 1);
        log = now;
        ControlFlow::Continue(())
    })
    .unwrap();
    let [(first, few), .., (last, many)] = seen[..] else {
        panic!("{seen:?}");
    };
    assert!(many > 3 * few, "{seen:?}");
    // But for the digits of numbers.
    assert!(last.abs_diff(first) * 20 < first, "{seen:?}");
}

#[test]
fn another_order_of_nodes_is_another_order_of_unknowns() {
    let directory = directory("program_reordered");
    let text = r#"
[sections.s]
circle = { radius = 0.01 }
material = { E = 1e8, nu = 0.3, rho = 2000 }

[nodes]
a = [0, 0, 0]
b = [1, 0, 0]

[[lines]]
name = "l"
from = "a"
to = "b"
elements = 2
section = "s"

[[loads]]
node = "b"
force = [1, 0, 2]

[analysis.dynamic]
to = 0.2
step = 0.01
"#;
    let model = write(&directory, text);
    run(&model, None, &mut until_step(10)).unwrap();
    let swapped = text.replace(
        "a = [0, 0, 0]\nb = [1, 0, 0]",
        "b = [1, 0, 0]\na = [0, 0, 0]",
    );
    assert_ne!(swapped, text);
    write(&directory, &swapped);
    let error = resume(&model, None, &mut go_on).unwrap_err().to_string();
    assert!(error.contains("the order of nodes"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_log_that_is_a_link_or_a_pipe_is_not_followed() {
    let directory = directory("program_links");
    let model = write(&directory, MODEL);
    let out = directory.join("model.out");
    let log = out.join("checkpoint.log");
    std::fs::create_dir(&out).unwrap();
    let other = directory.join("other");
    std::fs::write(&other, "mine").unwrap();
    std::os::unix::fs::symlink(&other, &log).unwrap();
    run(&model, None, &mut until_step(3)).unwrap();
    assert_eq!(read(&other), "mine");
    assert!(std::fs::symlink_metadata(&log).unwrap().is_file());

    // What is read is not followed either.
    std::fs::rename(&log, &other).unwrap();
    std::os::unix::fs::symlink(&other, &log).unwrap();
    let error = resume(&model, None, &mut go_on).unwrap_err().to_string();
    assert!(error.contains("checkpoint.log: it is a link"), "{error}");

    std::fs::remove_dir_all(&out).unwrap();
    std::fs::create_dir(&out).unwrap();
    let made = std::process::Command::new("mkfifo").arg(&log).status();
    assert!(made.unwrap().success());
    // Nobody who writes into the pipe waits for a reader.
    let both = std::fs::OpenOptions::new()
        .read(true)
        .write(true)
        .open(&log);
    run(&model, None, &mut until_step(3)).unwrap();
    drop(both);
    assert!(std::fs::symlink_metadata(&log).unwrap().is_file());
}

/// A change of a checkpoint.
type Edit = fn(&mut Value);

fn until_step(stop: usize) -> impl FnMut(&pullback::solve::Advance<'_>) -> ControlFlow<()> {
    move |step| match step.number >= stop {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}
