//! What checkpoints cost, and which of them are refused.

use super::resume::{MODEL, go_on, until_step};
use crate::support::beams::{COLUMN, line};
use crate::support::closures::fixed;
use crate::support::*;
use pullback::run::{RunError, resume, run};
use std::fs::OpenOptions;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The refusal to resume a model.
fn refusal(model: &Path) -> String {
    resume(model, None, &mut go_on).unwrap_err().to_string()
}

/// A model in a new directory of a name, stopped at a step; its file and its results.
fn stopped(name: &str, text: &str, step: usize) -> (PathBuf, PathBuf) {
    let model = write(&directory(name), text);
    run(&model, None, &mut until_step(step)).unwrap();
    let out = model.with_extension("out");
    (model, out)
}

#[test]
fn what_cannot_be_resumed_is_refused_by_name() {
    let directory = directory("program_not_resumed");
    let model = write(&directory, &MODEL);
    let refused = |words: &str| {
        let said = ended(&program_in(&directory, "run --resume model.toml"), 2);
        assert_says(&said, &[words]);
    };
    refused("checkpoint.json");
    run(&model, None, &mut until_step(20)).unwrap();
    let before = read(directory.join("model.out/history.csv"));
    for (changes, words) in [
        ("mass = 0.5 => mass = 0.6", "`bodies` has changed"),
        (
            "step = 0.01 => &\\nscheme = { hht = -0.1 }",
            "`analysis.dynamic.scheme` has changed",
        ),
    ] {
        write(&directory, &changed(&MODEL, changes));
        refused(words);
    }
    write(&directory, crate::support::MODEL);
    refused("only a dynamic analysis can be resumed");
    write(&directory, &MODEL);
    std::fs::write(directory.join("model.out/checkpoint.json"), "{\"rows\": 3}").unwrap();
    refused("is not a checkpoint");
    // A refusal touches nothing.
    assert_eq!(read(directory.join("model.out/history.csv")), before);
}

#[test]
fn another_start_is_refused() {
    let rest = "[sections.main.mass]\nA_rho = 1\nJ = [2, 1, 1]\n".to_owned() + &fixed("A");
    let text = line(COLUMN, 2, 1, &(rest + &motion(0.2, 0.01)));
    let (model, _) = stopped("program_from_equilibrium", &text, 10);
    let other = changed(&text, "step = 0.01 => &\\nfrom_equilibrium = true");
    std::fs::write(&model, other).unwrap();
    let words = "`analysis.dynamic.from_equilibrium` has changed";
    assert_says(&refusal(&model), &[words]);
}

#[test]
fn another_order_of_nodes_is_another_order_of_unknowns() {
    let rest = "[sections.main.mass]\nA_rho = 1\nJ = [2, 1, 1]\n\
                [[loads]]\nnode = \"B\"\nforce = [1, 0, 2]\n";
    let text = line(COLUMN, 2, 1, &[rest, &motion(0.2, 0.01)].concat());
    let (model, _) = stopped("program_reordered", &text, 10);
    let swap = "A = [0, 0, 0]\\n => \nB = [1, 0, 0]\\n => &A = [0, 0, 0]\\n";
    std::fs::write(&model, changed(&text, swap)).unwrap();
    assert_says(&refusal(&model), &["the order of nodes"]);
}

#[test]
fn a_checkpoint_of_another_version_or_with_another_log_is_refused() {
    let (model, out) = stopped("program_tampered", &MODEL, 20);
    let path = out.join("checkpoint.json");
    let whole = read(&path);
    let mut other = json(&path);
    other["program"] = "pullback 0.0.9".into();
    std::fs::write(&path, other.to_string()).unwrap();
    assert_says(&refusal(&model), &["another version", "checkpoint.json"]);
    std::fs::write(&path, whole).unwrap();
    let path = out.join("checkpoint.log");
    let whole = read(&path);
    for (edited, what) in [
        (whole[..whole.len() - 3].to_owned(), "ends before"),
        (whole.replacen("{\"step\":", "{\"stop\":", 1), "checksum"),
    ] {
        std::fs::write(&path, edited).unwrap();
        assert_says(&refusal(&model), &[what]);
    }
    std::fs::remove_file(&path).unwrap();
    assert_says(&refusal(&model), &["cannot read", "checkpoint.log"]);
}

#[test]
fn a_checkpoint_with_a_single_damaged_byte_is_refused() {
    let (model, out) = stopped("program_damaged", &MODEL, 20);
    for name in ["checkpoint.json", "checkpoint.log"] {
        let path = out.join(name);
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
            let refused = matches!(resumed, Err(RunError::Resume(_)));
            assert!(refused, "{name}, damage {k}: {resumed:?}");
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
    let model = write(&directory, &MODEL);
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
    assert_says(&refusal(&model), &["checkpoint.log: it is a link"]);

    std::fs::remove_dir_all(&out).unwrap();
    std::fs::create_dir(&out).unwrap();
    let made = Command::new("mkfifo").arg(&log).status();
    assert!(made.unwrap().success());
    // Nobody who writes into the pipe waits for a reader.
    let mut both = OpenOptions::new();
    let both = both.read(true).write(true).open(&log);
    run(&model, None, &mut until_step(3)).unwrap();
    drop(both);
    assert!(std::fs::symlink_metadata(&log).unwrap().is_file());
}

#[test]
fn a_checkpoint_costs_the_same_however_many_rows_there_are() {
    let often = "checkpoint_every = 7 => checkpoint_every = 1\nrecord_every = 2 => record_every = 1\n\
                 step = 0.01 => step = 0.00125";
    let model = write(
        &directory("program_checkpoint_cost"),
        &changed(&MODEL, often),
    );
    let out = model.with_extension("out");
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
