//! The word `closure` in model files: three methods for one file, what the program says and refuses.

use crate::support::closures::{arm, body, fixed, hinge, probe};
use crate::support::program::*;

const CHILD: &str = "child = \"rocker tip\"";

/// The linkage with other words at its closing joint, for a damped scheme.
fn closed_by(words: &str) -> String {
    let damped = "scheme = { generalised-alpha = 0.8 }";
    example("four_bar")
        .replace(CHILD, &format!("{CHILD}\n{words}"))
        .replace("scheme = { newmark = [0.25, 0.5] }", damped)
        .replace("to = 4", "to = 0.5")
}

#[test]
fn one_file_three_methods() {
    for (words, told) in [
        ("closure = \"map\"", "joint C closes a loop"),
        (
            "closure = \"multipliers\"",
            "joint C: closed by multipliers; redundant: the gap along e3, the misalignment about e1, \
             the misalignment about e2",
        ),
        (
            "closure = \"penalty\"\npenalty = 1e8\npenalty_damping = 1e-3",
            "joint C: closed by a penalty of 1e8",
        ),
    ] {
        let ran = program(&[&write(&directory("closures-methods"), &closed_by(words))]);
        let said = succeeded(&ran) + &String::from_utf8(ran.stdout).unwrap();
        assert_says(&said, &[told]);
        // The closing joint's angle needs no mass.
        assert!(!said.contains("no mass acts"), "{said}");
    }
    let idle = hinge("C 2", "ground", "spring = { k = 1 }");
    let text = closed_by("closure = \"penalty\"\npenalty = 1e8") + &idle;
    let said = succeeded(&program(&[&write(&directory("closures-idle"), &text)]));
    assert_says(&said, &["no mass acts on C 2 angle:"]);
}

#[test]
fn nonsense_is_refused_where_it_stands() {
    check_table(
        &closed_by(""),
        refusal,
        r#"
child = "rocker tip" => &\nclosure = "penalty" | closure | joint "C": closure needs penalty | add it
 => &\nclosure = "penalty"\npenalty = -2 | -2 | penalty = -2 is out of range | a positive stiffness
 => &\nclosure = "penalty"\npenalty = 0 | 0 | penalty = 0 is out | positive
 => &\nclosure = "penalty"\npenalty = 1e6\npenalty_damping = -1 | -1 | penalty_damping = -1 is out of range | zero or positive
 => &\nclosure = "multipliers"\npenalty = 1e6 | penalty | joint "C": penalty needs closure = "penalty" | remove this key
 => &\npenalty_damping = 0.1 | penalty_damping | needs closure | remove
 => closure = "multipliers" | closure | joint "C": closure needs child | add it
 => &\nclosure = 3 | | one of the words "map", "multipliers" and "penalty"
 => &\nclosure = "lagrange" | | `lagrange`
"#,
    );
    // What does not close names the joint and the gap.
    let apart = closed_by("closure = \"multipliers\"").replacen(
        "position = [1.2, 1.9, 0]",
        "position = [1.2, 1.9, 0.3]",
        1,
    );
    check(&apart, "\"C\"", "the gap along e3", "");
    let both = closed_by("closure = \"multipliers\"").replace(
        "name = \"B\"\ntype = \"revolute\"",
        "name = \"B\"\ntype = \"revolute\"\nrate = 3.0",
    );
    let said = refusal(&both).to_string();
    assert_says(&said, &["rates", "contradict"]);
}

#[test]
fn a_penalty_that_drowns_the_model_gets_a_word() {
    for (penalty, expected) in [("1e7", false), ("1e20", true)] {
        let text = closed_by(&format!("closure = \"penalty\"\npenalty = {penalty}"));
        let text = text.replace("to = 0.5", "to = 0.02");
        let [_, said] = told("closures-drowned", &text);
        let word = "penalty of C: rounding errors of the gap";
        let warned = said.concat().contains(word);
        assert_eq!(warned, expected, "{penalty}: {said:?}");
    }
}

/// A double pendulum whose second body flies freely but for a joint.
fn flying(closed: &str, step: &str) -> String {
    [
        "[nodes]\nground = [0, 0, 0]\nfree = [1.7, 0, 0]\n[[loads]]\ngravity = [0, -9.81, 0]\n",
        &fixed("ground"),
        &hinge("A", "ground", ""),
        &arm("arm", "A", [1.0, 0.0, 0.0]),
        &hinge("P", "arm", closed),
        &body("arm"),
        &body("free"),
        &format!(
            "[analysis.dynamic]\nto = 1\nstep = {step}\nscheme = {{ generalised-alpha = 0.8 }}\n"
        ),
        &probe("body", "position", "free"),
    ]
    .concat()
}

#[test]
fn bodies_that_fly_are_linked() {
    let tip = arm("tip", "free", [1.0, 0.0, 0.0]);
    let linked = format!("child = \"tip\"\nclosure = \"multipliers\"\n\n{tip}");
    let tree = "\n".to_owned() + &arm("rod", "P", [1.7, 0.0, 0.0]) + "child = \"free\"";
    let end = |closed: &str, step: &str| {
        let rows = recorded("closures-flying", &flying(closed, step));
        ["body.x", "body.y"].map(|k| number(rows.last().unwrap(), k))
    };
    let gaps = ["0.004", "0.002", "0.001"].map(|step| {
        let [a, b] = [&linked, &tree].map(|closed| end(closed, step));
        (a[0] - b[0]).hypot(a[1] - b[1])
    });
    for pair in gaps.windows(2) {
        assert!((pair[0] / pair[1]).log2() > 1.8, "{gaps:?}");
    }
    assert!(gaps[2] < 1e-5, "{gaps:?}");
    // No map closes that.
    let map = format!("child = \"tip\"\n\n{tip}");
    let said = refusal(&flying(&map, "0.001")).to_string();
    assert!(said.contains("joint P") && said.contains("free"), "{said}");
}
