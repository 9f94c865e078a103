//! The formulations of a comparison against exact motions and against each other.
#![allow(non_snake_case, clippy::unwrap_used)]

use nalgebra::{Rotation3, Vector3};
use pullback::compare::{Comparison, Options, Quantity, Watch, compare};
use pullback::input;
use pullback::method::Method;

/// A free symmetrical body: moments of inertia 2, 2 and 1.
const BODY: &str = r#"
[nodes]
O = [0, 0, 0]
[[bodies]]
name = "body"
node = "O"
mass = 1
inertia = [2, 2, 1]
[[initial]]
node = "O"
rotation = [0.4, -0.9, 0.6]
body_angular_velocity = [3, 0, 4]
velocity = [1, 0, 0]
[analysis.dynamic]
to = 2
step = 0.01
"#;

const METHODS: [&str; 6] = [
    "newmark",
    "ul-newmark",
    "ul-bathe",
    "lie-ga:0.8",
    "lie-hht:-0.1",
    "spin-newmark",
];

fn compared(text: &str, methods: &[&str], steps: &[f64]) -> Comparison {
    let file = input::parse("model.toml", text).unwrap();
    let make = |formulation| input::job_in("model.toml", &file, formulation);
    let methods = methods.iter().map(|m| m.parse().unwrap()).collect();
    let options = Options::new(methods, steps.to_vec());
    compare(&make, "model.toml", &options, &Watch::NOBODY).unwrap()
}

#[test]
fn a_free_body_precesses_in_every_formulation_with_order_two() {
    let steps = [0.02, 0.01, 0.005, 0.0025];
    let comparison = compared(BODY, &METHODS, &steps);
    // Landau & Lifshitz, Mechanics, section 33: about the fixed angular momentum with |L|/J₁, about
    // its own axis with Ω₃ (1 − J₃/J₁); all of it turned by R₀.
    let turned = Rotation3::new(Vector3::new(0.4, -0.9, 0.6));
    let exact = |t: f64| {
        let precession = Rotation3::new(Vector3::new(3.0, 0.0, 2.0) * t);
        let spin = Rotation3::new(Vector3::z() * (2.0 * t));
        (turned * precession * spin).into_inner()
    };
    for method in METHODS {
        let errors: Vec<f64> = (comparison.of(method))
            .map(|row| {
                assert_eq!(row.failure, None, "{method}");
                let s = row.samples.last().unwrap();
                (s.nodes[0].R - exact(2.0)).norm()
            })
            .collect();
        for (pair, h) in errors.windows(2).zip(&steps) {
            let slope = (pair[0] / pair[1]).log2();
            assert!((slope - 2.0).abs() < 0.1, "{method} at {h}: {errors:?}");
        }
    }
    for orders in &comparison.orders {
        for quantity in [Quantity::Rotation, Quantity::Velocity] {
            if let Some(order) = orders.of(quantity) {
                let name = &orders.scheme;
                assert!((order.order - 2.0).abs() < 0.1, "{name}: {order:?}");
            }
        }
    }
}

#[test]
fn spin_vectors_are_the_lie_group_method_with_newmarks_coefficients() {
    let comparison = compared(BODY, &["spin-newmark", "lie-newmark"], &[0.02, 0.01]);
    let [spin, lie] = ["spin-newmark", "lie-newmark"].map(|m| comparison.of(m).next().unwrap());
    for (a, b) in spin.samples.iter().zip(&lie.samples) {
        assert_eq!(a.nodes[0].R, b.nodes[0].R);
    }
}

#[test]
fn words_that_no_formulation_takes_are_refused_by_name() {
    for (word, says) in [
        ("lie-radau", "one stage"),
        ("spin-ga:0.8", "newmark"),
        ("ul-nothing", "ul-nothing"),
        ("lie-", "there are"),
    ] {
        let error = word.parse::<Method>().unwrap_err().to_string();
        assert!(error.contains(says) && error.contains(word), "{error}");
    }
}
