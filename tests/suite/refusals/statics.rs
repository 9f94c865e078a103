//! What a static analysis that fails tells its user.

use crate::support::*;

#[test]
fn a_load_far_too_large_names_the_element_and_what_ended_the_halving() {
    let text = with("moment = [0, 0, 3.141592653589793]", "force = [0, 3e5, 0]");
    let text = text.replace("steps = 4", "first_step = 1\nmax_step = 1\nmin_step = 0.2");
    let said = failed("messages_large", &text);
    let words = [
        "step 1 failed between load parameter 0 (start) and",
        "half of this step is below min_step = 0.2",
        "kept in ",
        ": 1 row up to load parameter 0, marked incomplete",
    ];
    assert_says(&said, &words);
    assert!(!said.contains("margin"), "{said}");
}

#[test]
fn a_mechanism_is_told_at_once_and_first() {
    // Two bars in line between hinges, and a hinge where they meet.
    let hinge = hinge("hinge", "B", "") + &body_of("hinge", 1.0, "center = [1, 0, 0]");
    let load = "node = \"hinge\"\nforce = [0, 1, 0]";
    let text = with("node = \"B\"\nmoment = [0, 0, 3.141592653589793]", load) + "\n" + &hinge;
    let said = failed("messages_mechanism", &text);
    let words = [
        "what moves without resistance:\n",
        "hinge angle",
        "hold it by a support, a spring",
    ];
    assert_says(&said, &words);
    let position = said.find("what moves").unwrap();
    assert!(said.find("pivot").is_none_or(|p| p > position), "{said}");
    // Halving is of no use, and is not tried.
    assert!(!said.contains("rejected attempts"), "{said}");
}

#[test]
fn what_supports_do_not_hold_is_told() {
    for [fix, motion] in cells(
        r#"
"position" | (rotation about the direction
["y", "z", "rx", "ry", "rz"] | (translation along (1.000, 0.000, 0.000))
"#,
    ) {
        let text = with("moment = [0, 0, 3.141592653589793]", "force = [1, 0, 0]");
        let said = failed("messages_unsupported", &text.replace("\"all\"", fix));
        assert_says(&said, &["that contains node A", motion]);
        assert_says(&said, &["what moves without resistance"]);
    }
}

#[test]
fn a_load_that_jumps_is_told_of_and_small_numbers_are_readable() {
    // A strut that is pushed through by a load that comes at once, in nanoseconds of t.
    let pulse = "force = [0, 3e5, 0]\ntime = { pulse = { start = 2.5e-9, end = 1 } }";
    let strut = with("moment = [0, 0, 3.141592653589793]", pulse).replace("steps = 4", "to = 4e-9");
    let said = failed("messages_jump", &strut);
    let words = [
        "a jump or kink at 2.5e-9",
        "grow by a ramp",
        "load parameter 2.",
        "e-9 (converged)",
    ];
    assert_says(&said, &words);
    // One that follows a strut, and is there from the start.
    let constant = strut.replace("pulse = { start = 2.5e-9, end = 1 }", "constant = 1");
    let follows = constant.replace("[0, 3e5, 0]", "[0, 16, 0]\nfollower = true");
    let said = failed("messages_constant", &follows);
    let words = ["no equilibrium is found at the start", "grow from zero"];
    assert_says(&said, &words);
    assert!(!said.contains("smaller steps"), "{said}");
    assert!(!said.contains("converged)"), "{said}");
}

#[test]
fn results_go_to_a_directory_not_a_file() {
    let directory = directory("messages_out");
    write(&directory, &with("steps = 4", "steps = 1"));
    let refused = program_in(&directory, "run model.toml --out model.toml");
    let said = ended(&refused, 2);
    assert_says(&said, &["cannot write", "model.toml: it is a file"]);
    let said = printed(&directory, "run model.toml");
    assert_says(&said, &["2 rows up to load parameter 1 ", "1 step ("]);
}

/// A linkage that a spring and its weight hold, closed by multipliers: their gaps are rounding errors from
/// the second step on, and forces are not.
#[test]
fn gaps_that_are_rounding_errors_say_nothing_of_forces() {
    let changes = format!(
        "rate = 4.5 => spring = {{ k = 20 }}\nchild = \"rocker tip\" => &\\n{}",
        CLOSURES[1]
    );
    let text = changed(&example("four_bar"), &changes);
    let (model, _) = text.split_once("[analysis").unwrap();
    let text = format!("{model}[analysis.static]\nsteps = 4\n");
    let run = run_of("messages_gaps", &text);
    assert!(!run.said.contains("rounding"), "{}", run.said);
}
