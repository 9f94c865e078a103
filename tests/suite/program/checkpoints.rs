//! What checkpoints cost, and which of them are refused.
#![allow(clippy::unwrap_used)]

use super::resume::{MODEL, go_on, until_step};
use crate::support::program::{directory, ended, program, read, write};
use pullback::run::{RunError, resume, run};
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::Path;

/// The refusal to resume a model.
fn refusal(model: &Path) -> String {
    resume(model, None, &mut go_on).unwrap_err().to_string()
}

#[test]
fn what_cannot_be_resumed_is_refused_by_name() {
    let directory = directory("program_not_resumed");
    let model = write(&directory, MODEL);
    let refusal = || ended(&program(&[Path::new("--resume"), &model]), 2);
    assert!(refusal().contains("checkpoint.json"), "{}", refusal());
    run(&model, None, &mut until_step(20)).unwrap();
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
    let error = refusal(&model);
    assert!(error.contains("the order of nodes"), "{error}");
}

#[test]
fn a_checkpoint_that_was_tampered_with_is_refused() {
    let directory = directory("program_tampered");
    let model = write(&directory, MODEL);
    run(&model, None, &mut until_step(20)).unwrap();
    let path = directory.join("model.out/checkpoint.json");
    let whole = read(&path);
    type Edit = fn(&mut Value);
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
        let error = refusal(&model);
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
        let error = refusal(&model);
        assert!(error.contains(what), "{error}");
    }
    std::fs::remove_file(&path).unwrap();
    let error = refusal(&model);
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
#[cfg(unix)]
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
    let error = refusal(&model);
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
