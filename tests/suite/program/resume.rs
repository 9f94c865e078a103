//! A motion that was stopped goes on from its checkpoint to the very same bits.

use crate::support::*;
use pullback::output::{Ending, ResumeError};
use pullback::run::{RunError, resume, run};
use pullback::solve::Advance;
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::LazyLock;

/// Two flexible links on a driven hub that makes more than a turn, with a ball joint between them
/// and a hand on a spring: changes of chart, a kink, joints, damping.
pub static MODEL: LazyLock<String> = LazyLock::new(|| {
    let pin = "axis = [0, 1, 0]\nspring = { k = 3.0, c = 0.1 }";
    let hand = "inertia = [0.1, 0.2, 0.3]\ncenter = [0.1, 0, 0]";
    [
        "[sections.link]\nmass = { A_rho = 1, J = [2, 1, 1] }\ndamping = { stiffness = 1e-4 }\n\
         stiffness = { EA = 1e5, GA = [1e5, 1e5], GJ = 1e3, EI = [1e3, 1e3] }\n\
         [nodes]\nhub = [0, 0, 0]\nmiddle = [1, 0, 0]\ntip = [2, 0, 0]\n",
        &beam_line("first", ["hub", "middle"], 2, "link"),
        &joint("ball", "spherical", "middle", ""),
        &beam_line("second", ["ball", "tip"], 2, "link"),
        &joint("pin", "revolute", "tip", pin),
        &body_of("pin", 0.5, hand),
        "[[supports]]\nnode = \"hub\"\nfix = [\"x\", \"y\", \"z\", \"rx\", \"ry\"]\n\
         prescribed = { rz = { table = [[0, 0], [0.4, 8], [2, 20]] } }\n",
        GRAVITY,
        "[analysis.dynamic]\nto = 1.0\nstep = 0.01\ncheckpoint_every = 7\nrecord_every = 2\n\
         [output]\nparaview_every = 5\n",
        &probe("turn", "rotation", "tip"),
        &probe("hold", "joint_force", "ball"),
        &probe("push", "reaction_force", "hub"),
    ]
    .concat()
});

/// The results of a run, without the time that it took.
fn timeless(out: &Path) -> Value {
    let mut results = results(out);
    results["statistics"]["seconds"] = Value::Null;
    results["model"] = Value::Null;
    results["files"] = Value::Null;
    results
}

fn assert_same(one: &Path, other: &Path) {
    let names = files(one);
    assert_eq!(names, files(other));
    let all = names.iter();
    for name in all.filter(|name| !["result.json", "checkpoint.json"].contains(&&name[..])) {
        let [a, b] = [one, other].map(|out| read(out.join(name)));
        assert!(a == b, "{name} differs");
    }
    assert_eq!(timeless(one), timeless(other));
}

