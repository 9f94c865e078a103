//! Loops that are closed by multipliers, in the units of micromachines and of ships: the same angles
//! at the same steps.
#![allow(non_snake_case, clippy::unwrap_used)]

mod program_support;

use program_support::{directory, history, number, program, write};
use toml::{Table, Value};

/// A metre, a kilogram and a second in other units.
type Units = [f64; 3];

const OTHERS: [Units; 7] = [
    [1e-9, 1.0, 1.0],
    [1e-6, 1.0, 1.0],
    [1e9, 1.0, 1.0],
    [1.0, 1e-18, 1.0],
    [1.0, 1e30, 1.0],
    [1e6, 1e15, 1e6],
    [1e-3, 1e-6, 1.0],
];

/// What the numbers behind a key are multiplied by.
fn factor(key: &str, [L, M, T]: Units) -> f64 {
    let F = M * L / (T * T);
    match key {
        "place" | "center" => L,
        "mass" => M,
        "inertia" => M * L * L,
        "A_rho" => M / L,
        "J" => M * L,
        "EA" | "GA" | "force" => F,
        "GJ" | "EI" => F * L * L,
        "gravity" => L / (T * T),
        "to" | "step" | "end" | "duration" => T,
        "rate" => 1.0 / T,
        _ => 1.0,
    }
}

/// A value as it stands in a file, its numbers times a factor that the keys inside may replace.
fn print(value: &Value, times: f64, units: Units) -> String {
    let list = |all: Vec<String>| all.join(", ");
    match value {
        Value::Integer(x) if times == 1.0 => x.to_string(),
        Value::Integer(x) => format!("{:e}", *x as f64 * times),
        Value::Float(x) => format!("{:e}", x * times),
        Value::Array(all) => {
            let all = all.iter().map(|v| print(v, times, units)).collect();
            format!("[{}]", list(all))
        }
        Value::Table(all) => {
            let entry = |(key, v): (&String, &Value)| {
                let mut times = times;
                // What is in a table has factors of its own.
                if !v.is_table() {
                    times *= factor(key, units);
                }
                format!("{key:?} = {}", print(v, times, units))
            };
            format!("{{ {} }}", list(all.iter().map(entry).collect()))
        }
        Value::String(text) => format!("{text:?}"),
        other => format!("{other:?}"),
    }
}

/// The last row of a model's run in some units: the columns named.
fn last(name: &str, model: &Table, columns: &[&str], units: Units) -> Vec<f64> {
    let entry = |(key, v): (&String, &Value)| {
        match key.as_str() {
            // Their keys are names.
            "nodes" => format!("nodes = {}\n", print(v, units[0], [1.0; 3])),
            _ => format!("{key:?} = {}\n", print(v, 1.0, units)),
        }
    };
    let text: String = model.iter().map(entry).collect();
    let out = directory(&format!("units-closures-{name}"));
    let ran = program(&[&write(&out, &text)]);
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{name} {units:?}: {said}");
    let rows = history(&out.join("model.out"));
    let row = rows.last().unwrap();
    columns.iter().map(|c| number(row, c)).collect()
}

/// Runs a model in all units and compares what has none.
fn compare(name: &str, text: &str, columns: &[&str]) {
    let model: Table = text.parse().unwrap();
    let expected = last(name, &model, columns, [1.0; 3]);
    assert!(expected.iter().any(|x| x.abs() > 1e-3), "{name} moves");
    for units in OTHERS {
        let found = last(name, &model, columns, units);
        for ((found, expected), column) in found.iter().zip(&expected).zip(columns) {
            let gap = (found - expected).abs();
            assert!(
                gap < 1e-7,
                "{name} {units:?}, {column}: {found}, not {expected}"
            );
        }
    }
}

/// A model of the gallery with the child of a joint held by multipliers, for forty damped steps, and
/// the angles of joints as its only probes.
fn by_multipliers(text: &str, child: &str, to: &str, joints: &[&str]) -> String {
    let start = text.find("[[probes]]").unwrap();
    let mut model = text[..start]
        .replace(child, &format!("{child}\nclosure = \"multipliers\""))
        .replace(
            "scheme = { newmark = [0.25, 0.5] }",
            "scheme = { generalised-alpha = 0.8 }",
        )
        .replace("record_every = 5", "");
    let from = model.rfind("\nto = ").unwrap();
    let end = from + 1 + model[from + 1..].find('\n').unwrap();
    model.replace_range(from..end, &format!("\nto = {to}"));
    for joint in joints {
        model += &format!(
            "[[probes]]\nname = \"{joint}\"\nquantity = \"joint_coordinate\"\njoint = \"{joint}\"\n"
        );
    }
    model
}

#[test]
fn linkages_move_alike_in_all_units() {
    let four_bar = include_str!("../examples/models/four_bar.toml");
    let joints = ["A", "B", "C", "D"];
    let model = by_multipliers(four_bar, "child = \"rocker tip\"", "0.04", &joints);
    compare("four-bar", &model, &joints);

    let misaligned = include_str!("../examples/models/four_bar_misaligned.toml");
    let joints = ["axis B", "axis D"];
    let model = by_multipliers(misaligned, "child = \"tip of bar 3\"", "0.16", &joints);
    compare("misaligned", &model, &joints);

    let crank = include_str!("../examples/models/slider_crank_flexible.toml");
    let joints = ["rod", "wrist"];
    let model = by_multipliers(crank, "child = \"rod end\"", "0.04", &joints);
    compare("slider-crank", &model, &joints);
}

#[test]
fn a_beam_on_a_pin_bends_alike_in_all_units() {
    let model = r#"
[sections.s]
stiffness = { EA = 1e5, GA = [1e5, 1e5], GJ = 10.0, EI = [10.0, 10.0] }
[nodes]
root = [0, 0, 0]
end = [2, 0, 0]
pin = [2, 0, 0]
[[lines]]
name = "beam"
from = "root"
to = "end"
elements = 8
section = "s"
[[joints]]
name = "hinge"
type = "revolute"
master = "pin"
axis = [0, 0, 1]
child = "end"
closure = "multipliers"
[[supports]]
node = "root"
fix = "all"
[[supports]]
node = "pin"
fix = "all"
[[loads]]
node = "beam/4"
force = [0, -10.0, 0]
[[probes]]
name = "hinge"
quantity = "joint_coordinate"
joint = "hinge"
[[probes]]
name = "middle"
quantity = "rotation"
node = "beam/4"
"#;
    compare("pin", model, &["hinge", "middle.z"]);
}
