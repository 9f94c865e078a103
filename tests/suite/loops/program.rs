//! Closed loops in model files: what the program finds out, says and refuses.

use crate::support::closures::{
    GROUND, PLAIN, arm, body, body_of, hinge, joint, motion, probe, rows, started,
};
use crate::support::program::*;

/// The four-bar linkage with [other words](changed).
fn with(changes: &str) -> String {
    changed(&example("four_bar"), changes)
}

#[test]
fn a_rate_where_the_drive_leaves_no_freedom_is_refused() {
    let driven = with(
        r#"rate = 4.5 => prescribed = { proportional = 4.5 }
name = "D" => &\nrate = 1"#,
    );
    let said = refusal(&driven).to_string();
    assert!(said.contains("the initial rate of D"), "{said}");
    assert!(said.contains("leaves it no freedom"), "{said}");
}

/// A six-bar linkage with the rates of all joints of its tree, from SciPy's null space of its closures.
#[test]
fn initial_rates_that_agree_are_taken() {
    let [a, b, c] = [[-1.4, -0.8, 0.0], [-0.1, 0.5, 0.0], [1.0, -0.7, 0.0]];
    let [d, e, f] = [[-1.5, 0.0, 0.0], [-1.6, -0.7, 0.0], [1.2, -0.9, 0.0]];
    let turning = |name: &str, parent: &str, rate: &str| {
        [hinge(name, parent, &format!("rate = {rate}")), body(name)].concat()
    };
    let text = [
        GROUND,
        PLAIN,
        &motion(0.001, 0.001),
        &arm("f", "ground", f),
        &arm("a", "ground", a),
        &turning("F", "f", "0.006821377674529594"),
        &arm("e", "F", e),
        &turning("E", "e", "-1.0068213776745296"),
        &arm("d", "E", d),
        &turning("A", "a", "-0.2996601052802919"),
        &arm("b", "A", b),
        &turning("B", "b", "0.5612624252080025"),
        &arm("c", "B", c),
        &turning("C", "c", "-0.25468061090979693"),
        &arm("tip", "C", d),
        &hinge("D", "tip", "child = \"d\""),
    ];
    let (_, rows) = rows("loops-agreed", &text.concat());
    assert_eq!(rows.len(), 2);
}

#[test]
fn a_free_child_hangs_on_its_joint() {
    // The rocker's tip as a node of its own, with a body of its own on it.
    let text = with(
        r#"ground = [0, 0, 0] => &\nweight = [1.2, 1.9, 0]
child = "rocker tip" => child = "weight"
to = 4 => to = 0.02
rate = 4.5 =>"#,
    ) + &body("weight");
    let (said, _) = rows("loops-free", &text);
    assert!(said.contains("joint C: weight is attached to it"), "{said}");
}

