//! A body that slides over the corner of a free chain: what it gives the chain it loses.
#![allow(clippy::unwrap_used)]

use crate::support::program::{number, recorded};

fn chain(step: f64) -> String {
    format!(
        r#"
[sections.rod]
stiffness = {{ EA = 1e5, GA = [1e5, 1e5], GJ = 1e4, EI = [1e4, 1e4] }}
mass = {{ A_rho = 1, J = [2e-2, 1e-2, 1e-2] }}

[nodes]
a = [0, 0, 0]
b = [1, 0.1, 0]
c = [2, 0.4, 0.1]

[[lines]]
name = "first"
from = "a"
to = "b"
elements = 2
section = "rod"

[[lines]]
name = "second"
from = "b"
to = "c"
elements = 2
section = "rod"

[[joints]]
name = "bead"
type = "slide"
lines = ["first", "second"]
start = 0.7
rate = 2.0

[[bodies]]
name = "bead"
node = "bead"
mass = 1.0
inertia = [0.01, 0.02, 0.03]

[analysis.dynamic]
to = 0.4
step = {step}

[output]
figures = false
paraview_every = 0

[[probes]]
name = "p"
quantity = "momentum"

[[probes]]
name = "L"
quantity = "angular_momentum"

[[probes]]
name = "way"
quantity = "joint_coordinate"
joint = "bead"
"#
    )
}

#[test]
fn momentum_is_kept_where_a_slide_is_handed_over() {
    let mut drifts = Vec::new();
    for (k, step) in [2e-3, 1e-3, 5e-4].into_iter().enumerate() {
        let rows = recorded(&format!("program_slide_{k}"), &chain(step));
        let columns = |name: &str| ["x", "y", "z"].map(|axis| format!("{name}.{axis}"));
        let change = |name: &str| {
            let largest = |column: &String| {
                let first = number(&rows[0], column);
                let apart = rows.iter().map(|r| (number(r, column) - first).abs());
                apart.fold(0.0_f64, f64::max)
            };
            columns(name).iter().map(largest).fold(0.0_f64, f64::max)
        };
        // It has passed the corner at 1.005 and the middle of the second line.
        assert!(number(rows.last().unwrap(), "way") > 0.6);
        drifts.push([change("p"), change("L")]);
    }
    // The corner turns the bead's momentum of 2 by 0.4; the chain must take that. What is left
    // is the error of the steps, and that of up to v h on the extension of the element that it
    // leaves.
    for k in 0..2 {
        let [coarse, _, fine] = [drifts[0][k], drifts[1][k], drifts[2][k]];
        assert!(coarse < 2e-2, "{drifts:?}");
        assert!(fine < 0.5 * coarse, "{drifts:?}");
    }
}

/// A rod that turns at 2 and has no mass, and a body that is driven along it over four nodes: in the
/// rows where it lands on a node, too, its acceleration and the force on it are those of s(t) in a
/// frame that turns.
#[test]
fn a_body_on_a_rod_without_mass_is_accelerated_where_it_lands_too() {
    let model = r#"
[nodes]
ground = [0, 0, 0]
end = [2, 0, 0]

[sections.rod]
stiffness = { EA = 1e9, GA = [1e9, 1e9], GJ = 1e8, EI = [1e8, 1e8] }

[[lines]]
name = "rod"
from = "ground"
to = "end"
elements = 5
section = "rod"
interpolation = "geodesic"

[[joints]]
name = "p"
type = "slide"
lines = ["rod"]
start = 0.2
prescribed = { sine = { amplitude = 0.7, omega = 4, phase = -1.5707963267948966, offset = 0.7 } }

[[bodies]]
name = "b"
node = "p"
mass = 1
inertia = [0.1, 0.1, 0.1]

[[supports]]
node = "ground"
fix = ["x", "y", "z", "rx", "ry"]
prescribed = { rz = { proportional = 2 } }

[[initial]]
line = "rod"
angular_velocity = [0, 0, 2]
about = [0, 0, 0]

[[probes]]
name = "a"
quantity = "acceleration"
node = "p"

[[probes]]
name = "f"
quantity = "joint_force"
node = "p"

[output]
figures = false
paraview_every = 0

[analysis.dynamic]
to = 0.7
step = 0.002
"#;
    for (k, scheme) in ["\"radau\"", "{ generalised-alpha = 0.8 }"]
        .iter()
        .enumerate()
    {
        let mut worst = [0.0_f64; 2];
        // What has no mass comes in from accelerations of zero, which the damped scheme forgets.
        let rows = recorded(
            &format!("program_slide_rod_{k}"),
            &format!("{model}scheme = {scheme}\n"),
        );
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
