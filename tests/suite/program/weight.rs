//! Weight of lines whose mass centre is beside their axis, from model files.

use crate::support::beams::line;
use crate::support::*;

/// Rows of a run with a line of length 2 along e1 from a node, with its mass centre at c = 0.2 along e2, of Aρ = 3
/// and J₁ = 0.05 per length.
fn run(name: &str, stiffness: &str, of: (usize, &str), from: &str, rest: &[&str]) -> Rows {
    let (order, interpolation) = of;
    let interpolation = format!("interpolation = \"{interpolation}\"\n");
    let mass = "[sections.main.mass]\nA_rho = 3\nJ = [0.05, 0.03, 0.02]\ncenter = [0.2, 0]\n";
    let rest = [&*interpolation, &rest.concat(), mass, GRAVITY, PLAIN].concat();
    let changes = format!("B = [1, => B = [2,\nfrom = \"A\" => from = \"{from}\"");
    recorded(name, &changed(&line(stiffness, 4, order, &rest), &changes))
}

/// Orders and interpolations of elements.
fn elements() -> impl Iterator<Item = (usize, &'static str)> {
    (1..=3).flat_map(|order| ["total", "geodesic"].map(|interpolation| (order, interpolation)))
}

#[test]
fn it_twists_a_cantilever() {
    let stiffness = "EA = 1e9, GA = [1e9, 1e9], GJ = 1e6, EI = [1e9, 1e9]";
    // GJ θ'' = Aρ g c: the weight turns its centre down.
    let exact = -3.0 * 9.81 * 0.2 * 2.0 * 2.0 / (2.0 * 1e6);
    let turn = probe("turn", "rotation", "B");
    let rest = [&*fixed("A"), "[analysis.static]\n", &turn];
    for of in elements() {
        let rows = run("weight_twists", stiffness, of, "A", &rest);
        let twist = number(rows.last().unwrap(), "turn.x");
        assert_close(twist, exact, 1e-6 * exact.abs(), format!("{of:?}"));
    }
}

#[test]
fn it_swings_a_line_about_its_axis() {
    // Let go with its centre beside its axis, ½ (J₁ + Aρ c²) ω² = Aρ g c, whatever the elements.
    let exact = f64::sqrt(2.0 * 3.0 * 9.81 * 0.2 / (0.05 + 3.0 * 0.04));
    let stiffness = "EA = 1e8, GA = [1e8, 1e8], GJ = 1e8, EI = [1e8, 1e8]";
    let held = "[[supports]]\nnode = \"B\"\nfix = [\"x\", \"y\", \"z\", \"ry\", \"rz\"]\n";
    let pivot = joint("pivot", "revolute", "A", "axis = [1, 0, 0]");
    let omega = probe("omega", "angular_velocity", "B");
    let rest = [&*fixed("A"), &pivot, held, &motion(1.0, 0.005), &omega];
    for interpolation in ["total", "geodesic"] {
        let of = (1, interpolation);
        let rows = run("weight_swings", stiffness, of, "pivot", &rest);
        let rates = rows.iter().map(|row| number(row, "omega.x").abs());
        let fastest = rates.fold(0.0, f64::max);
        assert_close(fastest, exact, 1e-3 * exact, interpolation);
    }
}

#[test]
fn what_falls_freely_does_not_turn() {
    let stiffness = "EA = 3e3, GA = [1e3, 1.2e3], GJ = 20, EI = [20, 15]";
    let v = probe("v", "velocity", "B");
    let omega = probe("omega", "angular_velocity", "B") + "component = \"norm\"\n";
    let falling = ["twist_deg = 200\n", &motion(0.5, 0.05), &v, &omega];
    for of in elements() {
        let rows = run("weight_falls", stiffness, of, "A", &falling);
        let [v, omega] = ["v.z", "omega"].map(|column| number(rows.last().unwrap(), column));
        let about = format!("{of:?}: {v} {omega:e}");
        assert_close(v, -9.81 * 0.5, 1e-10, &about);
        assert!(omega < 1e-10, "{about}");
    }
}
