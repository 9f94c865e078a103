//! General solvers of ordinary differential equations in comparisons, built by the feature `diffsol`.

#[path = "../suite/support/laboratory.rs"]
mod laboratory;

use laboratory::{compared, model, options, until};
use nalgebra::Vector3;
use pullback::input;
use pullback::studies::compare::{Candidate, ComparisonOptions, ErrorQuantity, Exact, Sample};
use pullback::studies::gallery::exact;

const WORDS: [&str; 2] = ["diffsol-bdf:1e-6", "diffsol-esdirk:1e-6"];

/// Position and velocity alone of the bob of the pendulum of the gallery, by Jacobi's elliptic functions.
fn bob(sample: &mut Sample) {
    let mut exactly = Sample::unknown(sample.t, 2);
    let nodes = ["pivot", "rod"].map(str::to_owned);
    exact("pendulum", &nodes).unwrap().fill(&mut exactly);
    let known = exactly.nodes[1];
    // The node of the joint comes first, then that of the rod.
    let rod = sample.nodes.len() - 1;
    sample.nodes[rod].position = known.position;
    sample.nodes[rod].velocity = known.velocity;
    sample.energy = 0.0;
    sample.gross_energy = 1.0;
}

#[test]
fn a_general_solver_swings_the_pendulum() {
    let file = until(model("pendulum.toml"), 2.0);
    let asked = ComparisonOptions {
        exact: Some(Exact::new("Jacobi's elliptic functions", bob)),
        ..options(&WORDS, &[0.04, 0.02, 0.01])
    };
    let comparison = compared(&file, &asked).unwrap();
    for word in WORDS {
        let name = word.parse::<Candidate>().unwrap().to_string();
        let rows: Vec<_> = comparison.of(&name).collect();
        assert_eq!(rows.len(), 3);
        for row in &rows {
            assert_eq!(row.failure, None, "{word}");
            assert_eq!(row.samples.len(), comparison.times + 1);
            let c = &row.counts;
            assert!(c.steps > 20 && c.iterations >= c.steps, "{c:?}");
            assert!(c.evaluations > c.iterations, "{c:?}");
            assert!(c.factorisations > c.steps, "{c:?}");
        }
        let error = |k: usize| rows[k].error.unwrap().of(ErrorQuantity::Position);
        let [coarse, fine] = [error(0), error(2)];
        // The tolerance falls to a sixteenth: local errors do, the global ones about.
        assert!(
            coarse < 1e-3 && fine < 0.25 * coarse,
            "{word}: {coarse} {fine}"
        );
        assert!(rows[2].counts.steps > rows[0].counts.steps);
    }
}

#[test]
fn a_general_solver_follows_the_heavy_top_through_its_charts() {
    // published.json, R01: the centre of the top.
    let exact = [0.6055505613771, 0.5989576817949, -0.52398302743];
    let file = until(model("heavy_top.toml"), 0.2);
    let asked = ComparisonOptions {
        // Compared below.
        exact: Some(Exact::new("R01", |_| ())),
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
    let text = include_str!("../../examples/models/four_bar.toml")
        .replace("child = ", "closure = \"multipliers\"\nchild = ");
    let file = until(input::parse("four_bar.toml", &text).unwrap(), 0.1);
    let comparison = compared(&file, &options(&["diffsol-bdf"], &[0.02, 0.01])).unwrap();
    let said = comparison.rows[0].failure.as_deref().unwrap();
    assert!(said.contains("is a multiplier"), "{said}");
}

#[test]
fn words_name_them_and_their_tolerance() {
    let known = "diffsol-bdf".parse::<Candidate>();
    assert_eq!(known.unwrap().order(), None);
    let with: Candidate = "diffsol-esdirk:0.00001".parse().unwrap();
    assert_eq!(with.to_string(), "diffsol-esdirk:0.00001");
    for word in ["diffsol-bdf:2", "diffsol-bdf:x", "diffsol-bdf:"] {
        assert!(word.parse::<Candidate>().is_err(), "{word}");
    }
}
