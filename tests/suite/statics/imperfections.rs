//! Shapes of buckling as imperfections of another model.

#![allow(clippy::unwrap_used)]

use crate::support::beams::{COLUMN, PINNED, line};
use crate::support::program::{directory, ran, read, refusal, results};
use serde_json::Value;

fn stiff_column() -> String {
    let stiff = COLUMN.replace("1e4", "1e8");
    line(&stiff, 12, 3, &PINNED.replace("[-1,", "[-5,"))
}

const NARROW: &str = "EA = 1e7, GA = [1e7, 1e7], GJ = 0.25, EI = [1e7, 1.0]";
const CANTILEVER: &str = r#"
    [[supports]]
    node = "A"
    fix = "all"
    [[loads]]
    node = "B"
    force = [0, 0, -1]
"#;

/// A small imperfection in the shape of buckling grows by λ/(λ_cr − λ) (Timoshenko & Gere, Theory of Elastic
/// Stability, §1.12), in displacements and in rotations: for a column, and for a cantilever whose sections turn.
#[test]
fn a_small_imperfection_grows_with_the_load() {
    for (name, text, amplitude) in [
        ("column", stiff_column(), 1e-6),
        ("cantilever", line(NARROW, 12, 3, CANTILEVER), -1e-4),
    ] {
        let directory = directory(&format!("imperfection_{name}"));
        let out = ran(
            &directory,
            &format!("{text}\n[analysis.buckling]\ncount = 1\n"),
        );
        std::fs::rename(out, directory.join("perfect")).unwrap();
        let shapes: Value =
            serde_json::from_str(&read(directory.join("perfect/buckling.json"))).unwrap();
        let mode = &shapes["modes"][0];
        let nodes = mode["nodes"].as_object().unwrap();
        let three = |v: &Value| [0, 1, 2].map(|i| v[i].as_f64().unwrap());
        let lengths = nodes
            .values()
            .map(|node| three(&node[0]).map(|x| x * x).iter().sum::<f64>().sqrt());
        let largest = lengths.fold(0.0, f64::max);
        let imperfection = format!(
            "[[imperfections]]\nshapes = \"perfect/buckling.json\"\namplitude = {amplitude:?}\n"
        );
        let last = &results(&ran(&directory, &format!("{text}\n{imperfection}")))["last"]["nodes"];
        let growth = amplitude / largest / (mode["load"].as_f64().unwrap() - 1.0);
        // Deflection across the plane of the load, and the rotations that belong to it.
        for (key, k, i) in [
            ("displacement", 0, 1),
            ("rotation", 1, 0),
            ("rotation", 1, 2),
        ] {
            let exact = |node: &Value| growth * three(&node[k])[i];
            let size = nodes
                .values()
                .map(|node| exact(node).abs())
                .fold(0.0, f64::max);
            for (node, shape) in nodes {
                let error = three(&last[node][key])[i] - exact(shape);
                let bound = 1e-6 * size + 1e-15;
                assert!(
                    error.abs() < bound,
                    "{name}, {node}, {key} {i}: {error:e} of {size:e}"
                );
            }
        }
    }
}

/// Shapes of another mesh, files that are none, and modes that a file lacks.
#[test]
fn other_shapes_are_refused() {
    let directory = directory("imperfection_refused");
    let text = stiff_column();
    let out = ran(
        &directory,
        &format!("{text}\n[analysis.modes]\ncount = 1\n").replace(
            "stiffness = {",
            "mass = { A_rho = 1.0, J = [0.0, 0.0, 0.0] }\nstiffness = {",
        ),
    );
    let shapes = out.join("modes.json");
    let refused = |text: &str, imperfection: &str, message: &str| {
        let imperfection = imperfection.replace("FILE", &format!("{shapes:?}"));
        let text = format!("{text}\n[[imperfections]]\namplitude = 1e-3\n{imperfection}\n");
        let error = refusal(&text);
        assert!(error.to_string().contains(message), "{error}");
        assert!(error.span.is_some(), "{error}");
    };
    let coarse = text.replace("elements = 12", "elements = 6");
    let fine = text.replace("elements = 12", "elements = 13");
    refused(&coarse, "shapes = FILE", "there is no node named \"line/");
    refused(
        &fine,
        "shapes = FILE",
        "there is no node of the shape named \"line/36\"",
    );
    refused(&text, "shapes = FILE\nmode = 2", "is out of range");
    refused(&text, "shapes = FILE\nmode = 0", "is out of range");
    refused(
        &text,
        "shapes = \"missing.json\"",
        "cannot read shapes from missing.json",
    );
    let bad = directory.join("bad.json");
    std::fs::write(&bad, "{ \"modes\": [{}] }").unwrap();
    refused(&text, &format!("shapes = {bad:?}"), "missing field `nodes`");
}
