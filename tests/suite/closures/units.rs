//! Models in the units of micromachines and of ships: the same motion at the same steps. Closed loops with
//! multipliers as with the map, and linkages where kinematics has them.

use crate::support::beams::line;
use crate::support::closures::{
    angle, arm, beam_line, body_of, fixed, hinge, joint, motion, probe,
};
use crate::support::program::{example, number, recorded};
use toml::{Table, Value};

/// A metre, a kilogram and a second in other units.
type Units = [f64; 3];

const SI: Units = [1.0; 3];
const OTHERS: [Units; 9] = [
    // mm, t, s
    [1e3, 1e-3, 1.0],
    // nm, pg, µs
    [1e9, 1e15, 1e6],
    // µm, kg, s and km, kg, s
    [1e6, 1.0, 1.0],
    [1e-3, 1.0, 1.0],
    // Gm, kg, s and nm, kg, s
    [1e-9, 1.0, 1.0],
    [1e9, 1.0, 1.0],
    // Masses alone, and atoms.
    [1.0, 1e-18, 1.0],
    [1.0, 1e30, 1.0],
    [1e10, 1e27, 1e15],
];

/// What the numbers behind a key are multiplied by.
fn factor(key: &str, [L, M, T]: Units) -> f64 {
    let F = M * L / (T * T);
    match key {
        "position" | "center" | "through" | "start" => L,
        "mass" => M,
        "inertia" => M * L * L,
        "A_rho" => M / L,
        "J" => M * L,
        "EA" | "GA" | "force" => F,
        "GJ" | "EI" => F * L * L,
        "gravity" => L / (T * T),
        "to" | "step" | "end" | "duration" => T,
        "rate" => 1.0 / T,
        // Damping in proportion to stiffness.
        "stiffness" => T,
        _ => 1.0,
    }
}

/// A value as it stands in a file, its numbers times a factor that the keys inside may replace.
fn print(value: &Value, times: f64, units: Units) -> String {
    match value {
        Value::Integer(x) if times == 1.0 => x.to_string(),
        Value::Integer(x) => format!("{:e}", *x as f64 * times),
        Value::Float(x) => format!("{:e}", x * times),
        Value::Array(all) => {
            let all = all.iter().map(|v| print(v, times, units));
            format!("[{}]", all.collect::<Vec<_>>().join(", "))
        }
        Value::Table(all) => {
            let entry = |(key, v): (&String, &Value)| {
                // What is in a table has factors of its own.
                let own = match v.is_table() {
                    true => 1.0,
                    false => factor(key, units),
                };
                format!("{key:?} = {}", print(v, times * own, units))
            };
            let all: Vec<String> = all.iter().map(entry).collect();
            format!("{{ {} }}", all.join(", "))
        }
        Value::String(text) => format!("{text:?}"),
        other => format!("{other:?}"),
    }
}

/// Steps of a run: time in seconds, linear solutions, and what is asked for.
#[derive(Debug)]
struct Step {
    t: f64,
    iterations: f64,
    found: Vec<f64>,
}

/// A model's run in some units.
fn run(name: &str, model: &Table, columns: &[&str], units: Units) -> Vec<Step> {
    let entry = |(key, v): (&String, &Value)| match key.as_str() {
        // Their keys are names.
        "nodes" => format!("nodes = {}\n", print(v, units[0], SI)),
        _ => format!("{key:?} = {}\n", print(v, 1.0, units)),
    };
    let text: String = model.iter().map(entry).collect();
    let rows = recorded(&format!("units-closures-{name}"), &text);
    let step = |row: &_| Step {
        t: number(row, "t") / units[2],
        iterations: number(row, "iterations"),
        found: columns.iter().map(|c| number(row, c)).collect(),
    };
    rows.iter().map(step).collect()
}

/// Runs a model in all units and compares steps, linear solutions (as many but for a part of them) and what
/// has no unit; then hands out the steps in SI.
fn compare_within(part: f64, name: &str, model: &Table, columns: &[&str]) -> Vec<Step> {
    let total = |steps: &[Step]| steps.iter().map(|s| s.iterations).sum::<f64>();
    let expected = run(name, model, columns, SI);
    for units in OTHERS {
        let steps = run(name, model, columns, units);
        assert_eq!(steps.len(), expected.len(), "{name} {units:?}");
        for (step, expected) in steps.iter().zip(&expected) {
            let pairs = step.found.iter().zip(&expected.found);
            let gap = pairs.fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs()));
            assert!(gap < 1e-12, "{name} {units:?}: {gap:.1e} at t = {}", step.t);
        }
        let [more, all] = [total(&steps), total(&expected)];
        let alike = (more - all).abs() <= part * all;
        assert!(alike, "{name} {units:?}: {more}, not {all}");
    }
    let moves = |step: &Step| step.found.iter().any(|x| x.abs() > 1e-3);
    assert!(expected.last().is_some_and(moves), "{name} moves");
    expected
}