#[test]
fn what_does_not_close_is_refused_with_the_joint_and_the_gap() {
    // A coupler that ends beside the plane of the others.
    let text = with("position = [1.2, 1.9, 0] => position = [1.2, 1.9, 0.3]");
    let said = refusal(&text).to_string();
    assert_says(&said, &["gap along e3 at joint C", "e-1"]);
    // A free node at another position.
    let text = with(
        r#"ground = [0, 0, 0] => &\nweight = [1.2, 2, 0]
child = "rocker tip" => child = "weight""#,
    ) + &body("weight");
    let said = refusal(&text).to_string();
    assert!(said.contains("joint C") && said.contains("apart"), "{said}");
    // Rates that the loop does not allow.
    let text = with(r#"name = "B" => &\nrate = 3.0"#);
    check(&text, "4.5", "rates of A, B contradict", "rates");
    // A loop over a body that flies freely.
    let text = with(
        r#"ground = [0, 0, 0] => &\nfree = [1.6, 0, 0]
parent = "foot" => parent = "free""#,
    );
    let said = refusal(&text).to_string();
    assert!(said.contains("joint C") && said.contains("free"), "{said}");
}

#[test]
fn a_singular_start_is_named() {
    // A parallelogram drawn flat.
    let text = with(
        "position = [0, 1, 0] => position = [1, 0, 0]
position = [1.2, 1.9, 0] => position = [3, 0, 0]
position = [1.6, 0, 0] => position = [2, 0, 0]
position = [1.2, 1.9, 0] => position = [3, 0, 0]",
    );
    let said = refusal(&text).to_string();
    assert_says(&said, &["singular", "joint C"]);
    assert!(!said.contains("there none"), "{said}");
}

/// With its slider driven a slider-crank that is drawn straight closes in two ways: what says nothing
/// there to first order is the gap along the guide. The gap out of the plane never does.
#[test]
fn a_singular_start_is_told_by_the_equation_that_vanishes_only_there() {
    let drive = "axis = [1, 0, 0]\nprescribed = { sine = { amplitude = -0.1, omega = 3 } }";
    let text = [
        GROUND,
        &hinge("crank", "ground", ""),
        &arm("pin", "crank", [0.4, 0.0, 0.0]),
        &hinge("rod", "pin", ""),
        &arm("end", "rod", [1.4, 0.0, 0.0]),
        &arm("guide", "ground", [1.4, 0.0, 0.0]),
        &joint("slider", "prismatic", "guide", drive),
        &hinge("wrist", "end", "child = \"slider\""),
        &body("rod"),
        "[analysis.dynamic]\nto = 1\nstep = 0.01\n",
    ]
    .concat();
    let said = refusal(&text).to_string();
    let expected = "the gap along e1 at joint wrist says nothing to first order";
    assert_says(&said, &[expected]);
}

/// The notes of a model file.
fn notes(text: &str) -> Vec<String> {
    started(text).context.descriptions()
}

#[test]
fn the_loop_leaves_the_crank_free_and_what_carries_something() {
    // The crank by its rate and position; as they are drawn other angles are better by less than 10.
    assert!(notes(&example("four_bar"))[0].contains("independent: A angle;"));
    let none = with("rate = 4.5 =>");
    assert!(notes(&none)[0].contains("independent: A angle;"));
    for joint in ["B", "C", "D"] {
        let sprung = format!("name = \"{joint}\" => &\\nspring = {{ k = 1 }}");
        let text = with(&format!("rate = 4.5 =>\n{sprung}"));
        let said = &notes(&text)[0];
        assert_says(said, &[&format!("independent: {joint} angle;")]);
    }
}

#[test]
fn degrees_of_freedom_are_told() {
    let said = "degrees of freedom: 1 of 4 coordinates, 1 loop with 6 equations, of which 3 are \
                redundant";
    let out = directory("loops-mobility");
    let model = write(&out, &with("to = 4 => to = 0.01"));
    let ran = program(&[&model]);
    assert!(String::from_utf8(ran.stdout).unwrap().contains(said));
    assert_eq!(ran.stderr, b"", "no warning");
    // The same by multipliers.
    let text = with(
        r#"child = "rocker tip" => &\nclosure = "multipliers"
newmark = [0.25, 0.5] => generalised-alpha = 0.8"#,
    );
    assert_eq!(started(&text).context.mobility().to_string(), said);
}

#[test]
fn a_linkage_that_cannot_move_is_warned_of() {
    // The coupler's first axis lies in the plane: nothing can turn. A pendulum beside it can.
    let wrong = with(
        r#"to = 4 => to = 0.01
rate = 4.5 =>
parent = "crank tip"\naxis = [0, 0, 1] => parent = "crank tip"\naxis = [0, 1, 0]"#,
    ) + &hinge("P", "ground", "")
        + &body_of("P", 1.0, "center = [1, 0, 0]\ninertia = [1, 1, 1]");
    let [_, warnings] = told("loops-locked", &wrong);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let said =
        "the loop closed by joint C cannot move: its 6 equations leave none of 4 coordinates";
    assert!(warnings[0].starts_with(said), "{warnings:?}");
    pullback::check::job(&mut started(&wrong), 0).assert();
}

#[test]
fn coordinates_without_mass_are_warned_of() {
    let bare = with("to = 4 => to = 0.01") + &hinge("P", "ground", "spring = { k = 1 }");
    let [_, warnings] = told("loops-massless", &bare);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let said = "no mass acts on P angle: without mass a coordinate follows forces at once.";
    assert!(warnings[0].starts_with(said), "{warnings:?}");
}

/// Probes of force and moment of the joint at a frame, or of the ground's support.
pub(super) fn probes(of: &str) -> String {
    let kind = if of == "ground" { "reaction" } else { "joint" };
    let both = ["force", "moment"];
    both.map(|what| probe(&format!("{what} {of}"), &format!("{kind}_{what}"), of))
        .concat()
}

/// An arch of two links at rest: a hinge at the origin, a ball at (1, 0, 1), a ball at (2, 0, 0), the
/// second link's weight of 10 at (1.5, 0, 0.5). The first link bears no moment, so that its force is
/// along (1, 0, 1); about the far end 10 · 0.5 = F_z · 1 + F_x · 1, F_x = F_z = 2.5.
#[test]
fn no_moment_passes_a_ball_in_a_loop() {
    let inertia = "center = [0.5, 0, -0.5]\ninertia = [0.1, 0.1, 0.1]";
    let arch = |closure: &str| {
        let closed = format!("child = \"foot\"\n{closure}");
        [
            GROUND,
            &joint("A", "revolute", "ground", "axis = [0, 1, 0]"),
            &arm("link 1", "A", [1.0, 0.0, 1.0]),
            &joint("S", "spherical", "link 1", ""),
            &arm("link 2", "S", [2.0, 0.0, 0.0]),
            &arm("foot", "ground", [2.0, 0.0, 0.0]),
            &joint("C", "spherical", "link 2", &closed),
            &body_of("S", 1.0, inertia),
            "[[loads]]\ngravity = [0, 0, -10]\n",
            &motion(0.01, 0.01),
            PLAIN,
            &["A", "S", "ground"].map(probes).concat(),
        ]
        .concat()
    };
    let held = "node = \"ground\"\nfix = \"all\"";
    // A ground that moves, hardly, is a parameter of the loop's map.
    let moving = "node = \"ground\"\nfix = [\"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
        prescribed = { x = { proportional = 1e-12 } }";
    for (name, closure, support) in [
        ("map", "", held),
        ("moving", "", moving),
        ("multipliers", "closure = \"multipliers\"", held),
    ] {
        let text = arch(closure);
        assert!(text.contains(held));
        for row in recorded(&format!("ball_{name}"), &text.replace(held, support)) {
            for (what, exact) in [
                ("force A", [2.5, 0.0, 2.5]),
                ("force S", [2.5, 0.0, 2.5]),
                ("moment A", [0.0; 3]),
                ("moment S", [0.0; 3]),
                ("force ground", [0.0, 0.0, 10.0]),
                ("moment ground", [0.0, -15.0, 0.0]),
            ] {
                for (c, exact) in ["x", "y", "z"].into_iter().zip(exact) {
                    let column = format!("{what}.{c}");
                    let about = format_args!("{name}, {column}");
                    assert_close(number(&row, &column), exact, 1e-9, about);
                }
            }
        }
    }
}
