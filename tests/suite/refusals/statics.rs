//! What a static analysis that fails tells its user.
#![allow(clippy::unwrap_used)]

use crate::support::program::{MODEL, check, directory, ended, program, refusal, with, write};

/// What the program says of a run that fails.
fn failure(name: &str, text: &str) -> String {
    let directory = directory(name);
    let model = write(&directory, text);
    let output = program(&[&model]);
    ended(&output, 1)
}

#[track_caller]
fn has(said: &str, parts: &[&str]) {
    for part in parts {
        assert!(said.contains(part), "{part:?} is not in\n{said}");
    }
}

#[test]
fn a_load_far_too_large_names_the_element_and_what_ended_the_halving() {
    let text = with("moment = [0, 0, 3.141592653589793]", "force = [0, 3e5, 0]");
    let text = text.replace("steps = 4", "first_step = 1\nmax_step = 1\nmin_step = 0.2");
    let said = failure("messages_large", &text);
    has(
        &said,
        &[
            "step 1 failed between load parameter 0 (start) and",
            "half of this step is below min_step = 0.2",
            "kept in ",
            ": 1 row up to load parameter 0, marked incomplete",
        ],
    );
    assert!(!said.contains("margin"), "{said}");
}

#[test]
fn iterations_that_were_converging_are_asked_for() {
    let text = with(
        "steps = 4",
        "first_step = 0.25\nmax_step = 0.25\nmin_step = 0.2\nnewton = { max_iterations = 2, \
         relative = 1e-15 }",
    );
    let said = failure("messages_iterations", &text);
    has(
        &said,
        &["did not converge in 2 iterations", "raise max_iterations"],
    );
}

#[test]
fn a_mechanism_is_told_at_once_and_first() {
    // Two bars in line between hinges, and a hinge where they meet.
    let hinge = r#"
[[joints]]
name = "hinge"
type = "revolute"
parent = "B"
axis = [0, 0, 1]
[[bodies]]
name = "flag"
node = "hinge"
mass = 1
center = [1, 0, 0]
"#;
    let load = "node = \"hinge\"\nforce = [0, 1, 0]";
    let text = with("node = \"B\"\nmoment = [0, 0, 3.141592653589793]", load) + hinge;
    let said = failure("messages_mechanism", &text);
    has(
        &said,
        &[
            "what moves without resistance:\n",
            "hinge angle",
            "hold it by a support, a spring",
        ],
    );
    let position = said.find("what moves").unwrap();
    assert!(said.find("pivot").is_none_or(|p| p > position), "{said}");
    // Halving is of no use, and is not tried.
    assert!(!said.contains("rejected attempts"), "{said}");
}

#[test]
fn a_load_that_jumps_is_told_of_and_small_numbers_are_readable() {
    // A strut that is pushed through by a load that comes at once, in nanoseconds of t.
    let pulse = "force = [0, 3e5, 0]\ntime = { pulse = { start = 2.5e-9, end = 1 } }";
    let strut = with("moment = [0, 0, 3.141592653589793]", pulse).replace("steps = 4", "to = 4e-9");
    let said = failure("messages_jump", &strut);
    has(
        &said,
        &[
            "a jump or kink at 2.5e-9",
            "grow by a ramp",
            "load parameter 2.",
            "e-9 (converged)",
        ],
    );
    let constant = strut.replace("pulse = { start = 2.5e-9, end = 1 }", "constant = 1");
    let said = failure("messages_constant", &constant);
    has(
        &said,
        &[
            "under the loads that are there at the start",
            "let these loads grow with the load parameter",
        ],
    );
    assert!(!said.contains("smaller steps"), "{said}");
    assert!(!said.contains("converged)"), "{said}");
}

#[test]
fn results_go_to_a_directory_not_a_file() {
    let directory = directory("messages_out");
    let model = write(&directory, MODEL);
    let output = program(&[&model, "--out".as_ref(), &model]);
    assert_eq!(output.status.code(), Some(2));
    has(
        &String::from_utf8(output.stderr).unwrap(),
        &["model.toml: it is a file"],
    );
    let output = program(&[&write(&directory, &with("steps = 4", "steps = 1"))]);
    let said = String::from_utf8(output.stdout).unwrap();
    has(&said, &["2 rows up to load parameter 1 ", "1 step ("]);
}

#[test]
fn slips_are_explained() {
    let moment = "moment = [0, 0, 3.141592653589793]";
    let at = |time: &str| with(moment, &format!("{moment}\ntime = {time}"));
    check(
        &at("{ linear = 1 }"),
        "linear",
        "linear",
        "did you mean `proportional`?",
    );
    let error = refusal(&with("B = [1, 0, 0]", "B = [1, 0]"));
    let advice = error.problem.advice().unwrap();
    assert!(advice.contains("[X, Y, Z]"), "{advice}");
    let error = refusal(&with(moment, "force = -1"));
    let advice = error.problem.advice().unwrap();
    assert!(advice.contains("[Fx, Fy, Fz]"), "{advice}");
    let both = format!("{MODEL}\n[analysis.dynamic]\nto = 1\nstep = 0.1\n");
    let advice = refusal(&both).problem.advice().unwrap();
    assert!(
        advice.contains("static, arc_length, dynamic, modes"),
        "{advice}"
    );
    let on_line = MODEL.replace(
        "node = \"B\"\nmoment = [0, 0, 3.141592653589793]",
        "line = \"beam\"\nforce = [0, 1, 0]",
    );
    let advice = refusal(&on_line).problem.advice().unwrap();
    assert!(advice.contains("force_per_length"), "{advice}");
}

/// A linkage that a spring and its weight hold, closed by multipliers: their gaps are rounding errors from
/// the second step on, and forces are not.
#[test]
fn gaps_that_are_rounding_errors_say_nothing_of_forces() {
    let four_bar = include_str!("../../../examples/models/four_bar.toml");
    let end = four_bar.find("[[probes]]").unwrap();
    let mut text = four_bar[..end].to_owned();
    for (old, new) in [
        ("rate = 4.5", "spring = { k = 20 }"),
        (
            "child = \"rocker tip\"",
            "child = \"rocker tip\"\nclosure = \"multipliers\"",
        ),
    ] {
        assert!(text.contains(old), "{old}");
        text = text.replace(old, new);
    }
    let analysis = text.find("[analysis").unwrap();
    text = format!("{}[analysis.static]\nsteps = 4\n", &text[..analysis]);
    let directory = directory("messages_gaps");
    let output = program(&[&write(&directory, &text)]);
    let said = ended(&output, 0);
    assert!(!said.contains("rounding"), "{said}");
}