/// Residuals of flexible loops are about as large as their rounding errors at the end.
fn compare(name: &str, model: &Table, columns: &[&str]) -> Vec<Step> {
    compare_within(0.1, name, model, columns)
}

/// A model with probes of joints, with all else as it is.
fn with_probes(text: &str, joints: &[&str]) -> Table {
    let probes: String = joints.iter().map(|joint| angle(joint)).collect();
    format!("{text}{probes}").parse().unwrap()
}

/// A model of the gallery for some damped time, its loop closed at the child of a joint by a word, and
/// the angles of joints as its only probes.
fn shortened(text: &str, child: &str, closure: &str, to: &str, joints: &[&str]) -> Table {
    let start = text.find("[[probes]]").unwrap();
    let mut model = text[..start]
        .replace(child, &format!("{child}\nclosure = {closure:?}"))
        .replace(
            "scheme = { newmark = [0.25, 0.5] }",
            "scheme = { generalised-alpha = 0.8 }",
        )
        .replace("record_every = 5", "");
    let from = model.rfind("\nto = ").unwrap();
    let end = from + 1 + model[from + 1..].find('\n').unwrap();
    model.replace_range(from..end, &format!("\nto = {to}"));
    with_probes(&model, joints)
}

#[test]
fn a_structure_and_a_mechanism_take_the_same_iterations_in_all_units() {
    let rest = fixed("A")
        + "[[loads]]\nnode = \"B\"\nforce = [0, 2.0, 1.0]\n[analysis.static]\nsteps = 4\n"
        + &probe("tip", "rotation", "B");
    let stiffness = "EA = 1e4, GA = [4e3, 4e3], GJ = 1.0, EI = [1.5, 1.0]";
    let text = line(stiffness, 8, 1, &rest);
    let columns = ["tip.x", "tip.y", "tip.z"];
    compare_within(0.0, "cantilever", &text.parse().unwrap(), &columns);
    let text = example("double_pendulum");
    let (model, _) = text.split_once("[[probes]]").unwrap();
    let model = with_probes(&model.replace("to = 2", "to = 0.4"), &["hip", "hinge"]);
    compare_within(0.0, "double pendulum", &model, &["hip", "hinge"]);
}

#[test]
fn a_slider_crank_is_where_its_crank_says() {
    let text = example("slider_crank").replace("step = 0.001", "step = 0.004");
    let joints = ["crank", "rod", "wrist"];
    for closure in ["multipliers", "map"] {
        let model = shortened(&text, "child = \"slider\"", closure, "0.16", &joints);
        for step in compare("slider-crank", &model, &joints) {
            let [crank, rod, wrist] = step.found[..] else {
                panic!()
            };
            // A crank of 0.4 and a rod of 1, which the slider does not turn with.
            let turned = -(0.4 * crank.sin()).asin();
            let gap = (crank + rod - turned).abs().max((wrist + turned).abs());
            assert!(gap < 1e-12, "{closure}: {gap:.1e} at t = {}", step.t);
        }
    }
}

#[test]
fn flexible_linkages_move_alike_in_all_units() {
    let [misaligned, crank] = ["four_bar_misaligned", "slider_crank_flexible"].map(example);
    for closure in ["multipliers", "map"] {
        let joints = ["axis B", "axis D"];
        let child = "child = \"tip of bar 3\"";
        let model = shortened(&misaligned, child, closure, "0.16", &joints);
        compare("misaligned", &model, &joints);
        let joints = ["rod", "wrist"];
        let model = shortened(&crank, "child = \"rod end\"", closure, "0.04", &joints);
        compare("flexible rod", &model, &joints);
    }
}

#[test]
fn a_beam_on_a_pin_bends_alike_in_all_units() {
    let text = [
        "[sections.s]\nstiffness = { EA = 1e5, GA = [1e5, 1e5], GJ = 10.0, EI = [10.0, 10.0] }\n\
         [nodes]\nroot = [0, 0, 0]\nend = [2, 0, 0]\npin = [2, 0, 0]\n",
        &beam_line("beam", ["root", "end"], 8, "s"),
        &hinge("hinge", "pin", "child = \"end\"\nclosure = \"multipliers\""),
        &["root", "pin"].map(fixed).concat(),
        "[[loads]]\nnode = \"beam/4\"\nforce = [0, -10.0, 0]\n",
        &probe("middle", "rotation", "beam/4"),
    ]
    .concat();
    let found = ["multipliers", "map"].map(|closure| {
        let model = with_probes(&text.replace("multipliers", closure), &["hinge"]);
        let columns = ["hinge", "middle.z"];
        compare("pin", &model, &columns).pop().unwrap().found
    });
    let [forces, map] = &found;
    for (a, b) in forces.iter().zip(map) {
        assert!((a - b).abs() < 1e-10, "{a}, with the map {b}");
    }
}

