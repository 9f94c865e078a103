//! Parameters by path, and sweeps over them.

use crate::support::*;
use pullback::input::{assemble_text, with_parameters};
use std::f64::consts::TAU;
use std::path::Path;

/// A cantilever with a small force at its tip.
const CANTILEVER: &str = r#"
supports = [{ node = "root", fix = "all" }]
probes = [{ name = "tip", quantity = "displacement", node = "tip", component = "z" }]
[sections.rod] # steel
stiffness = { EA = 1e6, GA = [4e5, 5e5], GJ = 1.0, EI = [2.0, 3.0] }
[nodes]
root = [0, 0, 0] # held
tip = [2, 0, 0]
[[lines]]
name = "beam"
from = "root"
to = "tip"
elements = 4
order = 2
section = "rod"
[[loads]]
node = "tip"
force = [0, 0, 1e-6]
"#;

fn written(name: &str) -> std::path::PathBuf {
    let directory = directory(name);
    std::fs::write(directory.join("beam.toml"), CANTILEVER).unwrap();
    directory
}

/// The table of a sweep without its wall-clock times.
fn table(path: &Path) -> Vec<Vec<String>> {
    let text = read(path);
    let cells = |line: &str| line.split(',').map(str::to_owned).collect();
    let mut rows: Vec<Vec<String>> = text.lines().map(cells).collect();
    let seconds = rows[0].iter().position(|name| name == "seconds").unwrap();
    rows.iter_mut().for_each(|row| drop(row.remove(seconds)));
    rows
}

#[test]
fn a_parameter_is_a_key_an_entry_or_a_part_by_name() {
    let with = |path: &str, value: &str| with_parameters(CANTILEVER, [(path, value)]).unwrap();
    for (path, value, line) in [
        ("loads.0.force.2", "-500", "force = [0, 0, -500]"),
        ("lines.beam.elements", "7", "elements = 7"),
        ("nodes.root", "[1, 0, 0]", "root = [1, 0, 0] # held"),
        ("sections.rod.stiffness.EI.1", "9.5", "EI = [2.0, 9.5] }"),
        ("lines.0.section", "other", "section = \"other\""),
    ] {
        let text = with(path, value);
        assert_says(&text, &[line, "# steel"]);
    }
    // What is missing is added.
    let text = with("analysis.static.max_step", "0.5");
    let file = assemble_text("beam.toml", &text).unwrap().file;
    let analysis = serde_json::to_value(&file.analysis).unwrap();
    assert_eq!(analysis["static"]["max_step"], 0.5);
}

#[test]
fn unknown_parameters_are_refused_with_those_there_are() {
    let directory = written("parameters_refused");
    check_lines(
        &directory,
        "run beam.toml --set",
        r#"
loads.7.force.2=1 | loads has no 7 | `0`
lines.bean.elements=5 | lines has no bean | did you mean `beam`?
sections.rid.damping=5 | sections has no rid | did you mean `rod`?
nodes.tap=[0,0,0] | nodes has no tap | did you mean `tip`?
loads.0.forc.2=1 | unknown key or word `forc` | did you mean `force`?
loads.0.force.2.1=1 | loads.0.force.2 has no 1
loads.0=1 | loads.0 is a whole part of the model
a..b=1 | "a..b" is not the path of a parameter | such as loads.0.force.2
lines.0.elements=many | invalid type | a whole number
=1 | is not the path
loads | give PATH=VALUE
"#,
    );
    assert!(!directory.join("beam.out").exists());
}

