//! Isotropic rotors on parts that do not rotate: modes in multi-blade coordinates.

use super::{X, Y, campbell, slider};
use crate::support::*;
use nalgebra::{DMatrix, DVector, Matrix4, Rotation3, Vector3, matrix};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Lines of a Campbell diagram in multi-blade coordinates: circular frequency and damping ratio, over the speed.
fn lines(name: &str, text: &str) -> Vec<(f64, Vec<[f64; 2]>)> {
    let out = ran(&directory(name), text);
    assert_eq!(json(out.join("campbell.json"))["multi_blade"], true);
    campbell(&out)
}

/// Eigenvalues of M ẍ + C ẋ + K x = 0 with Im λ ≥ 0.
fn eigenvalues([M, C, K]: [Matrix4<f64>; 3]) -> Vec<Complex64> {
    let inverse = M.try_inverse().unwrap();
    let mut A = DMatrix::zeros(8, 8);
    A.view_mut((0, 4), (4, 4)).fill_with_identity();
    A.view_mut((4, 0), (4, 4)).copy_from(&(-inverse * K));
    A.view_mut((4, 4), (4, 4)).copy_from(&(-inverse * C));
    A.complex_eigenvalues()
        .iter()
        .copied()
        .filter(|x| x.im >= 0.0)
        .collect()
}

/// Lines are these eigenvalues, in any order.
#[track_caller]
fn assert_eigenvalues(found: &[[f64; 2]], mut exact: Vec<Complex64>, speed: f64) {
    assert_eq!(found.len(), exact.len());
    for [omega, ratio] in found {
        let off =
            |exact: &Complex64| (exact.im - omega).abs() + (exact.re / exact.norm() + ratio).abs();
        let nearest = (0..exact.len()).min_by(|&i, &j| off(&exact[i]).total_cmp(&off(&exact[j])));
        let exact = exact.swap_remove(nearest.unwrap());
        assert!(
            off(&exact) < 1e-9,
            "{omega}, {ratio} for {exact} at {speed}"
        );
    }
}

/// Blades of mass m on hinges at a distance e from the axis, their centres r further out, with springs and dampers in lag.
const M_B: f64 = 2.0;
const I_B: f64 = 0.3;
const E: f64 = 0.2;
const R: f64 = 1.5;
const K_B: f64 = 40.0;
const C_B: f64 = 0.5;
/// Mass of the support, stiffnesses and damping in two directions.
const M_S: f64 = 20.0;
const K_X: f64 = 3000.0;
const K_Y: f64 = 5000.0;
const C_X: f64 = 20.0;
const C_Y: f64 = 30.0;

fn support() -> String {
    [
        GROUND,
        &slider("surge", "ground", X, K_X, C_X),
        &slider("sway", "surge", Y, K_Y, C_Y),
        &body_of("sway", M_S, ""),
        &hinge("rotor", "sway", ""),
    ]
    .concat()
}

fn helicopter(blades: usize) -> String {
    let spring = format!("spring = {{ k = {K_B:?}, c = {C_B:?} }}");
    let blade = |b: usize| {
        let (sin, cos) = (0.7 + TAU * b as f64 / blades as f64).sin_cos();
        let (arm_name, name) = (format!("arm {b}"), format!("lag {b}"));
        let [x, y] = [R * cos, R * sin];
        let center = format!("center = [{x:?}, {y:?}, 0]\ninertia = [0.1, 0.2, {I_B:?}]");
        [
            arm(&arm_name, "rotor", [E * cos, E * sin, 0.0]),
            hinge(&name, &arm_name, &spring),
            body_of(&name, M_B, &center),
        ]
        .concat()
    };
    let analysis = format!(
        "[analysis.campbell]\njoint = \"rotor\"\nto = 20\nsteps = 4\ncount = {}\n",
        blades + 2
    );
    [support(), (0..blades).map(blade).collect(), analysis].concat()
}

