//! What is wrong with joints, bodies, springs, initial conditions and dynamic analyses is refused
//! with its position and with what would be right.

use crate::support::*;
use std::sync::LazyLock;

/// Everything a moving model can have.
static MODEL: LazyLock<String> = LazyLock::new(|| {
    [
        "[sections.rod]\nstiffness = { EA = 1e4, GA = [1e4, 1e4], GJ = 10.0, EI = [10.0, 10.0] }\n\
         mass = { A_rho = 1, J = [2e-3, 1e-3, 1e-3] }\n\
         [nodes]\nA = [0, 0, 0]\nB = [1, 0, 0]\nC = [0, 1, 0]\n",
        &joint("hinge", "revolute", "A", "axis = [0, 1, 0]"),
        &beam_line("rod", ["hinge", "B"], 4, "rod"),
        "[[joints]]\nname = \"ring\"\ntype = \"slide\"\nlines = [\"rod\"]\nstart = 0.25\n",
        &joint("ball", "spherical", "B", ""),
        &joint("hand", "offset", "ball", "position = [1.5, 0, 0]"),
        &body_of("hand", 2.0, "inertia = [1, 1, 1]"),
        &body_of("ring", 0.1, ""),
        &body_of("C", 1.0, ""),
        "[[springs]]\nname = \"rope\"\nnodes = [\"C\", \"B\"]\nstiffness = 10.0\n",
        &fixed("A"),
        "[[initial]]\nnode = \"ball\"\nangular_velocity = [0, 0, 1]\n\
         [analysis.dynamic]\nto = 1.0\nstep = 0.1\nscheme = { hht = -0.1 }\n",
        &angle("hinge"),
    ]
    .concat()
});

#[test]
fn the_model_itself_is_fine() {
    ran(&directory("program_motion"), &MODEL);
}