/// A small deflection is P L³/3EI + P L/GA (Timoshenko): over two stiffnesses, in one thread and in two; and as a run
/// with the same parameters.
#[test]
fn a_sweep_is_a_row_for_each_run() {
    let directory = written("sweep_rows");
    let over = "--over sections.rod.stiffness.EI.0=linspace(1,3,3) \
                --over loads.0.force.2=[1e-6,2e-6] --keep last,max,min,at(0.5)";
    for (workers, out) in [(1, "one"), (2, "two")] {
        let line = format!("sweep beam.toml {over} --workers {workers} --out {out}");
        succeeded(&program_in(&directory, &line));
    }
    let rows = table(&directory.join("one/sweep.csv"));
    assert_eq!(rows, table(&directory.join("two/sweep.csv")));
    let head = "run,sections.rod.stiffness.EI.0,loads.0.force.2,outcome,t,\
                tip.last,tip.max,tip.min,tip.at(0.5),warnings";
    assert_eq!(rows[0].join(","), head);
    assert_eq!(rows.len(), 7);
    let runs = ["1.0", "2.0", "3.0"].map(|stiffness| ["1e-6", "2e-6"].map(|f| [stiffness, f]));
    for (k, [stiffness, force]) in runs.into_iter().flatten().enumerate() {
        let row = &rows[k + 1];
        let head = [&k.to_string(), stiffness, force, "complete", "1.0"];
        assert_eq!(row[..5], head);
        let [stiffness, force]: [f64; 2] = [stiffness, force].map(|x| x.parse().unwrap());
        let exact = force * (8.0 / (3.0 * stiffness) + 2.0 / 5e5);
        for (found, exact) in row[5..].iter().zip([exact, exact, 0.0, 0.5 * exact]) {
            let found = found.parse().unwrap();
            assert_close(found, exact, 1e-9 * force, row.join(","));
        }
    }
    let set = "--set sections.rod.stiffness.EI.0=3.0 --set loads.0.force.2=2e-6";
    succeeded(&program_in(&directory, &format!("run beam.toml {set}")));
    let last = history(&directory.join("beam.out")).pop().unwrap();
    assert_eq!(number(&last, "tip"), rows[6][5].parse::<f64>().unwrap());
}

/// A soft spring that snaps through beyond 2/(3√3) = 0.385: statics ends on an unstable branch far away, and says so.
#[test]
fn a_sweep_has_the_warnings_of_its_runs() {
    let directory = directory("sweep_warnings");
    let model = r#"
[nodes]
g = [0, 0, 0]
[[supports]]
node = "g"
fix = "all"
[[joints]]
name = "j"
type = "prismatic"
parent = "g"
axis = [1, 0, 0]
spring = { k = 1, k3 = -1 }
[[loads]]
node = "j"
force = [0.5, 0, 0]
[analysis.static]
[[probes]]
name = "x"
quantity = "joint_coordinate"
joint = "j"
"#;
    std::fs::write(directory.join("soft.toml"), model).unwrap();
    let line = "sweep soft.toml --over loads.0.force.0=[0.3,0.5]";
    let said = succeeded(&program_in(&directory, line));
    assert_says(
        &said,
        &[
            "1 of 2 runs with warnings, the first one, run 1",
            "unstable",
        ],
    );
    let rows = read(directory.join("soft.sweep/sweep.csv"));
    let lines: Vec<&str> = rows.lines().collect();
    assert!(lines[1].ends_with(','), "{rows}");
    assert!(lines[2].contains("unstable in 1 direction"), "{rows}");
}

/// Runs that fail or are refused are rows; a sweep that was stopped, within a line, makes the rows that are missing.
#[test]
fn a_stopped_sweep_goes_on() {
    let directory = written("sweep_goes_on");
    let line = "sweep beam.toml --over lines.0.elements=[1,2,0,3,4] --quiet";
    let said = succeeded(&program_in(&directory, line));
    assert_says(&said, &["1 of 5 runs did not end as planned"]);
    let path = directory.join("beam.sweep/sweep.csv");
    let whole = read(&path);
    let rows = table(&path);
    assert!(whole.contains("elements = 0 is out of range"), "{whole}");
    let kept: Vec<&str> = whole.lines().take(3).collect();
    std::fs::write(&path, format!("{}\n2,0,\"cut", kept.join("\n"))).unwrap();
    succeeded(&program_in(&directory, line));
    assert_eq!(table(&path), rows);
    // What was kept is not run again.
    assert!(read(&path).starts_with(&kept.join("\n")));
    let other = line.replace("3,4]", "3,5]");
    let said = ended(&program_in(&directory, &other), 2);
    assert_says(&said, &["holds another sweep", "--out"]);
    assert_eq!(table(&path), rows);
}

