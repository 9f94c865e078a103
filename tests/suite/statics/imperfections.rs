//! Shapes of buckling as imperfections of another model.

use crate::support::beams::{COLUMN, PINNED, line};
use crate::support::closures::{fixed, joint};
use crate::support::prelude::*;
use crate::support::program::*;
use serde_json::Value;

fn stiff_column() -> String {
    let stiff = COLUMN.replace("1e4", "1e8");
    line(&stiff, 12, 3, &PINNED.replace("[-1,", "[-5,"))
}

const NARROW: &str = "EA = 1e7, GA = [1e7, 1e7], GJ = 0.25, EI = [1e7, 1.0]";
/// A small imperfection in the shape of buckling grows by λ/(λ_cr − λ) (Timoshenko & Gere, Theory of Elastic
/// Stability, §1.12), in displacements and in rotations: for a column, and for a cantilever whose sections turn.
#[test]
fn a_small_imperfection_grows_with_the_load() {
    let cantilever = fixed("A") + "[[loads]]\nnode = \"B\"\nforce = [0, 0, -1]\n";
    let cantilever = line(NARROW, 12, 3, &cantilever);
    // Columns that end at a link, or at a joint without any hold.
    let link = joint("B", "offset", "cap", "position = [1, 0, 0]");
    let pressed = cantilever.replace("[0, 0, -1]", "[-1, 0, 0]");
    let link = pressed.replace("\nB = ", "\ncap = ") + &link;
    let free = joint("B", "free", "A", "position = [1, 0, 0]");
    let free = pressed.replace("\nB = [1, 0, 0]", "") + &free;
    for (name, text, amplitude) in [
        ("column", stiff_column(), 1e-6),
        ("cantilever", cantilever, -1e-4),
        ("link", link, -1e-4),
        ("free", free, -1e-4),
    ] {
        let directory = directory(&format!("imperfection_{name}"));
        let buckling = format!("{text}\n[analysis.buckling]\ncount = 1\n");
        let out = ran(&directory, &buckling);
        std::fs::rename(out, directory.join("perfect")).unwrap();
        let shapes = json(directory.join("perfect/buckling.json"));
        let mode = &shapes["modes"][0];
        let nodes = mode["nodes"].as_object().unwrap();
        let three = |v: &Value| [0, 1, 2].map(|i| v[i].as_f64().unwrap());
        let lengths = nodes
            .values()
            .map(|node| Vector3::from(three(&node[0])).norm());
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
            let sizes = nodes.values().map(|node| exact(node).abs());
            let within = 1e-6 * sizes.fold(0.0, f64::max) + 1e-15;
            for (node, shape) in nodes {
                let found = three(&last[node][key])[i];
                let what = format!("{name}, {node}, {key} {i}");
                assert_close(found, exact(shape), within, what);
            }
        }
    }
}

/// Shapes of another mesh, files that are none, and modes that a file lacks.
#[test]
fn other_shapes_are_refused() {
    let directory = directory("imperfection_refused");
    let text = stiff_column();
    let mass = "stiffness = { => mass = { A_rho = 1.0, J = [0.0, 0.0, 0.0] }\\n&";
    let modes = changed(&text, mass) + "\n[analysis.modes]\ncount = 1\n";
    let shapes = ran(&directory, &modes).join("modes.json");
    let refused = |text: &str, imperfection: &str, message: &str| {
        let imperfection = imperfection.replace("FILE", &format!("{shapes:?}"));
        let text = format!("{text}\n[[imperfections]]\namplitude = 1e-3\n{imperfection}\n");
        let error = refusal(&text);
        assert_says(&error.to_string(), &[message]);
        assert!(error.span.is_some(), "{error}");
    };
    let meshed = |elements: &str| changed(&text, &format!("elements = 12 => {elements}"));
    let coarse = "there is no node named \"line/";
    refused(&meshed("elements = 6"), "shapes = FILE", coarse);
    let fine = "there is no node of the shape named \"line/36\"";
    refused(&meshed("elements = 13"), "shapes = FILE", fine);
    refused(&text, "shapes = FILE\nmode = 2", "is out of range");
    refused(&text, "shapes = FILE\nmode = 0", "is out of range");
    // An end that slides across the line.
    let mut slid = json(shapes.clone());
    let nodes = &mut slid["modes"][0]["nodes"];
    nodes["rail"] = serde_json::json!([[0, 0, 0], [0, 0, 0]]);
    nodes["B"] = serde_json::json!([[0, 0.1, 0], [0, 0, 0]]);
    let path = directory.join("slid.json");
    std::fs::write(&path, slid.to_string()).unwrap();
    let slider = joint("B", "prismatic", "rail", "axis = [0, 1, 0]");
    let sliding = text.replace("\nB = ", "\nrail = ") + &slider;
    let moved = "displaces joint \"B\" against its parent";
    refused(&sliding, &format!("shapes = {path:?}"), moved);
    let missing = "cannot read shapes from missing.json";
    refused(&text, "shapes = \"missing.json\"", missing);
    let bad = directory.join("bad.json");
    std::fs::write(&bad, "{ \"modes\": [{}] }").unwrap();
    refused(&text, &format!("shapes = {bad:?}"), "missing field `nodes`");
    // Torsion moves nodes by rounding errors.
    let torsion = "{ \"modes\": [{ \"nodes\": { \"line/1\": [[1e-17, 0, 0], [7, 0, 0]] } }] }";
    std::fs::write(&bad, torsion).unwrap();
    let message = "amplitude = 0.001 is out of range";
    refused(&text, &format!("shapes = {bad:?}"), message);
}