/// Ground resonance (Coleman & Feingold 1958, NACA report 1351). With J = I + m r², S = m r and the cosine and sine
/// components of the lag angles, (M + N m) ẍ + … − ½ N S ζ̈ₛ = 0, (M + N m) ÿ + … + ½ N S ζ̈꜀ = 0,
/// J (ζ̈ + …)꜀ + S ÿ = 0, J (ζ̈ + …)ₛ − S ẍ = 0, where ζ̈ in multi-blade coordinates is ζ̈꜀ + 2Ω ζ̇ₛ − Ω² ζ꜀, ζ̈ₛ − 2Ω ζ̇꜀ − Ω² ζₛ.
/// Other patterns of the blades do not move the support: λ of one blade, shifted by ±ikΩ in those of k waves around the rotor.
#[test]
fn ground_resonance() {
    let of_page = changed(&example("ground_resonance"), "steps = 40 => steps = 4");
    for (blades, text) in [(3, of_page), (4, helicopter(4)), (5, helicopter(5))] {
        let mut growing = Vec::new();
        for (w, found) in lines(&format!("rotor_{blades}"), &text) {
            let (half, m) = (0.5 * blades as f64, M_S + blades as f64 * M_B);
            let (J, S) = (I_B + M_B * R * R, M_B * R);
            let k = K_B + M_B * E * R * w * w;
            let mut exact = eigenvalues([
                matrix![m, 0.0, 0.0, -half * S; 0.0, m, half * S, 0.0; 0.0, S, J, 0.0; -S, 0.0, 0.0, J],
                matrix![C_X, 0.0, 0.0, 0.0; 0.0, C_Y, 0.0, 0.0;
                        0.0, 0.0, C_B, 2.0 * w * J; 0.0, 0.0, -2.0 * w * J, C_B],
                matrix![K_X, 0.0, 0.0, 0.0; 0.0, K_Y, 0.0, 0.0;
                        0.0, 0.0, k - w * w * J, w * C_B; 0.0, 0.0, -w * C_B, k - w * w * J],
            ]);
            let blade = Complex64::new(-0.5 * C_B / J, (k / J - (0.5 * C_B / J).powi(2)).sqrt());
            // All at once, and from blade to blade.
            let mut waves = vec![0.0; 1 + (blades + 1) % 2];
            waves.extend((2..blades.div_ceil(2)).flat_map(|k| [k as f64, -(k as f64)]));
            let shifted = |k: &f64| Complex64::new(blade.re, (blade.im + k * w).abs());
            exact.extend(waves.iter().map(shifted));
            assert_eigenvalues(&found, exact, w);
            growing.extend(found.iter().any(|line| line[1] < 0.0).then_some(w));
        }
        assert_eq!(growing, [15.0, 20.0], "{blades} blades");
    }
}

/// A mass on a shaft with the same stiffness k and internal damping c in all directions, on a support that differs in two. The
/// shaft's force turns with it: k u + c (u̇ − Ω e₃ × u) for the displacement u of the mass from the support.
#[test]
fn a_shaft_on_unequal_bearings() {
    let (m, k, c) = (3.0, 1500.0, 4.0);
    let text = [
        support(),
        slider("first", "rotor", X, k, c),
        slider("second", "first", Y, k, c),
        body_of("second", m, ""),
        "[analysis.campbell]\njoint = \"rotor\"\nfrom = 5\nto = 30\nsteps = 5\ncount = 4\n"
            .to_owned(),
    ];
    for (w, found) in lines("rotor_shaft", &text.concat()) {
        let d = c * w;
        let exact = eigenvalues([
            matrix![M_S, 0.0, 0.0, 0.0; 0.0, M_S, 0.0, 0.0; 0.0, 0.0, m, 0.0; 0.0, 0.0, 0.0, m],
            matrix![C_X + c, 0.0, -c, 0.0; 0.0, C_Y + c, 0.0, -c; -c, 0.0, c, 0.0; 0.0, -c, 0.0, c],
            matrix![K_X + k, d, -k, -d; -d, K_Y + k, d, -k; -k, -d, k, d; d, -k, -d, k],
        ]);
        assert_eigenvalues(&found, exact, w);
    }
}