#[test]
fn sweeps_are_refused_before_the_first_run() {
    let directory = written("sweep_refused");
    check_lines(
        &directory,
        "sweep beam.toml",
        "
 | --over
--over lines.0.element=[1] | did you mean `elements`?
--over lines.1.elements=[1] | lines has no 1
--over lines.0.elements | a parameter is PATH=VALUES
--over lines.0.elements=linspace(1,2) | a range is linspace(FROM,TO,COUNT)
--over lines.0.elements=geomspace(-1,2,3) | both ends of geomspace have one sign
--over lines.0.elements=linspace(1,2,0) | a whole number from 1
--over lines.0.elements=linspace(1,1e400,3) | a finite number
--over lines.0.elements=7 | values are linspace(FROM,TO,COUNT)
--over lines.0.elements=[1] --keep mean | last, max, min or at(T)
--over lines.0.elements=[1] --workers 0 | --workers
--over lines.0.elements=[] | a parameter has one value or more
--over lines.0.elements=[1] --over lines.beam.elements=[2] | lines.0.elements and lines.beam.elements give one parameter two values
--over loads.0.force=[[0,0,1]] --over loads.0.force.2=[2] | give one parameter two values
--over nodes.tip.0=linspace(1,2,10000) --over nodes.tip.1=linspace(1,2,10000) | at most 10000000 runs
",
    );
    assert!(!directory.join("beam.sweep").exists());
}

/// The first frequencies in the rows of a sweep of a model over the values of a parameter.
fn frequencies(name: &str, model: &str, over: &str) -> Vec<f64> {
    let directory = directory(name);
    write(&directory, model);
    let line = format!("sweep model.toml --over {over}");
    succeeded(&program_in(&directory, &line));
    let rows = table(&directory.join("model.sweep/sweep.csv"));
    let last = rows[0].len() - 3;
    assert_eq!(rows[0][last..][..2], ["frequency_1", "damping_ratio_1"]);
    let found = rows[1..].iter().map(|row| row[last].parse().unwrap());
    found.collect()
}

/// The first frequency of a slender cantilever over its stiffness: 3.516015 √(EI/m)/L².
#[test]
fn frequencies_of_a_sweep() {
    let mass = "mass = { A_rho = 1.0, J = [1e-9, 1e-9, 1e-9] }\n";
    let text = CANTILEVER.replace("stiffness = {", &format!("{mass}stiffness = {{"));
    let text = format!("{text}\n[analysis.modes]\ncount = 1\n");
    let over = "sections.rod.stiffness.EI.0=[0.01,0.04] --set lines.0.elements=16";
    let exact = [0.01_f64, 0.04].map(|EI| 3.516015268500151 * EI.sqrt() / 4.0 / TAU);
    let found = frequencies("sweep_modes", &text, over);
    assert_eq!(found.len(), exact.len());
    for (found, exact) in found.iter().zip(exact) {
        assert_close(found / exact, 1.0, 1e-4, exact);
    }
}

/// Flap of a rotating blade of mass 2 over its spring, at the last speed: ω² = k/(m r²) + Ω² (1 + e/r).
#[test]
fn frequencies_at_the_last_speed_of_a_sweep() {
    let flap = "axis = [0, 1, 0]\nspring = { k = 10 }";
    let text = [
        GROUND,
        &hinge("hub", "ground", ""),
        &arm("arm", "hub", [0.5, 0.0, 0.0]),
        &joint("flap", "revolute", "arm", flap),
        &body_of("flap", 2.0, "center = [0.8, 0, 0]"),
        "[analysis.campbell]\njoint = \"hub\"\nto = 10\nsteps = 2\ncount = 1\n",
    ];
    let over = "joints.flap.spring.k=[10,20]";
    let found = frequencies("sweep_campbell", &text.concat(), over);
    assert_eq!(found.len(), 2);
    for (found, k) in found.iter().zip([10.0, 20.0]) {
        let square: f64 = k / (2.0 * 0.64) + 100.0 * (1.0 + 0.5 / 0.8);
        assert_close(*found, square.sqrt() / TAU, 1e-9, k);
    }
}
