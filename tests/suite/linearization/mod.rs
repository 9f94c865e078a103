//! Linearised equations of motion and their modes.

mod beams;
mod buckling;
mod campbell;
mod flutter;
mod inputs;
mod linkages;
mod rotors;
mod small;
mod state_space;

use crate::support::{csv, joint};
use std::f64::consts::TAU;
use std::path::Path;

/// Lines of the Campbell diagram that a run leaves: circular frequency and damping ratio, over the speed.
fn campbell(out: &Path) -> Vec<(f64, Vec<[f64; 2]>)> {
    let row = |cells: Vec<f64>| {
        let lines = cells[1..].chunks(2).map(|pair| [TAU * pair[0], pair[1]]);
        (cells[0], lines.collect())
    };
    let rows = csv(out.join("campbell.csv"));
    rows.into_iter().map(row).collect()
}

const X: [u8; 3] = [1, 0, 0];
const Y: [u8; 3] = [0, 1, 0];

/// A prismatic joint along an axis with a spring and a damper.
fn slider(name: &str, parent: &str, axis: [u8; 3], k: f64, c: f64) -> String {
    let keys = format!("axis = {axis:?}\nspring = {{ k = {k:?}, c = {c:?} }}");
    joint(name, "prismatic", parent, &keys)
}

#[track_caller]
fn assert_near(found: f64, exact: f64, tolerance: f64) {
    assert!((found / exact - 1.0).abs() < tolerance, "{found} {exact}");
}