/// `pullback linearize` writes C in multi-blade coordinates: 2Ω M T' + C.
#[test]
fn matrices_in_multi_blade_coordinates() {
    let out = directory("rotor_matrices");
    write(&out, &helicopter(3));
    let said = succeeded(&program_in(&out, "linearize model.toml --at 15"));
    assert_says(&said, &["multi-blade"]);
    let C = matrix(&out.join("model.linear/C.mtx"));
    let names = read(out.join("model.linear/coordinates.txt"));
    let at = |blade: usize| {
        names
            .lines()
            .position(|name| name == format!("lag {blade} angle"))
    };
    // A pattern at rest in space comes to each blade from the next one: (T' z)_b = (z_{b+1} − z_{b−1}) / √3.
    let known = 2.0 * 15.0 * (I_B + M_B * R * R) / 3.0_f64.sqrt();
    for b in 0..3 {
        for (other, sign) in [((b + 1) % 3, 1.0), ((b + 2) % 3, -1.0)] {
            let found = C[(at(b).unwrap(), at(other).unwrap())];
            assert_close(found, sign * known, 1e-9, names.as_str());
        }
    }
    let refused = program_in(&out, "linearize model.toml --first-order");
    assert_says(&ended(&refused, 2), &["Leave out --first-order"]);
}

/// Six blades at rest have three patterns that do not move the support, of one frequency: three shapes, none a combination of
/// the others.
#[test]
fn shapes_of_one_frequency_are_independent() {
    let text = helicopter(6);
    let text = text[..text.find("[analysis").unwrap()].to_owned() + "[analysis.modes]\ncount = 8\n";
    let out = ran(&directory("rotor_shapes"), &text);
    let all = json(out.join("modes.json"));
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        let numbers = value.as_array().unwrap().iter();
        numbers.map(|x| x.as_f64().unwrap()).collect()
    };
    let J = I_B + M_B * R * R;
    let blade = (K_B / J - (0.5 * C_B / J).powi(2)).sqrt();
    let same = |mode: &&serde_json::Value| (numbers(&mode["eigenvalue"])[1] - blade).abs() < 1e-9;
    let shapes = all["modes"].as_array().unwrap().iter().filter(same);
    let shapes: Vec<DVector<Complex64>> = shapes
        .map(|mode| {
            let [re, im] = [0, 1].map(|k| numbers(&mode["shape"][k]));
            let shape = DVector::from_fn(re.len(), |k, _| Complex64::new(re[k], im[k]));
            shape.normalize()
        })
        .collect();
    assert_eq!(shapes.len(), 3);
    let least = DMatrix::from_columns(&shapes).singular_values().min();
    assert!(least > 1e-3, "{least:e}");
}

/// Three blades on a hub that tilts on a universal joint, which no third of a turn maps but with both its angles together, written
/// with six digits: a turn of the rotor changes no equation.
#[test]
fn a_gimbal_with_six_digits() {
    let hub = "axis = [1, 0, 0]\nsecond_axis = [0, 1, 0]\ncoordinates = { \"angle 1\" = { spring = { k = 900 } }, \
               \"angle 2\" = { spring = { k = 900 } } }";
    let gimbal = joint("gimbal", "universal", "rotor", hub);
    let blades = [[1.0, 0.0], [-0.5, 0.866025], [-0.5, -0.866025]];
    let blade = |(b, [x, y]): (usize, [f64; 2])| {
        let (arm_name, name) = (format!("arm {b}"), format!("flap {b}"));
        let axis = format!("axis = [{y}, {}, 0]\nspring = {{ k = 70 }}", -x);
        let center = format!("center = [{}, {}, 0]", R * x, R * y);
        [
            arm(&arm_name, "gimbal", [E * x, E * y, 0.5]),
            joint(&name, "revolute", &arm_name, &axis),
            body_of(&name, M_B, &center),
        ]
        .concat()
    };
    let blades: String = blades.into_iter().enumerate().map(blade).collect();
    let analysis = "[analysis.campbell]\njoint = \"rotor\"\nto = 10\nsteps = 2\ncount = 7\n";
    let rows = lines(
        "rotor_gimbal",
        &[&support(), &gimbal, &blades, analysis].concat(),
    );
    assert!(rows.iter().all(|(_, found)| found.len() == 7));
}

