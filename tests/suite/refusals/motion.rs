//! What is wrong with joints, bodies, springs, initial conditions and dynamic analyses is refused
//! with its position and with what would be right.
#![allow(clippy::unwrap_used)]

use crate::support::program::{check, directory, ended, program, ran, refusal, write};

/// Everything a moving model can have.
const MODEL: &str = r#"[sections.rod]
stiffness = { EA = 1e4, GA = [1e4, 1e4], GJ = 10.0, EI = [10.0, 10.0] }
mass = { A_rho = 1, J = [2e-3, 1e-3, 1e-3] }

[nodes]
A = [0, 0, 0]
B = [1, 0, 0]
C = [0, 1, 0]

[[joints]]
name = "hinge"
type = "revolute"
parent = "A"
axis = [0, 1, 0]

[[lines]]
name = "rod"
from = "hinge"
to = "B"
elements = 4
section = "rod"

[[joints]]
name = "ring"
type = "slide"
lines = ["rod"]
start = 0.25

[[joints]]
name = "ball"
type = "spherical"
parent = "B"

[[joints]]
name = "hand"
type = "offset"
parent = "ball"
position = [1.5, 0, 0]

[[bodies]]
name = "bob"
node = "hand"
mass = 2.0
inertia = [1, 1, 1]

[[bodies]]
name = "bead"
node = "ring"
mass = 0.1

[[bodies]]
name = "buoy"
node = "C"
mass = 1.0

[[springs]]
name = "rope"
nodes = ["C", "B"]
stiffness = 10.0

[[supports]]
node = "A"
fix = "all"

[[initial]]
node = "ball"
angular_velocity = [0, 0, 1]

[analysis.dynamic]
to = 1.0
step = 0.1
scheme = { hht = -0.1 }

[[probes]]
name = "angle"
quantity = "joint_coordinate"
joint = "hinge"
"#;

/// The model with one part of its text replaced.
fn with(old: &str, new: &str) -> String {
    assert!(MODEL.contains(old), "the model does not contain {old:?}");
    MODEL.replacen(old, new, 1)
}

#[test]
fn the_model_itself_is_fine() {
    ran(&directory("program_motion"), MODEL);
}

#[test]
fn joints() {
    let cases = [
        (
            with("\"revolute\"", "\"revolut\""),
            "\"revolut\"",
            "revolut",
            "did you mean `revolute`",
        ),
        (
            with("axis = [0, 1, 0]\n", ""),
            "[[joints]]",
            "needs axis",
            "",
        ),
        (
            with("position = [1.5, 0, 0]\n", ""),
            "[[joints]]",
            "needs position",
            "",
        ),
        (
            with("parent = \"B\"\n", ""),
            "[[joints]]",
            "needs parent",
            "",
        ),
        (
            with("lines = [\"rod\"]\n", ""),
            "[[joints]]",
            "needs lines",
            "",
        ),
        (
            with("axis = [0, 1, 0]", "axis = [0, 0, 0]"),
            "[0, 0, 0]",
            "axis",
            "",
        ),
        (
            with("parent = \"B\"", "parent = \"Q\""),
            "\"Q\"",
            "no node named \"Q\"",
            "here are",
        ),
        (
            with("parent = \"B\"", "parent = \"hand\""),
            "\"",
            "wait for each other",
            "start at a node",
        ),
        (with("start = 0.25", "axis = [0, 0, 1]"), "axis", "axis", ""),
        (with("start = 0.25", "start = 9"), "9", "ring", ""),
        (
            with("lines = [\"rod\"]", "lines = [\"rope\"]"),
            "\"rope\"",
            "no line named \"rope\"",
            "`rod`",
        ),
        (
            with("elements = 4", "elements = 4\norder = 2"),
            "\"rod\"",
            "order",
            "",
        ),
        (
            with("name = \"ball\"", "name = \"hinge\""),
            "\"hinge\"",
            "hinge",
            "",
        ),
        (
            with(
                "axis = [0, 1, 0]",
                "axis = [0, 1, 0]\nprescribed = { proportional = 1 }\nspring = { k = 1 }",
            ),
            "spring",
            "hinge",
            "",
        ),
        (
            with(
                "axis = [0, 1, 0]",
                "axis = [0, 1, 0]\nprescribed = { pulse = { end = 1 } }",
            ),
            "{ pulse",
            "jump",
            "ramp",
        ),
        (
            with("axis = [0, 1, 0]", "axis = [0, 1, 0]\nspring = { k = nan }"),
            "nan",
            "",
            "",
        ),
        (
            with("node = \"A\"\nfix", "node = \"hinge\"\nfix"),
            "",
            "hinge",
            "",
        ),
    ];
    for (text, position, message, advice) in &cases {
        check(text, position, message, advice);
    }
}

