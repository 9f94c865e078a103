//! What is wrong with joints, bodies, springs, initial conditions and dynamic analyses is refused
//! with its position and with what would be right.
#![allow(clippy::unwrap_used)]

use crate::support::program::{check, check_table, directory, ended, program, ran, refusal, write};

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
    check_table(
        MODEL,
        refusal,
        r#"
"revolute" => "revolut" | "revolut" | revolut | did you mean `revolute`
axis = [0, 1, 0]\n => | [[joints]] | needs axis
position = [1.5, 0, 0]\n => | [[joints]] | needs position
parent = "B"\n => | [[joints]] | needs parent
lines = ["rod"]\n => | [[joints]] | needs lines
axis = [0, 1, 0] => axis = [0, 0, 0] | [0, 0, 0] | axis
parent = "B" => parent = "Q" | "Q" | no node named "Q" | here are
 => parent = "hand" | " | wait for each other | start at a node
start = 0.25 => axis = [0, 0, 1] | axis | axis
 => start = 9 | 9 | ring
lines = ["rod"] => lines = ["rope"] | "rope" | no line named "rope" | `rod`
elements = 4 => &\norder = 2 | "rod" | order
name = "ball" => name = "hinge" | "hinge" | hinge
axis = [0, 1, 0] => &\nprescribed = { proportional = 1 }\nspring = { k = 1 } | spring | hinge
 => &\nprescribed = { pulse = { end = 1 } } | { pulse | jump | ramp
 => &\nspring = { k = nan } | nan
node = "A"\nfix => node = "hinge"\nfix | | hinge
"#,
    );
}

#[test]
fn bodies_and_springs() {
    // No body has a moment of inertia above the sum of the others.
    check_table(
        MODEL,
        refusal,
        r#"
mass = 2.0 => mass = -2.0 | [[bodies]] | bob
[1, 1, 1] => [1, 1, 3] | [[bodies]] | bob
 => [1, 1] | [1, 1] | three numbers
 => [[1, 2, 0], [0, 1, 0], [0, 0, 1]] | [[bodies]] | bob
node = "C"\nmass => node = "D"\nmass | "D" | no node named "D"
name = "bead" => name = "bob" | "bob" | bob
["C", "B"] => ["C", "C"] | | rope
stiffness = 10.0\n => | [[springs]] | rope
stiffness = 10.0 => stiffness = -10.0 | | rope
 => bushing = { stiffness = [1, 1, 1, 1, 1] } | [1, 1 | six numbers
"#,
    );
}

#[test]
fn initial_conditions() {
    check_table(
        MODEL,
        refusal,
        r#"
node = "ball"\nangular_velocity = [0, 0, 1] => node = "ball" | [[initial]]
 => node = "ball"\nline = "rod"\nvelocity = [0, 0, 1] | line | line
 => rotation = [0, 0, 1] | rotation | rotation | node
 => node = "hand"\nvelocity = [0, 0, 1] | velocity | is attached to a joint | rate
 => node = "hinge"\nangular_velocity = [0, 1, 0] | angular_velocity | is attached to a joint | rate
 => node = "A"\ndisplacement = [0, 0, 1] | [0, 0, 1] | held
 => line = "bar"\nvelocity = [0, 0, 1] | "bar" | no line named "bar" | `rod`
 => node = "C"\nangular_velocity = [0, 0, 1]\nbody_angular_velocity = [0, 0, 1] | body_angular_velocity
"#,
    );
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
    check_table(
        MODEL,
        refusal,
        r#"
step = 0.1 => step = 0 | 0 | step | positive
 => step = 2 | 2 | step | to
 => &\nrecord_every = 0 | 0 | record_every
 => &\nrecord_interval = -1 | -1 | record_interval
 => &\nrecord_every = 2\nrecord_interval = 0.5 | 0.5 | record_interval | no record_every
 => &\nrecord_interval = 1e-10 | 1e-10 | record_interval | at most 1e9 rows
 => &\nadaptive = { tolerance = 0 } | 0 | tolerance
to = 1.0 => to = -1.0 | -1.0 | to | positive
{ hht = -0.1 } => { hht = 0.1 } | { hht | alpha
 => { newmark = [0.1, 0.2] } | { newmark | gamma
 => { wbz = 1.5 } | { wbz | rho
 => { rk4 = 1 } | { rk4 | scheme `rk4`: no scheme is called so; there are
joint = "hinge" => joint = "ball" | "ball" | released coordinate
joint = "hinge"\n => | | needs
"joint_coordinate"\njoint = "hinge" => "joint_force"\nnode = "C" | | is attached to no joint
"#,
    );
}

#[test]
fn forms_that_the_parser_knows_by_other_words() {
    check_table(
        MODEL,
        refusal,
        r#"
axis = [0, 1, 0] => &\nactuator = 5 | 5 | a table with one key
 => &\nactuator = "constant" | | a table with one key
{ hht = -0.1 } => "hht" | "hht" | 0 numbers are given
step = 0.1 => &\nadaptive = 1e-4 | 1e-4 | expected a table of its keys
[[supports]] => [supports] | | two brackets
[analysis.dynamic] => [analysis.static]\n[analysis.dynamic] | | exactly one key
name = "angle" => name = "t" | "t" | another column "t" | another name
"#,
    );
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
fn a_joint_with_nothing_on_it_is_pointed_at() {
    let text = with("from = \"hinge\"", "from = \"A\"");
    let text = text.replace(
        "[[probes]]\nname = \"angle\"\nquantity = \"joint_coordinate\"\njoint = \"hinge\"\n",
        "",
    );
    check(&text, "\"hinge\"", "hinge angle carries no element", "");
}