/// Two blades have periodic coefficients on any support, as have unequal ones, also in multi-blade coordinates; gravity moves
/// blades periodically.
#[test]
fn periodic_rotors_are_refused() {
    let three = helicopter(3);
    let heavier = three.replacen(&format!("mass = {M_B:?}"), "mass = 2.01", 1);
    assert_ne!(heavier, three);
    let gravity = "[[loads]]\ngravity = [0, -1, 0]\ntime = { constant = 1 }\n";
    for (name, text) in [
        ("rotor_2", helicopter(2)),
        ("rotor_unequal", heavier),
        ("rotor_gravity", format!("{gravity}{three}")),
    ] {
        let said = failed(name, &text);
        assert_says(&said, &["less than three equal blades", "Floquet"]);
    }
}

/// Blades on flap and lag hinges with struts to the hub: springs along the line between two points, or loops of joints with two
/// independent coordinates in each blade.
#[test]
fn loops_of_joints_on_a_rotor() {
    let blade = |b: usize, closure: Option<&str>| {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), TAU * b as f64 / 3.0);
        let point = |x: [f64; 3]| turn * Vector3::from(x);
        let three = |x: Vector3<f64>| <[f64; 3]>::from(x);
        let axis = |x: Vector3<f64>| format!("axis = {:?}\n", three(x));
        let [a, c] = [point([0.1, 0.25, 0.0]), point([0.8, 0.1, 0.1])];
        let [name, flap, lag, from, to] =
            ["blade", "flap", "lag", "from", "to"].map(|n| format!("{n} {b}"));
        let along = (c - a).normalize();
        let first = along.cross(&Vector3::z()).normalize();
        let both = axis(first) + "second_" + &axis(along.cross(&first));
        let strut = match closure {
            None => format!(
                "[[springs]]\nname = \"strut {b}\"\nnodes = [\"{from}\", \"{to}\"]\nstiffness = 500\ndamping = 3\n"
            ),
            Some(closure) => {
                let [start, slide, end] = ["start", "slide", "end"].map(|n| format!("{n} {b}"));
                let spring = "coordinates = { displacement = { spring = { k = 500, c = 3 } } }";
                let close = format!("{both}child = \"{end}\"\n{closure}");
                [
                    joint(&start, "universal", &from, &both),
                    joint(&slide, "cylindrical", &start, &(axis(along) + spring)),
                    arm(&end, &slide, c.into()),
                    joint(&format!("close {b}"), "universal", &to, &close),
                ]
                .concat()
            }
        };
        let spring = axis(point([0.0, -1.0, 0.0])) + "spring = { k = 40, c = 0.1 }";
        let center = three(point([1.5, 0.0, 0.1]));
        let body = format!("center = {center:?}\ninertia = [0.1, 0.1, 0.1]");
        [
            arm(&name, "rotor", point([0.3, 0.0, 0.0]).into()),
            joint(&flap, "revolute", &name, &spring),
            hinge(&lag, &flap, "spring = { k = 20 }"),
            body_of(&lag, 3.0, &body),
            arm(&to, &lag, c.into()),
            arm(&from, "rotor", a.into()),
            strut,
        ]
        .concat()
    };
    let text = |closure: Option<&str>| {
        let blades: String = (0..3).map(|b| blade(b, closure)).collect();
        let analysis =
            "[analysis.campbell]\njoint = \"rotor\"\nfrom = 3\nto = 25\nsteps = 2\ncount = 8\n";
        [&support(), &blades[..], analysis].concat()
    };
    let springs = lines("rotor_struts", &text(None));
    for closure in ["closure = \"map\"", "closure = \"multipliers\""] {
        let found = lines("rotor_loops", &text(Some(closure)));
        for ((speed, found), (_, exact)) in found.iter().zip(&springs) {
            for (found, exact) in found.iter().flatten().zip(exact.iter().flatten()) {
                assert_close(*found, *exact, 1e-6, *speed);
            }
        }
    }
}