#[test]
fn bodies_and_springs() {
    let cases = [
        (with("mass = 2.0", "mass = -2.0"), "[[bodies]]", "bob", ""),
        // No body has a moment of inertia above the sum of the others.
        (with("[1, 1, 1]", "[1, 1, 3]"), "[[bodies]]", "bob", ""),
        (with("[1, 1, 1]", "[1, 1]"), "[1, 1]", "three numbers", ""),
        (
            with("[1, 1, 1]", "[[1, 2, 0], [0, 1, 0], [0, 0, 1]]"),
            "[[bodies]]",
            "bob",
            "",
        ),
        (
            with("node = \"C\"\nmass", "node = \"D\"\nmass"),
            "\"D\"",
            "no node named \"D\"",
            "",
        ),
        (
            with("name = \"bead\"", "name = \"bob\""),
            "\"bob\"",
            "bob",
            "",
        ),
        (with("[\"C\", \"B\"]", "[\"C\", \"C\"]"), "", "rope", ""),
        (with("stiffness = 10.0\n", ""), "[[springs]]", "rope", ""),
        (
            with("stiffness = 10.0", "stiffness = -10.0"),
            "",
            "rope",
            "",
        ),
        (
            with(
                "stiffness = 10.0",
                "bushing = { stiffness = [1, 1, 1, 1, 1] }",
            ),
            "[1, 1",
            "six numbers",
            "",
        ),
    ];
    for (text, position, message, advice) in &cases {
        check(text, position, message, advice);
    }
}

#[test]
fn initial_conditions() {
    let old = "node = \"ball\"\nangular_velocity = [0, 0, 1]";
    let cases = [
        ("node = \"ball\"", "[[initial]]", "", ""),
        (
            "node = \"ball\"\nline = \"rod\"\nvelocity = [0, 0, 1]",
            "line",
            "line",
            "",
        ),
        ("rotation = [0, 0, 1]", "rotation", "rotation", "node"),
        (
            "node = \"hand\"\nvelocity = [0, 0, 1]",
            "velocity",
            "is attached to a joint",
            "rate",
        ),
        (
            "node = \"hinge\"\nangular_velocity = [0, 1, 0]",
            "angular_velocity",
            "is attached to a joint",
            "rate",
        ),
        (
            "node = \"A\"\ndisplacement = [0, 0, 1]",
            "[0, 0, 1]",
            "held",
            "",
        ),
        (
            "line = \"bar\"\nvelocity = [0, 0, 1]",
            "\"bar\"",
            "no line named \"bar\"",
            "`rod`",
        ),
        (
            "node = \"C\"\nangular_velocity = [0, 0, 1]\nbody_angular_velocity = [0, 0, 1]",
            "body_angular_velocity",
            "",
            "",
        ),
    ];
    for (new, position, message, advice) in cases {
        check(&with(old, new), position, message, advice);
    }
    let statics = with(
        "[analysis.dynamic]\nto = 1.0\nstep = 0.1\nscheme = { hht = -0.1 }\n",
        "",
    );
    let said = refusal(&statics).to_string();
    assert!(
        said.contains("can move") || said.contains("dynamic"),
        "{said}"
    );
}

#[test]
fn analyses_and_probes() {
    let cases = [
        (with("step = 0.1", "step = 0"), "0", "step", "positive"),
        (with("step = 0.1", "step = 2"), "2", "step", "to"),
        (with("to = 1.0", "to = -1.0"), "-1.0", "to", "positive"),
        (
            with("{ hht = -0.1 }", "{ hht = 0.1 }"),
            "{ hht",
            "alpha",
            "",
        ),
        (
            with("{ hht = -0.1 }", "{ newmark = [0.1, 0.2] }"),
            "{ newmark",
            "gamma",
            "",
        ),
        (with("{ hht = -0.1 }", "{ wbz = 1.5 }"), "{ wbz", "rho", ""),
        (
            with("{ hht = -0.1 }", "{ rk4 = 1 }"),
            "{ rk4",
            "scheme `rk4`: no scheme is called so; there are",
            "",
        ),
        (
            with("step = 0.1", "step = 0.1\nrecord_every = 0"),
            "0",
            "record_every",
            "",
        ),
        (
            with("step = 0.1", "step = 0.1\nrecord_interval = -1"),
            "-1",
            "record_interval",
            "",
        ),
        (
            with(
                "step = 0.1",
                "step = 0.1\nrecord_every = 2\nrecord_interval = 0.5",
            ),
            "0.5",
            "record_interval",
            "no record_every",
        ),
        (
            with("step = 0.1", "step = 0.1\nrecord_interval = 1e-10"),
            "1e-10",
            "record_interval",
            "at most 1e9 rows",
        ),
        (
            with("step = 0.1", "step = 0.1\nadaptive = { tolerance = 0 }"),
            "0",
            "tolerance",
            "",
        ),
        (
            with("joint = \"hinge\"", "joint = \"ball\""),
            "\"ball\"",
            "released coordinate",
            "",
        ),
        (with("joint = \"hinge\"\n", ""), "", "needs", ""),
        (
            with(
                "\"joint_coordinate\"\njoint = \"hinge\"",
                "\"joint_force\"\nnode = \"C\"",
            ),
            "",
            "is attached to no joint",
            "",
        ),
    ];
    for (text, position, message, advice) in &cases {
        check(text, position, message, advice);
    }
}

