//! A slide along two lines of a model file.

use crate::support::closures::{beam_line, body, fixed, probe};
use crate::support::program::{assert_close, number, recorded, run_of};
use pullback::input::assemble_text;
use pullback::manifold::system::{Point, System};
use pullback::motion::Motion;

/// A rod that turns at 2 and has no mass, and a body that is driven along it over four nodes: in the
/// rows where it lands on a node, too, its acceleration and the force on it are those of s(t) in a
/// frame that turns.
#[test]
fn a_body_on_a_rod_without_mass_is_accelerated_where_it_lands_too() {
    let rod = |name: &str, ends: [&str; 2], elements: usize| {
        beam_line(name, ends, elements, "rod") + "interpolation = \"geodesic\"\n"
    };
    let model = [
        "[nodes]\nground = [0, 0, 0]\nmiddle = [0.8, 0, 0]\nend = [2, 0, 0]\n\
         [sections.rod]\nstiffness = { EA = 1e9, GA = [1e9, 1e9], GJ = 1e8, EI = [1e8, 1e8] }\n",
        &rod("first", ["ground", "middle"], 2),
        &rod("second", ["middle", "end"], 3),
        "[[joints]]\nname = \"p\"\ntype = \"slide\"\nlines = [\"first\", \"second\"]\nstart = 0.2\n\
         prescribed = { sine = { amplitude = 0.7, omega = 4, phase = -1.5707963267948966, offset = 0.7 } }\n",
        &body("p"),
        "[[supports]]\nnode = \"ground\"\nfix = [\"x\", \"y\", \"z\", \"rx\", \"ry\"]\n\
         prescribed = { rz = { proportional = 2 } }\n\
         [[initial]]\nangular_velocity = [0, 0, 2]\nabout = [0, 0, 0]\n",
        &probe("a", "acceleration", "p"),
        &probe("f", "joint_force", "p"),
        "[output]\nfigures = false\nparaview_every = 0\n[analysis.dynamic]\nto = 0.7\nstep = 0.002\n",
    ]
    .concat();
    for scheme in ["\"radau\"", "{ generalised-alpha = 0.8 }"] {
        let mut worst = [0.0_f64; 2];
        // What has no mass comes in from accelerations of zero, which the damped scheme forgets.
        let text = format!("{model}scheme = {scheme}\n");
        let rows = recorded("program_slide_rod", &text);
        // A motion step by step tells the same force.
        let mut motion = Motion::new(assemble_text("model.toml", &text).unwrap()).unwrap();
        for row in &rows {
            let force = ["f.x", "f.y", "f.z"].map(|column| number(row, column));
            assert_eq!(motion.probe("f").unwrap(), force);
            motion.step().unwrap();
        }
        for row in rows.iter().filter(|row| number(row, "t") > 0.15) {
            let t = number(row, "t");
            let (sin, cos) = (4.0 * t).sin_cos();
            let [s, s_dot, s_ddot] = [0.9 - 0.7 * cos, 2.8 * sin, 11.2 * cos];
            let (along, across) = (s_ddot - 4.0 * s, 4.0 * s_dot);
            let (sin, cos) = (2.0 * t).sin_cos();
            let right = [along * cos - across * sin, along * sin + across * cos];
            for (worst, of) in worst.iter_mut().zip(["a", "f"]) {
                for (right, axis) in right.iter().zip(["x", "y"]) {
                    *worst = worst.max((number(row, &format!("{of}.{axis}")) - right).abs());
                }
            }
        }
        // ω² s would be missing from 1.6 to 5.6.
        assert!(worst.iter().all(|w| *w < 0.1), "{scheme}: {worst:?}");
    }
}

