//! The laboratory of integrators on the models of the gallery: what is exact, how loops hold, and what
//! a general solver costs.
#![allow(non_snake_case, clippy::unwrap_used)]

use nalgebra::Vector3;
use pullback::compare::{
    CompareError, Comparison, Contender, Exact, Options, Quantity, Sample, Watch, compare,
    looked_at, read_exact,
};
use pullback::input::{self, Analysis, ModelFile};
use pullback::method::Method;
use std::path::Path;

fn model(name: &str) -> ModelFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let text = std::fs::read_to_string(path.join(name)).unwrap();
    input::parse(name, &text).unwrap()
}

fn until(mut file: ModelFile, to: f64) -> ModelFile {
    match &mut file.analysis {
        Analysis::Dynamic(d) => d.to = to,
        _ => panic!("no motion"),
    }
    file
}

fn options(words: &[&str], steps: &[f64]) -> Options {
    let schemes = words.iter().map(|w| w.parse().unwrap());
    Options::new(schemes.collect(), steps.to_vec())
}

fn compared(file: &ModelFile, options: &Options) -> Result<Comparison, CompareError> {
    let make = |formulation| input::job_in("model.toml", file, formulation);
    compare(&make, "model.toml", options, &Watch::NOBODY)
}

/// Angle and rate of the pendulum from rest at the horizontal, from the lowest place: a quarter turn
/// of Jacobi's elliptic functions, k = sin 45°, by the descending Landen transformation.
fn pendulum(t: f64) -> [f64; 2] {
    let (k, omega) = (0.5_f64.sqrt(), 9.81_f64.sqrt());
    // sin(θ/2) = k cd(ωt): sn at K − u.
    let (mut a, mut b) = (vec![1.0_f64], (1.0 - k * k).sqrt());
    let mut c = vec![k];
    while c.last().unwrap().abs() > 1e-16 {
        let last = *a.last().unwrap();
        c.push(0.5 * (last - b));
        a.push(0.5 * (last + b));
        b = (last * b).sqrt();
    }
    let n = a.len() - 1;
    let K = std::f64::consts::FRAC_PI_2 / a[n];
    let u = K - omega * t;
    let mut phi = 2.0_f64.powi(n as i32) * a[n] * u;
    for i in (1..=n).rev() {
        phi = 0.5 * (phi + (c[i] / a[i] * phi.sin()).asin());
    }
    let (sn, cn) = phi.sin_cos();
    [2.0 * (k * sn).asin(), -2.0 * k * omega * cn]
}

/// Place and velocity of its bob, which begins at −e1.
fn bob(sample: &mut Sample) {
    let [theta, rate] = pendulum(sample.t);
    let (sin, cos) = theta.sin_cos();
    // The node of the joint comes first, then that of the rod.
    let rod = sample.nodes.len() - 1;
    sample.nodes[rod].place = Vector3::new(-sin, 0.0, -cos);
    sample.nodes[rod].velocity = Vector3::new(-cos, 0.0, sin) * rate;
    sample.energy = 0.0;
    sample.gross_energy = 1.0;
}

#[test]
fn an_exact_solution_takes_the_place_of_the_reference() {
    let file = until(model("pendulum.toml"), 2.0);
    let steps = [0.02, 0.01, 0.005];
    let words = ["newmark", "em", "radau"];
    let by_reference = compared(&file, &options(&words, &steps)).unwrap();
    let exactly = Options {
        exact: Some(Exact::new("Jacobi's elliptic functions", bob)),
        ..options(&words, &steps)
    };
    let comparison = compared(&file, &exactly).unwrap();
    let reference = comparison.reference.as_ref().unwrap();
    assert_eq!((reference.evaluations, reference.steps), (0, [0.0; 3]));
    for (word, order) in [("newmark", 2.0), ("em", 2.0), ("radau", 3.0)] {
        let orders = comparison.orders.iter().find(|o| o.scheme == word).unwrap();
        let found = orders.of(Quantity::Position).unwrap().order;
        assert!((found - order).abs() < 0.1, "{word}: {found}");
        // Nothing is said of what is not known.
        assert!(orders.of(Quantity::Rotation).is_none());
        let rows = by_reference.of(word).zip(comparison.of(word));
        for (estimated, exact) in rows {
            let error = |row: &pullback::compare::Row, q| row.error.unwrap().of(q);
            assert!(error(exact, Quantity::Rotation).is_nan());
            // Of the energy there is one value in a model, for both.
            let [a, b] = [estimated, exact].map(|row| error(row, Quantity::Energy));
            assert!((a - b).abs() <= 1e-8 + 0.01 * a, "{word}: {a:e} {b:e}");
        }
    }
    let kept = comparison.of("em").next().unwrap().drift.energy.unwrap();
    let lost = comparison
        .of("newmark")
        .next()
        .unwrap()
        .drift
        .energy
        .unwrap();
    assert!(kept < 1e-13 && lost > 1e-5, "{kept:e} {lost:e}");
}