#[test]
fn mistakes_are_refused_where_they_stand() {
    check_table(
        &MODEL,
        refusal,
        r#"
# Joints.
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
# Bodies and springs: no body has a moment of inertia above the sum of the others.
mass = 2.0 => mass = -2.0 | [[bodies]] | body of hand
[1, 1, 1] => [1, 1, 3] | [[bodies]] | body of hand
 => [1, 1] | [1, 1] | three numbers
 => [[1, 2, 0], [0, 1, 0], [0, 0, 1]] | [[bodies]] | body of hand
node = "C"\nmass => node = "D"\nmass | "D" | no node named "D"
name = "body of ring" => name = "body of hand" | "body of hand" | body of hand
["C", "B"] => ["C", "C"] | | rope
stiffness = 10.0\n => | [[springs]] | rope
stiffness = 10.0 => stiffness = -10.0 | | rope
 => bushing = { stiffness = [1, 1, 1, 1, 1] } | [1, 1 | six numbers
# Initial conditions.
node = "ball"\nangular_velocity = [0, 0, 1] => node = "ball" | [[initial]]
 => node = "ball"\nline = "rod"\nvelocity = [0, 0, 1] | line | line
 => rotation = [0, 0, 1] | rotation | rotation | node
 => node = "hand"\nvelocity = [1, 0, 0] | [1, 0, 0] | a joint that does not allow it | joint
 => node = "hinge"\nangular_velocity = [1, 0, 0] | [1, 0, 0] | a joint that does not allow it | joint
 => node = "A"\ndisplacement = [0, 0, 1] | [0, 0, 1] | held
 => line = "bar"\nvelocity = [0, 0, 1] | "bar" | no line named "bar" | `rod`
 => node = "C"\nangular_velocity = [0, 0, 1]\nbody_angular_velocity = [0, 0, 1] | body_angular_velocity
# Analyses and probes.
step = 0.1 => step = 0 | 0 | step | positive
 => step = 2 | 2 | step | to
 => &\nrecord_every = 0 | 0 | record_every
 => &\nrecord_interval = -1 | -1 | record_interval
 => &\nrecord_every = 2\nrecord_interval = 0.5 | record_interval | record_every
 => &\nrecord_interval = 1e-10 | 1e-10 | record_interval | at most 1e9 rows
 => &\nadaptive = { tolerance = 0 } | 0 | tolerance
to = 1.0 => to = -1.0 | -1.0 | to | positive
{ hht = -0.1 } => { hht = 0.1 } | { hht | alpha
 => { newmark = [0.1, 0.2] } | { newmark | gamma
 => { wbz = 1.5 } | { wbz | rho
 => { rk4 = 1 } | { rk4 | scheme `rk4`: no scheme has this name; there are
joint = "hinge" => joint = "ball" | "ball" | released coordinate
joint = "hinge"\n => | | needs
"joint_coordinate"\njoint = "hinge" => "joint_force"\nnode = "C" | | is attached to no joint
# Forms that the parser knows by other words.
axis = [0, 1, 0] => &\nactuator = 5 | 5 | a table with one key
 => &\nactuator = "constant" | | a table with one key
{ hht = -0.1 } => "hht" | "hht" | 0 numbers are given
step = 0.1 => &\nadaptive = 1e-4 | 1e-4 | expected a table of its keys
[[supports]] => [supports] | | two brackets
[analysis.dynamic] => [analysis.static]\n[analysis.dynamic] | | exactly one key | static, arc_length, dynamic, modes
name = "hinge"\nquantity => name = "t"\nquantity | "t" | another column "t" | another name
quantity = "joint_coordinate"\njoint = "hinge" => &\n[[probes]]\nname = "t"\nquantity = "position"\nnode = "C" | "t" | another column "t" | another name
"#,
    );
}

#[test]
fn what_can_move_needs_an_analysis_in_time() {
    let still = "[analysis.dynamic]\\nto = 1.0\\nstep = 0.1\\nscheme = { hht = -0.1 }\\n =>";
    let said = refusal(&changed(&MODEL, still)).to_string();
    let words = ["can move", "dynamic"];
    assert!(words.iter().any(|word| said.contains(word)), "{said}");
}

#[test]
fn a_structure_without_mass_is_named_when_it_starts() {
    let directory = directory("program_massless");
    // Statics of its rods and the motion of its bodies: a fine model.
    let massless = "mass = { A_rho = 1, J = [2e-3, 1e-3, 1e-3] }\\n =>";
    ran(&directory, &changed(&MODEL, massless));
    // A node that nothing holds and that has neither mass nor stiffness about its axis.
    let changes = "[[bodies]]\\nname = \"body of C\"\\nnode = \"C\"\\nmass = 1.0\\n =>\n\
        stiffness = 10.0 => &\\n[[springs]]\\nname = \"more\"\\nnodes = [\"C\", \"A\"]\\nstiffness = 1.0";
    let output = program(&[&write(&directory, &changed(&MODEL, changes))]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_ne!(output.status.code(), Some(101), "{said}");
    assert_says(&said, &["node C"]);
}

#[test]
fn a_slide_is_warned_of_the_corners_of_an_arc() {
    let said = |text: &str| {
        let out = ran(&directory("program_corners"), text);
        read(out.join("result.json"))
    };
    let told = "joint ring slides over corners of 45.0 degrees between the elements of the arc rod";
    let changes = "section = \"rod\" => &\\narc = { center = [0.5, 0, 0], axis = [0, 1, 0], angle_deg = 180 }\n\
                   to = 1.0 => to = 0.1";
    assert_says(&said(&changed(&MODEL, changes)), &[told]);
    assert!(!said(&MODEL).contains("slides over"));
}

#[test]
fn a_motion_that_cannot_begin_leaves_earlier_results_alone() {
    let directory = directory("program_cannot_begin");
    let text = |load: &str| {
        let load = format!("[[loads]]\nnode = \"A\"\n{load}\n");
        let nodes = "[nodes]\nA = [0, 0, 0]\n";
        [nodes, &body_of("A", 1.0, ""), &load, &motion(0.1, 0.01)].concat()
    };
    let out = ran(&directory, &text("force = [0, 0, -1]"));
    let before = read(out.join("result.json"));
    // A moment on a point: nothing resists the rotation that it needs.
    let model = write(&directory, &text("moment = [0, 0, 1]"));
    let said = ended(&program(&[&model]), 2);
    assert_says(&said, &["node A, rotation about e"]);
    assert_eq!(read(out.join("result.json")), before);
}