/// A bead on a clamped wire with a soft spring, beside the least energy over prescribed positions: within an element, and at the
/// node between two, where it is in equilibrium on neither of them.
#[test]
fn a_bead_on_a_wire_rests_within_an_element_or_at_a_node() {
    for (elements, steps, u, z) in [
        (15, 5, 1.0 / 30.0, -0.0091650),
        (15, 80, 1.0 / 30.0, -0.0091650),
        (64, 20, 0.02898, -0.009104),
        (64, 320, 0.02898, -0.009104),
    ] {
        let model = [
            "[nodes]\na = [0, 0, 0]\nb = [1, 0, 0]\n\
             [sections.s]\nstiffness = { EA = 4000, GA = [2000, 2000], GJ = 0.02, EI = [0.02, 0.02] }\n",
            &beam_line("w", ["a", "b"], elements, "s"),
            "[[joints]]\nname = \"bead\"\ntype = \"slide\"\nlines = [\"w\"]\nstart = 0.3\nspring = { k = 0.05 }\n",
            &fixed("a"),
            &fixed("b"),
            "[[loads]]\nnode = \"bead\"\nforce = [0, 0, -0.1]\n",
            &format!("[analysis.static]\nsteps = {steps}\n"),
            "[[probes]]\nname = \"u\"\nquantity = \"joint_coordinate\"\njoint = \"bead\"\n",
            &probe("x", "position", "bead"),
        ]
        .concat();
        let rows = run_of("slide_bead", &model).rows;
        let row = rows.last().unwrap();
        assert_close(number(row, "u"), u, 5e-5, elements);
        assert_close(number(row, "x.z"), z, 2e-6, elements);
    }
}

/// A load P that rolls over a simply supported beam of length L: w = P u² (L − u)²/(3 EI L).
const ROLLING: &str = r#"
[sections.main]
stiffness = { EA = 1e9, GA = [1e9, 1e9], GJ = 1e6, EI = [1e6, 1e6] }
[nodes]
A = [0, 0, 0]
B = [10, 0, 0]
[[supports]]
node = "A"
fix = ["x", "y", "z", "rx", "rz"]
[[supports]]
node = "B"
fix = ["y", "z"]
[[lines]]
name = "beam"
from = "A"
to = "B"
elements = 20
section = "main"
[[joints]]
name = "trolley"
type = "slide"
lines = ["beam"]
START
COORDINATE
[[loads]]
node = "trolley"
force = [0, 0, -1000]
time = { constant = 1 }
[analysis.ANALYSIS]
[[probes]]
name = "u"
quantity = "joint_coordinate"
joint = "trolley"
[[probes]]
name = "w"
quantity = "displacement"
node = "trolley"
component = "z"
"#;

/// There and back.
const ROLLS: [[&str; 2]; 2] = [
    ["start = 0.3", "prescribed = { proportional = 9 }"],
    ["start = 9.7", "prescribed = { table = [[0, 0], [2, -18]] }"],
];

#[test]
fn no_slide_passes_a_node_between_equal_static_points() {
    for [start, prescribed] in ROLLS {
        let model = ROLLING
            .replace("START", start)
            .replace("COORDINATE", prescribed);
        let model = model.replace("ANALYSIS", "static");
        let mut context = assemble_text("model.toml", &model).unwrap().context;
        let q = vec![0.0; context.pattern().dim()];
        let at = Point::statics(0.5, &q);
        let by = context.events().unwrap().value(at, at);
        assert_eq!(by, f64::NEG_INFINITY, "{start}");
    }
}

/// A prescribed slide passes several elements in a step, forwards and backwards, whatever its function of the load parameter.
#[test]
fn statics_follow_a_load_that_rolls_over_a_beam() {
    for (k, [start, prescribed]) in ROLLS.iter().enumerate() {
        for (j, analysis) in ["static]\nsteps = 12", "arc_length]"].iter().enumerate() {
            let model = ROLLING
                .replace("START", start)
                .replace("COORDINATE", prescribed);
            let model = model.replace("ANALYSIS]", analysis);
            let rows = recorded(&format!("rolling_{k}_{j}"), &model);
            assert!(rows.len() > 5);
            for row in &rows {
                let u = number(row, "u") + if k == 0 { 0.3 } else { 9.7 };
                let exact = -1000.0 * (u * (10.0 - u)).powi(2) / 3e7;
                // The chord of an element is below its arc.
                assert_close(number(row, "w"), exact, 2e-4, u);
            }
        }
    }
}

/// A slide on a spring k is pulled by a force F: u = F/k but for the slope of the beam.
#[test]
fn a_path_takes_a_slide_from_element_to_element() {
    let model = ROLLING.replace("START\nCOORDINATE", "start = 0.3\nspring = { k = 100 }");
    let pull = "[[loads]]\nnode = \"trolley\"\nforce = [900, 0, 0]\n[analysis.arc_length]";
    let model = model.replace("[analysis.ANALYSIS]", pull);
    let rows = recorded("rolling_freely", &model);
    for row in &rows {
        assert_close(number(row, "u"), 9.0 * number(row, "t"), 0.05, "u");
    }
}