#[test]
fn an_exact_solution_comes_from_a_file() {
    let file = until(model("pendulum.toml"), 1.0);
    let make = |formulation| input::job_in("model.toml", &file, formulation);
    let steps = [0.02, 0.01];
    let (nodes, times) = looked_at(&make, &steps).unwrap();
    let path = std::env::temp_dir().join(format!("pullback_exact_{}.csv", std::process::id()));
    let write = |head: &str, rows: &[f64]| {
        let mut text = head.to_owned() + "\n";
        for &t in rows {
            let [theta, _] = pendulum(t);
            text += &format!("{t:e},{:e},0,{:e}\n", -theta.sin(), -theta.cos());
        }
        std::fs::write(&path, text).unwrap();
        read_exact(&path, &nodes, &times)
    };
    let head = "t,rod.place.x,rod.place.y,rod.place.z";
    let exact = write(head, &times).unwrap();
    let asked = Options {
        exact: Some(exact),
        ..options(&["newmark", "radau"], &steps)
    };
    let comparison = compared(&file, &asked).unwrap();
    for (word, order) in [("newmark", 2.0), ("radau", 3.0)] {
        let orders = comparison.orders.iter().find(|o| o.scheme == word).unwrap();
        let found = orders.of(Quantity::Position).unwrap().order;
        assert!((found - order).abs() < 0.2, "{word}: {found}");
    }
    for (head, rows, said) in [
        (
            "t,bob.place.x,rod.place.y,rod.place.z",
            &times[..],
            "no node `bob`",
        ),
        (
            "t,rod.place.x,rod.place.y,rod.height",
            &times[..],
            "is none of t, energy",
        ),
        (
            "x,rod.place.x,rod.place.y,rod.place.z",
            &times[..],
            "`x` is none of t",
        ),
        (head, &times[..10], "there is no row for t ="),
    ] {
        let error = write(head, rows).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn residuals_of_loops_are_tabulated() {
    let linkage = |closure: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/four_bar.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let text = text.replace("child = ", &format!("{closure}\nchild = "));
        let file = until(input::parse("four_bar.toml", &text).unwrap(), 0.2);
        let comparison = compared(&file, &options(&["ga:0.8", "radau"], &[0.02, 0.01])).unwrap();
        let rows = comparison.rows.iter();
        rows.map(|row| {
            assert_eq!(row.failure, None, "{closure}, {}", row.scheme);
            row.drift.violation.unwrap()
        })
        .fold(0.0, f64::max)
    };
    // What Newton's method leaves, and the compliance of the penalty, with forces of order 10.
    assert!(linkage("") < 1e-11);
    assert!(linkage("closure = \"multipliers\"") < 1e-9);
    let [soft, stiff] =
        ["1e5", "1e6"].map(|p| linkage(&format!("closure = \"penalty\"\npenalty = {p}")));
    assert!((0.05..0.2).contains(&(stiff / soft)), "{soft:e} {stiff:e}");
    // A model without loops has none.
    let file = until(model("pendulum.toml"), 0.1);
    let comparison = compared(&file, &options(&["newmark"], &[0.02, 0.01])).unwrap();
    assert!(
        comparison
            .rows
            .iter()
            .all(|row| row.drift.violation.is_none())
    );
}

#[test]
fn momenta_that_are_zero_in_a_plane_are_no_merit() {
    // The pendulum swings about e2: its momentum has no component there, its angular momentum no other one.
    let file = until(model("pendulum.toml"), 0.5);
    let comparison = compared(&file, &options(&["newmark", "em"], &[0.02, 0.01])).unwrap();
    let zero = [[false, true, false], [true, false, true]];
    assert_eq!(comparison.zero_momenta, zero);
    let kept = comparison.reference.as_ref().unwrap().kept;
    assert!(kept.momentum[1] && kept.angular_momentum[0]);
    for row in &comparison.rows {
        assert_eq!(
            (row.drift.momentum, row.drift.angular_momentum),
            (None, None)
        );
        assert!(row.drift.energy.is_some());
    }
    // A free body in space has no such component.
    let file = until(model("free_body.toml"), 0.1);
    let comparison = compared(&file, &options(&["newmark"], &[0.004, 0.002])).unwrap();
    assert_eq!(comparison.zero_momenta, [[true; 3], [false; 3]]);
    assert!(comparison.rows[0].drift.angular_momentum.is_some());
}

#[test]
fn every_model_in_motion_can_be_compared() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let mut names: Vec<String> = std::fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let mut seen = 0;
    for name in names {
        let mut file = model(&name);
        let Analysis::Dynamic(d) = &mut file.analysis else {
            continue;
        };
        seen += 1;
        let step = d.step;
        d.to = d.to.min(4.0 * step);
        let asked = options(&["em:0.8", "bathe", "ga:0.8"], &[2.0 * step, step]);
        let comparison = compared(&file, &asked).unwrap();
        assert_eq!(comparison.reference_failure, None, "{name}");
        for row in &comparison.rows {
            assert_eq!(row.failure, None, "{name}, {}", row.scheme);
            let error = row.error.unwrap();
            assert!(error.0.iter().all(|e| e.is_finite()), "{name}: {error:?}");
        }
    }
    assert!(seen >= 20, "{seen}");
}