pub fn go_on(_: &Advance<'_>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

pub fn until_step(stop: usize) -> impl FnMut(&Advance<'_>) -> ControlFlow<()> {
    move |step| match step.number >= stop {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    }
}

#[test]
fn a_resumed_run_gives_the_same_bits() {
    for scheme in ["ga:0.9", "ul-ga:0.9", "lie-ga:0.9", "spin-newmark"] {
        let text = changed(&MODEL, &format!("to = 1.0 => &\\nscheme = \"{scheme}\""));
        resumed(&scheme.replace(':', "_"), &text, [3, 14, 55], 6);
    }
}

#[test]
fn a_resumed_loop_gives_the_same_bits() {
    let four_bar = |changes: &str| changed(&example("four_bar"), changes);
    // The rocker's angle is independent at first, and not any more at the last interruption.
    let text = four_bar(
        "to = 4 => to = 2.4\\ncheckpoint_every = 50\nrate = 4.5\\n =>\n\
         name = \"D\"\\n => &rate = 4.0\\nspring = { k = 0.5 }\\n",
    );
    resumed("map", &text, [3, 120, 610], 1);
    let text = four_bar(&format!(
        "child = \"rocker tip\" => &\\n{}\nnewmark = [0.25, 0.5] => generalised-alpha = 0.8\n\
         to = 4 => to = 0.2\\ncheckpoint_every = 50",
        CLOSURES[1]
    ));
    resumed("multipliers", &text, [3, 55, 110], 0);
}

/// A beam and a ring on it behind a driven joint, which turns by more than half a turn: their charts are those of frames
/// that follow from a coordinate.
fn behind() -> String {
    let driven = "prescribed = { table = [[0, 0], [0.4, 4], [2, 4]] }";
    [
        "[sections.link]\nmass = { A_rho = 1, J = [2, 1, 1] }\n\
         stiffness = { EA = 1e5, GA = [1e5, 1e5], GJ = 1e3, EI = [1e3, 1e3] }\n\
         [nodes]\nhub = [0, 0, 0]\ntip = [1, 0, 0]\nfar = [0.25, 0, 1]\n",
        &hinge("pin", "hub", driven),
        &beam_line("first", ["pin", "tip"], 2, "link"),
        "[[joints]]\nname = \"ring\"\ntype = \"slide\"\nlines = [\"first\"]\nstart = 0.25\n\
         spring = { k = 1e4, c = 10 }\n",
        &beam_line("second", ["ring", "far"], 1, "link"),
        &fixed("hub"),
        &motion(0.6, 0.01),
    ]
    .concat()
}

#[test]
fn a_resumed_beam_behind_a_joint_gives_the_same_bits() {
    for stops in [[3, 40, 44], [42, 46, 54]] {
        resumed("behind", &behind(), stops, 2);
    }
}

#[test]
fn a_resumed_free_body_has_the_same_invariants_and_step_sizes() {
    for (scheme, changes, stops) in [
        (
            "projected-newmark",
            "to = 1\\ncheckpoint_every = 50",
            [3, 55, 110],
        ),
        (
            "tsitouras",
            "to = 2\\ncheckpoint_every = 5\\nadaptive = { tolerance = 1e-6 }",
            [3, 20, 37],
        ),
    ] {
        let changes = format!("to = 8 => {changes}\n{{ newmark = [0.25, 0.5] }} => \"{scheme}\"");
        let text = changed(&example("free_body"), &changes);
        resumed(scheme, &text, stops, 2);
    }
}

/// Stopped three times, between rows, between checkpoints and in the middle of a turn.
fn resumed(name: &str, text: &str, stops: [usize; 3], least_changes: u64) {
    let directory = directory(&format!("program_resume_{name}"));
    let model = write(&directory, text);
    let [whole, parts] = ["whole", "parts"].map(|name| directory.join(name));
    run(&model, Some(&whole), &mut go_on).unwrap();
    let statistics = &results(&whole)["statistics"];
    let changes = statistics["chart_changes"].as_u64().unwrap();
    assert!(changes >= least_changes, "{statistics}");
    let outcome = run(&model, Some(&parts), &mut until_step(stops[0])).unwrap();
    assert!(matches!(outcome.ending, Ending::Interrupted { .. }));
    assert_eq!(results(&parts)["complete"], false);
    for stop in &stops[1..] {
        resume(&model, Some(&parts), &mut until_step(*stop)).unwrap();
    }
    let outcome = resume(&model, Some(&parts), &mut go_on).unwrap();
    assert_eq!(outcome.ending, Ending::Complete);
    assert_same(&whole, &parts);
}

#[test]
fn a_killed_run_goes_on_from_its_last_checkpoint() {
    let directory = directory("program_killed");
    let model = write(&directory, &MODEL);
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
fn a_run_that_was_killed_before_its_results_were_written_gets_them() {
    let out = directory("resume-results");
    // The last of 51 rows has a ParaView file only because it is the last.
    let rare = changed(&MODEL, "paraview_every = 5 => paraview_every = 7");
    let model = write(&out, &rare);
    let [whole, killed] = ["whole", "killed"].map(|name| out.join(name));
    for directory in [&whole, &killed] {
        assert!(run(&model, Some(directory), &mut go_on).is_ok());
    }
    // There is nothing left to do.
    let again = resume(&model, Some(&killed), &mut go_on);
    let passed = matches!(again, Err(RunError::Resume(ResumeError::Passed { .. })));
    assert!(passed, "{again:?}");
    std::fs::remove_file(killed.join("history.csv")).unwrap();
    let text = read(killed.join("result.json"));
    let running = changed(&text, "\"complete\": true => \"complete\": false");
    std::fs::write(killed.join("result.json"), running).unwrap();
    let again = resume(&model, Some(&killed), &mut go_on).unwrap();
    assert_eq!(again.ending, Ending::Complete);
    assert_same(&whole, &killed);
}

#[test]
fn a_run_that_ended_at_a_kink_of_a_drive_goes_on_to_the_same_bits() {
    let directory = directory("program_at_a_kink");
    let [whole, parts] = ["whole", "parts"].map(|name| directory.join(name));
    let model = write(&directory, &changed(&MODEL, "to = 1.0 => to = 0.4"));
    run(&model, Some(&parts), &mut go_on).unwrap();
    let model = write(&directory, &MODEL);
    resume(&model, Some(&parts), &mut go_on).unwrap();
    run(&model, Some(&whole), &mut go_on).unwrap();
    assert_same(&whole, &parts);
}

#[test]
fn a_run_whose_motion_stiffens_goes_on_with_the_step_that_was_stable_at_its_start() {
    let spring = "axis = [1, 0, 0]\nspring = { k = 1, k3 = 100 }\nrate = 7";
    let text = [
        GROUND,
        &joint("slide", "prismatic", "ground", spring),
        &body_of("slide", 1.0, ""),
        &motion(0.6, 0.04),
        "scheme = \"tsitouras\"\n",
    ]
    .concat();
    resumed("stiffening", &text, [3, 6, 9], 0);
}

#[test]
fn a_run_that_ended_at_a_jump_goes_on_behind_it() {
    let directory = directory("program_at_a_jump");
    let text = |to: f64, step: f64| {
        let pulse = |time: &str| {
            format!(
                "[[loads]]\nnode = \"a\"\nforce = [1, 0, 0]\ntime = {{ pulse = {{ {time} }} }}\n"
            )
        };
        [
            "[nodes]\na = [0, 0, 0]\n",
            &body_of("a", 1.0, ""),
            &pulse("end = 0.3"),
            &pulse("start = 0.30000000000000004, end = 1"),
            &motion(to, step),
            "scheme = { newmark = [0.25, 0.5] }\n",
            &probe("a", "acceleration", "a"),
        ]
        .concat()
    };
    for step in [0.1, 0.5] {
        let model = write(&directory, &text(1.0, step));
        let outcome = run(&model, None, &mut go_on).unwrap();
        // The work of a constant force over one unit of length; nothing else.
        let energy = outcome.counts.energy.unwrap();
        assert_close(energy.work, 0.5, 1e-12, step);
        assert!(energy.largest_defect < 1e-12, "{energy:?}");
        // Behind the jump, nothing acts.
        let assert_speed = |out: &Path| {
            let speed = &results(out)["last"]["nodes"]["a"]["velocity"][0];
            assert_close(speed.as_f64().unwrap(), 1.0, 1e-12, step);
            assert_eq!(number(history(out).last().unwrap(), "a.x"), 0.0);
        };
        assert_speed(&outcome.directory);
        write(&directory, &text(2.0, step));
        let outcome = resume(&model, None, &mut go_on).unwrap();
        assert_speed(&outcome.directory);
        assert_eq!(outcome.t, 2.0);
    }
}