#[test]
fn a_jump_of_a_prescribed_rate_turns_a_pendulum_alike_in_all_units() {
    let text = [
        "[nodes]\ncentre = [0, 0, 0]\nbob = [1, 0, 0]\n",
        &fixed("centre"),
        &hinge("crank", "centre", "prescribed = { ramp = { end = 0.2 } }"),
        &arm("tip", "crank", [1.0, 0.0, 0.0]),
        &hinge("pin", "tip", "child = \"bob\"\nclosure = \"multipliers\""),
        &body_of(
            "bob",
            2.0,
            "center = [0.5, 0, 0]\ninertia = [0.1, 0.1, 0.1]",
        ),
        &motion(0.3, 0.001),
    ];
    let model = with_probes(&text.concat(), &["pin"]);
    let steps = compare("jump", &model, &["pin"]);
    // The impulse F at the pin: m (v + r ω) = F and I ω = −r F, for v = 5 of the tip.
    let omega = -5.0 * 2.0 * 0.5 / (0.1 + 2.0 * 0.25);
    let turned = steps[1].found[0] / steps[1].t;
    assert!((turned / (omega - 5.0) - 1.0).abs() < 1e-3, "{turned}");
}

/// A cantilever from rest under its weight, with damping in proportion to stiffness, and a pendulum whose only nodes are at its
/// hinge, with steps of any size.
#[test]
fn dampers_and_steps_are_alike_in_all_units() {
    let weight = "[[loads]]\ngravity = [0, -10.0, 0]\n";
    let text = [
        "[sections.s]\nstiffness = { EA = 1e4, GA = [4e3, 4e3], GJ = 10.0, EI = [10.0, 10.0] }\n\
         mass = { A_rho = 1.0, J = [2e-3, 1e-3, 1e-3] }\ndamping = { stiffness = 1e-3 }\n\
         [nodes]\nroot = [0, 0, 0]\nend = [2, 0, 0]\n",
        &beam_line("beam", ["root", "end"], 8, "s"),
        &fixed("root"),
        weight,
        &probe("end", "rotation", "end"),
        &motion(0.1, 0.002),
    ];
    compare_within(0.0, "damped", &text.concat().parse().unwrap(), &["end.z"]);
    let text = [
        "[nodes]\nground = [0, 0, 0]\n",
        &fixed("ground"),
        &hinge("swing", "ground", ""),
        &body_of(
            "swing",
            2.0,
            "center = [0.5, 0, 0]\ninertia = [0.1, 0.1, 0.1]",
        ),
        weight,
        &motion(0.5, 0.01),
        "adaptive = { tolerance = 1e-4 }\n",
    ];
    let model = with_probes(&text.concat(), &["swing"]);
    compare_within(0.0, "one place", &model, &["swing"]);
}

/// A crank whose pin slides in a curved slot of an arm: the parameter of the curve is a length.
#[test]
fn a_pin_in_a_slot_moves_alike_in_all_units() {
    let slot = "through = [[0.2, -0.5, 0], [0.45, -0.1, 0], [0.6, 0.2, 0], [0.7, 0.6, 0], [0.7, 1.0, 0]]\n\
         start = 0.8071092532277988\nchild = \"pin\"\nclosure = \"multipliers\"";
    let turning = "center = [0.3, 0.1, 0]\ninertia = [0.1, 0.1, 0.1]";
    let text = [
        "[nodes]\nground = [0, 0, 0]\nfoot = [0, -1.2, 0]\n",
        &["ground", "foot"].map(fixed).concat(),
        &hinge("crank", "ground", "rate = 2.0"),
        &arm("pin", "crank", [0.6, 0.2, 0.0]),
        &hinge("arm", "foot", ""),
        &joint("slot", "on_curve", "arm", slot),
        &["crank", "arm"].map(|n| body_of(n, 2.0, turning)).concat(),
        "[[loads]]\ngravity = [0, -10.0, 0]\n",
        &motion(0.2, 0.01),
        "adaptive = { tolerance = 1e-4 }\nscheme = \"ga:0.8\"\n",
    ]
    .concat();
    let joints = ["crank", "arm"];
    for closure in ["multipliers", "map"] {
        let model = with_probes(&text.replace("multipliers", closure), &joints);
        compare("slot", &model, &joints);
    }
}