#[test]
fn words_make_what_is_compared() {
    let method: Contender = " lie-ga:0.8".parse().unwrap();
    assert_eq!(
        method,
        Contender::Method("lie-ga:0.8".parse::<Method>().unwrap())
    );
    assert_eq!(method.order(), Some(2));
    let unknown = "diffsol-euler"
        .parse::<Contender>()
        .unwrap_err()
        .to_string();
    assert!(
        unknown.contains("diffsol-bdf and diffsol-esdirk"),
        "{unknown}"
    );
    let known = "diffsol-bdf".parse::<Contender>();
    if cfg!(feature = "diffsol") {
        assert_eq!(known.unwrap().order(), None);
        let with: Contender = "diffsol-esdirk:0.00001".parse().unwrap();
        assert_eq!(with.to_string(), "diffsol-esdirk:0.00001");
        for word in ["diffsol-bdf:2", "diffsol-bdf:x", "diffsol-bdf:"] {
            assert!(word.parse::<Contender>().is_err(), "{word}");
        }
    } else {
        let said = known.unwrap_err().to_string();
        assert!(said.contains("--features diffsol"), "{said}");
    }
}

#[cfg(feature = "diffsol")]
mod general {
    use super::*;

    const WORDS: [&str; 2] = ["diffsol-bdf:1e-6", "diffsol-esdirk:1e-6"];

    #[test]
    fn a_general_solver_swings_the_pendulum() {
        let file = until(model("pendulum.toml"), 2.0);
        let asked = Options {
            exact: Some(Exact::new("Jacobi's elliptic functions", bob)),
            ..options(&WORDS, &[0.04, 0.02, 0.01])
        };
        let comparison = compared(&file, &asked).unwrap();
        for word in WORDS {
            let name = word.parse::<Contender>().unwrap().to_string();
            let rows: Vec<_> = comparison.of(&name).collect();
            assert_eq!(rows.len(), 3);
            for row in &rows {
                assert_eq!(row.failure, None, "{word}");
                assert_eq!(row.samples.len(), comparison.times + 1);
                let c = &row.counts;
                assert!(c.steps > 20 && c.iterations >= c.steps, "{c:?}");
                assert!(
                    c.evaluations > c.iterations && c.factorisations > c.steps,
                    "{c:?}"
                );
            }
            let errors: Vec<f64> = rows
                .iter()
                .map(|r| r.error.unwrap().of(Quantity::Position))
                .collect();
            // The tolerance falls to a sixteenth: local errors do, the global ones about.
            assert!(
                errors[0] < 1e-3 && errors[2] < 0.25 * errors[0],
                "{word}: {errors:?}"
            );
            assert!(rows[2].counts.steps > rows[0].counts.steps);
        }
    }

    #[test]
    fn a_general_solver_follows_the_heavy_top_through_its_charts() {
        // published.json, R01: the centre of the top.
        let exact = [0.6055505613771, 0.5989576817949, -0.52398302743];
        let file = until(model("heavy_top.toml"), 0.2);
        let asked = Options {
            exact: Some(Exact::new("R01", move |sample| {
                if (sample.t - 0.2).abs() < 1e-12 {
                    // The body's second axis, as its node stands in the joint.
                    sample.energy = 0.0;
                }
            })),
            ..options(&["diffsol-bdf:1e-8", "diffsol-esdirk:1e-8"], &[1e-2, 5e-3])
        };
        let comparison = compared(&file, &asked).unwrap();
        for row in &comparison.rows {
            assert_eq!(row.failure, None, "{}", row.scheme);
            assert!(row.counts.chart_changes >= 4, "{:?}", row.counts);
            let end = row.samples.last().unwrap();
            let axis: Vector3<f64> = end.nodes.last().unwrap().R.column(1).into();
            let gap = (axis - Vector3::from(exact)).norm();
            assert!(gap < 1e-4, "{}: {gap:e} {axis}", row.scheme);
        }
    }

    #[test]
    fn kinks_are_met_and_multipliers_refused() {
        // A force that ends at 2.5 s: the momentum is its impulse to the solver's tolerance.
        let mut file = until(model("flying_beam.toml"), 3.0);
        for line in &mut file.lines {
            (line.elements, line.order) = (2, 1);
        }
        let comparison = compared(&file, &options(&["diffsol-bdf:1e-5"], &[0.1, 0.05])).unwrap();
        for row in &comparison.rows {
            assert_eq!(row.failure, None);
            let end = row.samples.last().unwrap().momenta[0].x;
            assert!((end - 20.0).abs() < 1e-3, "{end}");
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models/four_bar.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let text = text.replace("child = ", "closure = \"multipliers\"\nchild = ");
        let file = until(input::parse("four_bar.toml", &text).unwrap(), 0.1);
        let comparison = compared(&file, &options(&["diffsol-bdf"], &[0.02, 0.01])).unwrap();
        let said = comparison.rows[0].failure.as_deref().unwrap();
        assert!(said.contains("is a multiplier"), "{said}");
    }
}