#[test]
fn a_structure_without_mass_is_named_when_it_starts() {
    let directory = directory("program_massless");
    let text = with("mass = { A_rho = 1, J = [2e-3, 1e-3, 1e-3] }\n", "");
    // Statics of its rods and the motion of its bodies: a fine model.
    ran(&directory, &text);
    // A node that nothing holds and that has neither mass nor stiffness about its axis.
    let text = with(
        "stiffness = 10.0",
        "stiffness = 10.0\n\n[[springs]]\nname = \"more\"\nnodes = [\"C\", \"A\"]\nstiffness = 1.0",
    );
    let text = text.replace(
        "[[bodies]]\nname = \"buoy\"\nnode = \"C\"\nmass = 1.0\n",
        "",
    );
    let output = program(&[&write(&directory, &text)]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_ne!(output.status.code(), Some(101), "{said}");
    assert!(said.contains("node C"), "{said}");
}

#[test]
fn a_motion_that_cannot_begin_leaves_earlier_results_alone() {
    let directory = directory("program_cannot_begin");
    let text = r#"
[nodes]
A = [0, 0, 0]

[[bodies]]
name = "ball"
node = "A"
mass = 1

[[loads]]
node = "A"
force = [0, 0, -1]

[analysis.dynamic]
to = 0.1
step = 0.01
"#;
    let model = write(&directory, text);
    assert!(program(&[&model]).status.success());
    let out = directory.join("model.out");
    let before = crate::support::program::read(out.join("result.json"));
    // A moment on a point: nothing resists the rotation that it needs.
    let moment = text.replace("force = [0, 0, -1]", "moment = [0, 0, 1]");
    write(&directory, &moment);
    let output = program(&[&model]);
    let said = ended(&output, 2);
    assert!(said.contains("node A, rotation about e"), "{said}");
    assert_eq!(
        crate::support::program::read(out.join("result.json")),
        before
    );
}

#[test]
fn forms_that_the_parser_knows_by_other_words() {
    let motor = |form: &str| {
        with(
            "axis = [0, 1, 0]",
            &format!("axis = [0, 1, 0]\nactuator = {form}"),
        )
    };
    let cases = [
        (motor("5"), "5", "a table with one key", ""),
        (motor("\"constant\""), "", "a table with one key", ""),
        (
            with("{ hht = -0.1 }", "\"hht\""),
            "\"hht\"",
            "0 numbers are given",
            "",
        ),
        (
            with("step = 0.1", "step = 0.1\nadaptive = 1e-4"),
            "1e-4",
            "expected a table of its keys",
            "",
        ),
        (with("[[supports]]", "[supports]"), "", "two brackets", ""),
        (
            with(
                "[analysis.dynamic]",
                "[analysis.static]\n[analysis.dynamic]",
            ),
            "",
            "exactly one key",
            "",
        ),
        (
            with("name = \"angle\"", "name = \"t\""),
            "\"t\"",
            "another column \"t\"",
            "another name",
        ),
    ];
    for (text, position, message, advice) in &cases {
        check(text, position, message, advice);
    }
}

#[test]
fn a_joint_with_nothing_on_it_is_pointed_at() {
    let text = with("from = \"hinge\"", "from = \"A\"");
    let text = text.replace(
        "[[probes]]\nname = \"angle\"\nquantity = \"joint_coordinate\"\njoint = \"hinge\"\n",
        "",
    );
    check(&text, "\"hinge\"", "hinge angle carries no element", "");
}
