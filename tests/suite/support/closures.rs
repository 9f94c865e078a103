//! Joints and loops in words, for tests of closures by the program.

use crate::support::loops::four_bar::{DRAWN, closed_form};
use crate::support::program::{Rows, directory, history, printed, write};
use pullback::input::{Job, assemble_text};
use pullback::manifold::system::Point;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

pub const GROUND: &str =
    "[nodes]\nground = [0, 0, 0]\n[[supports]]\nnode = \"ground\"\nfix = \"all\"\n";
pub const GRAVITY: &str = "[[loads]]\ngravity = [0, 0, -9.81]\n";
pub const RUN: &str =
    "[analysis.dynamic]\nto = 0.5\nstep = 0.005\nscheme = { generalised-alpha = 0.8 }\n";
pub const STATIC: &str = "[analysis.static]\nsteps = 4\n";
pub const CLOSURES: [&str; 3] = [
    "closure = \"map\"",
    "closure = \"multipliers\"",
    "closure = \"penalty\"\npenalty = 1e7",
];

pub fn joint(name: &str, kind: &str, parent: &str, more: &str) -> String {
    format!("[[joints]]\nname = \"{name}\"\ntype = \"{kind}\"\nparent = \"{parent}\"\n{more}\n")
}

pub fn hinge(name: &str, parent: &str, more: &str) -> String {
    let axis = format!("axis = [0, 0, 1]\n{more}");
    joint(name, "revolute", parent, &axis)
}

pub fn arm(name: &str, parent: &str, position: [f64; 3]) -> String {
    joint(name, "offset", parent, &format!("position = {position:?}"))
}

/// A body of a node, with what else it has.
pub fn body_of(node: &str, mass: f64, more: &str) -> String {
    format!("[[bodies]]\nname = \"body of {node}\"\nnode = \"{node}\"\nmass = {mass:?}\n{more}\n")
}

pub fn body(node: &str) -> String {
    body_of(node, 1.0, "inertia = [0.1, 0.1, 0.1]")
}

pub fn fixed(node: &str) -> String {
    format!("[[supports]]\nnode = \"{node}\"\nfix = \"all\"\n")
}

/// A line of beam elements between two nodes.
pub fn beam_line(name: &str, [from, to]: [&str; 2], elements: usize, section: &str) -> String {
    format!(
        "[[lines]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\n\
         elements = {elements}\nsection = \"{section}\"\n"
    )
}

/// A probe of a quantity at a node.
pub fn probe(name: &str, quantity: &str, node: &str) -> String {
    probe_of(name, quantity, &format!("node = \"{node}\""))
}

/// A probe of a quantity with further keys.
pub fn probe_of(name: &str, quantity: &str, more: &str) -> String {
    format!("[[probes]]\nname = \"{name}\"\nquantity = \"{quantity}\"\n{more}\n")
}

/// Cranks of 1 at A and √1.1 at D on the ground, bars of √1.64 and √1.25 between their tips, no bodies;
/// with what A, D and the closing joint C have besides.
pub fn five_bar([at_a, at_d, at_c]: [&str; 3]) -> String {
    [
        GROUND,
        RUN,
        &hinge("A", "ground", at_a),
        &arm("a", "A", [1.0, 0.0, 0.0]),
        &hinge("B", "a", ""),
        &arm("b", "B", [1.8, 1.0, 0.0]),
        &hinge("E", "b", ""),
        &arm("e", "E", [1.3, 2.0, 0.0]),
        &arm("foot", "ground", [0.0, 2.0, 0.0]),
        &hinge("D", "foot", at_d),
        &arm("d", "D", [1.3, 2.0, 0.0]),
        &hinge("C", "e", &format!("child = \"d\"\n{at_c}")),
    ]
    .concat()
}

/// Crank 1, coupler 1.5, rocker √3.77, ground 1.6; words for crank, coupler and rocker, and how the
/// last joint closes the loop.
pub fn four_bar([a, b, d]: [&str; 3], closure: &str) -> String {
    let closed = format!("child = \"rocker tip\"\n{closure}");
    [
        hinge("A", "ground", a),
        arm("crank tip", "A", [0.0, 1.0, 0.0]),
        hinge("B", "crank tip", b),
        arm("coupler tip", "B", [1.2, 1.9, 0.0]),
        arm("foot", "ground", [1.6, 0.0, 0.0]),
        hinge("D", "foot", d),
        arm("rocker tip", "D", [1.2, 1.9, 0.0]),
        hinge("C", "coupler tip", &closed),
        body("A"),
        body("B"),
        body("D"),
        ["A", "B", "D"].map(angle).concat(),
    ]
    .concat()
}

/// Angles of its coupler against the crank and of its rocker at an angle of the crank, on the branch
/// that is drawn.
pub fn linkage(crank: f64) -> [f64; 2] {
    let [[b, d], [b0, d0]] = [crank, 0.0].map(|angle| closed_form(DRAWN, FRAC_PI_2 + angle));
    [b - b0 - crank, d - d0]
}

/// The difference of two angles, whole turns aside.
pub fn apart(a: f64, b: f64) -> f64 {
    ((a - b + PI).rem_euclid(TAU) - PI).abs()
}

/// The probe of a joint's coordinate, of its name.
pub fn angle(joint: &str) -> String {
    probe_of(joint, "joint_coordinate", &format!("joint = \"{joint}\""))
}

/// What is written of a run where nobody looks at pictures.
pub const PLAIN: &str = "[output]\nfigures = false\nparaview_every = 0\n";

/// A motion in steps.
pub fn motion(to: f64, step: f64) -> String {
    format!("[analysis.dynamic]\nto = {to}\nstep = {step}\n")
}

/// A second of motion in 1000 steps, of which every tenth is a row.
pub const SECOND: &str = "[analysis.dynamic]\nto = 1.0\nstep = 0.001\n\
    scheme = { newmark = [0.25, 0.5] }\nrecord_every = 10\n\
    [output]\nfigures = false\nparaview_every = 0\n";

/// A body of mass 2 on a joint that is attached to the ground, under gravity; with more of the file.
pub fn on_joint(joint: &str, body: &str, rest: &str) -> String {
    [
        GROUND,
        &format!("[[joints]]\nname = \"joint\"\nparent = \"ground\"\n{joint}\n"),
        &body_of("joint", 2.0, body),
        GRAVITY,
        SECOND,
        &probe("position", "position", "joint"),
        rest,
    ]
    .concat()
}

/// What a run of a text in a new directory of a name prints, and its rows.
pub fn rows(name: &str, text: &str) -> (String, Rows) {
    let out = directory(name);
    write(&out, text);
    let said = printed(&out, "run model.toml");
    (said, history(&out.join("model.out")))
}

/// A model at its start.
pub fn started(text: &str) -> Job {
    let mut job = assemble_text("model.toml", text).unwrap();
    let a = vec![0.0; job.start.q.len()];
    let (t, q, v) = (0.0, &job.start.q, &job.start.v);
    job.context.configure(Point { t, q, v, a: &a }).unwrap();
    job
}

/// Coordinates of joints at the start: names with their values and rates, and the notes.
pub fn start(text: &str) -> (HashMap<String, [f64; 3]>, Vec<String>) {
    let job = started(text);
    let coordinate = |(n, s, _): (_, &str, _)| Some((s.to_owned(), job.context.coordinate(n, 0)?));
    let coordinates = job.context.joint_coordinates().filter_map(coordinate);
    (coordinates.collect(), job.context.descriptions())
}
