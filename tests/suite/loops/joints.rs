//! Ball joints in a loop that is closed by a map.

use crate::closures::started_with;
use crate::support::dynamics::*;
use crate::support::loops::linkage::*;
use crate::support::prelude::*;

#[test]
fn ball_joints_in_a_loop_change_their_charts() {
    // Crank about e3 and rocker about e1, with a coupler between two ball joints that may spin.
    let runs = [500, 1000, 2000].map(|n| {
        let mut b = ModelBuilder::new();
        let (rotation, e) = balls(&mut b, Closure::Map);
        let mut context = Context::new(b.build().unwrap());
        // Eight unknowns, six equations: the mechanism's freedom and the spin of the coupler.
        assert_eq!(context.pattern().dim(), 2);
        let spin = [0, 1, 2].map(|k| (rotation, k, 7.0 * e[k]));
        let [q, v] = started_with(&mut context, &spin);
        let mut options = tight(Scheme::default(), 2.0, 2.0 / f64::from(n));
        options.newton.absolute = 1e-13;
        let names = ["coupler end", "rocker end"].map(|n| context.find(n).unwrap());
        let (mut residual, mut drift, mut start, mut turned) = (0.0_f64, 0.0_f64, None, 0.0_f64);
        let mut position = Vector3::zeros();
        let progress = observed(&mut context, [&q, &v], &options, &mut |context, step| {
            let at = point(&step.progress.state);
            let audit = context.energies_and_momentum(at).unwrap();
            let [p, q] = names.map(|n| context.node_state(n).position);
            position = p;
            residual = residual.max((p - q).norm());
            turned = turned.max(context.coordinate(rotation, 0).unwrap()[0].abs());
            let energy = audit.energies.kinetic + audit.load_potential;
            drift = drift.max((energy - *start.get_or_insert(energy)).abs());
        });
        let changes = progress.summary.chart_changes;
        assert!(residual < 1e-13, "{residual:e}");
        assert!(
            changes >= 2 && turned <= std::f64::consts::PI,
            "{changes} {turned}"
        );
        (vec![drift], position)
    });
    let drifts: Vec<Vec<f64>> = runs.iter().map(|r| r.0.clone()).collect();
    assert_slopes("balls", &["energy"], &drifts, 2.0, 0.25);
    let positions = runs.map(|r| r.1);
    let steps = [0, 1].map(|k| (positions[k] - positions[k + 1]).norm());
    assert_order("position", &steps, 2.0, 0.25);
}
