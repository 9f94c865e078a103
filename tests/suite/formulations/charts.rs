//! Another chart of rotations gives the same motion and the same equilibrium.
#![allow(clippy::unwrap_used)]

use crate::support::comparisons::compared;
use crate::support::dynamics::slopes;
use crate::support::laboratory::options;
use pullback::elements::model::Formulation;
use pullback::input::{self, Plan};
use pullback::integrators::statics::LoadSteps;
use pullback::studies::compare::ErrorQuantity;

/// Bodies, and beams of both interpolations, that turn beyond π: with Radau IIA of two stages their
/// positions in the chart of Wiener and Milenković converge to those in rotation vectors, with order 3.
#[test]
fn models_of_the_gallery_move_alike_in_both_charts() {
    for (text, step) in [
        (
            include_str!("../../../examples/models/free_body.toml"),
            2e-3,
        ),
        (
            include_str!("../../../examples/models/heavy_top.toml"),
            5e-4,
        ),
        (include_str!("../../../examples/models/top_beam.toml"), 5e-4),
    ] {
        let steps = [step, 0.5 * step, 0.25 * step];
        let comparison = compared(text, &options(&["wm-radau"], &steps)).unwrap();
        let errors: Vec<f64> = (comparison.of("wm-radau"))
            .map(|row| {
                assert_eq!(row.failure, None);
                assert!(row.counts.chart_changes > 10);
                row.error.unwrap().of(ErrorQuantity::Rotation)
            })
            .collect();
        for slope in slopes(&errors) {
            assert!((slope - 3.0).abs() < 0.1, "{errors:?}");
        }
    }
}

/// A clamped beam rolled up into two circles by a moment: its end turns by 4π.
#[test]
fn a_beam_rolls_up_alike_in_both_charts() {
    let text = include_str!("../../../examples/models/rollup.toml");
    let file = input::parse("rollup.toml", text).unwrap();
    let ends = [Formulation::Total, Formulation::WienerMilenkovic].map(|formulation| {
        let mut job = input::job_in("rollup.toml", &file, formulation).unwrap();
        let Plan::Static(options) = job.plan else {
            panic!("statics");
        };
        let mut run = LoadSteps::new(&mut job.context, Vec::new(), &options).unwrap();
        run.finish().unwrap();
        assert!(run.summary().chart_changes > 0);
        let tip = run.system().find("tip").unwrap();
        run.system().node_state(tip)
    });
    // Its tip is back at the root.
    let [total, other] = ends;
    assert!((other.position - total.position).norm() < 1e-8, "{ends:?}");
    assert!((other.R - total.R).norm() < 1e-8, "{ends:?}");
    assert!(other.position.norm() < 1e-8, "{ends:?}");
}
