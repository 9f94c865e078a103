//! Points on curves and surfaces of model files, against closed forms.

use crate::support::*;
use std::f64::consts::PI;

/// A body on a joint that the ground bears, under gravity along −z: x, y, z at the times of all rows.
fn run(name: &str, joint: &str, gravity: f64, [to, step]: [f64; 2]) -> Vec<[f64; 4]> {
    let changes =
        format!("-9.81 => -{gravity}\nto = 1.0 => to = {to}\nstep = 0.001 => step = {step}");
    let text = changed(&model(joint), &changes);
    let rows = recorded(&format!("program_shapes_{name}"), &text);
    let columns = ["t", "position.x", "position.y", "position.z"];
    let numbers = |row| columns.map(|column| number(row, column));
    rows.iter().map(numbers).collect()
}

fn model(joint: &str) -> String {
    changed(
        &on_joint(joint, "inertia = [0.03, 0.03, 0.03]", ""),
        "ground = [0, 0, 0] => ground = [0.5, 0.25, -1]\nrecord_every = 10\\n =>",
    )
}

/// A position is this one.
#[track_caller]
fn near(t: f64, found: [f64; 3], exact: [f64; 3], within: f64) {
    for (found, exact) in found.into_iter().zip(exact) {
        assert_close(found, exact, within, t);
    }
}

#[test]
fn a_bead_on_a_straight_wire_falls_with_a_part_of_gravity() {
    // Along (3, 0, −4)/5 from its end, or a quarter of the way, by its arc length; the points are not evenly spaced.
    let wire = "type = \"on_curve\"\n\
                through = [[0, 0, 0], [0.6, 0, -0.8], [0.9, 0, -1.2], [6, 0, -8]]\nrate = 1.5\nstart =";
    for start in [0.0, 2.5] {
        for [t, x, y, z] in run("wire", &format!("{wire} {start}"), 10.0, [1.0, 0.05]) {
            let s = start + 1.5 * t + 0.5 * 8.0 * t * t;
            near(t, [x, y, z], [0.6 * s, 0.0, -0.8 * s], 1e-12);
        }
    }
}

#[test]
fn a_bead_on_a_ring_is_at_the_bottom_after_a_quarter_of_its_period() {
    // A ring of radius 1 through 60 points, let go beside its centre. The quarter of the period is
    // K(1/√2) √(r/g) with K(1/√2) = Γ(1/4)²/(4 √π) = 1.8540746773013719; a spline is off by about
    // the fourth power of the angle between two points over 384.
    let points = (0..60).map(|k| 2.0 * PI * f64::from(k) / 60.0);
    let points: Vec<_> = points
        .map(|a| format!("[{:?}, 0, {:?}]", a.cos(), a.sin()))
        .collect();
    let joint = format!(
        "type = \"on_curve\"\nclosed = true\nthrough = [{}]",
        points.join(", ")
    );
    let quarter = 1.854_074_677_301_372 / 9.81_f64.sqrt();
    let rows = run("ring", &joint, 9.81, [5.0 * quarter, quarter / 400.0]);
    for [t, x, y, z] in &rows {
        assert_close((x * x + y * y + z * z).sqrt(), 1.0, 1e-6, t);
    }
    for quarters in [1, 5] {
        let [_, x, _, z] = rows[400 * quarters];
        assert!(x.abs() < 1e-4 && z < 0.0, "after {quarters} quarters: {x}");
    }
}

#[test]
fn a_point_on_a_cylinder_falls_and_goes_round() {
    // About the vertical axis through (1, 2): radius 2, one radian per second.
    let joint = "type = \"on_surface\"\nposition = [3, 2, 5]\n\
                 surface = { cylinder = { center = [1, 2, 0], axis = [0, 0, 7] } }\n\
                 coordinates = { \"parameter 1\" = { rate = 1.0 } }";
    for [t, x, y, z] in run("cylinder", joint, 10.0, [2.0, 0.1]) {
        let exact = [1.0 + 2.0 * t.cos(), 2.0 + 2.0 * t.sin(), 5.0 - 5.0 * t * t];
        near(t, [x, y, z], exact, 1e-11);
    }
}

#[test]
fn a_point_on_a_sphere_circles_as_a_conical_pendulum() {
    // 30° off the bottom of a sphere of radius 2 it stays at its height with ω² = g/(r cos 30°).
    let (r, angle) = (2.0_f64, PI / 6.0);
    let position = [r * angle.sin(), 0.0, -r * angle.cos()];
    let omega = (9.81 / (r * angle.cos())).sqrt();
    let joint = format!(
        "type = \"on_surface\"\nposition = {position:?}\nsurface = {{ sphere = {{ center = [0, 0, 0] }} }}\n\
         coordinates = {{ \"parameter 2\" = {{ rate = {:?} }} }}",
        omega * angle.sin()
    );
    let period = 2.0 * PI / omega;
    let rows = run("sphere", &joint, 9.81, [period, period / 800.0]);
    for [t, x, y, z] in &rows {
        assert_close(x.hypot(*y), position[0], 1e-4, t);
        assert_close(*z, position[2], 1e-4, t);
    }
    let [t, x, y, _] = rows[400];
    near(t, [x, y, 0.0], [-position[0], 0.0, 0.0], 1e-4);
}

#[test]
fn a_point_on_a_plane_slides_down_it() {
    // A slope of 45°: half of gravity along x.
    let joint = "type = \"on_surface\"\nposition = [0, 0, 1]\n\
                 surface = { plane = { normal = [1, 0, 1] } }";
    for [t, x, y, z] in run("plane", joint, 10.0, [1.0, 0.1]) {
        let way = 2.5 * t * t;
        near(t, [x, y, z], [way, 0.0, 1.0 - way], 1e-12);
    }
}

#[test]
fn curves_and_surfaces_that_are_none_are_refused() {
    check_table(
        &model("type = \"weld\""),
        refusal,
        r#"
type = "weld" => type = "on_curve"\nthrough = [[0, 0, 0]] | [[joints]] | 2 points at least, got 1
 => type = "on_curve"\nthrough = [[0, 0, 0], [1, 0, 0]]\nclosed = true | [[joints]] | 3 points
 => type = "on_curve"\nthrough = [[0, 0, 0], [1, 0, 0]]\nstart = 1.5 | [[joints]] | between 0 and 1
 => type = "on_curve"\nthrough = [[0, 0, 0], [1, 0, 0], [1, 0, 0]] | [[joints]] | point 3 of its curve
 => type = "on_surface"\nposition = [0, 0, 1]\nsurface = { sphere = { center = [0, 0, 1] } } | [[joints]] | there is no radius
 => type = "on_surface"\nposition = [0, 0, 1]\nsurface = { cylinder = { center = [0, 0, 5], axis = [0, 0, 1] } } | [[joints]] | there is no radius
"#,
    );
}
