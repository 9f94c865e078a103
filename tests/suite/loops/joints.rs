//! Loops of joints closed by a map: forces whichever joint closes, and ball joints that change their charts.

use crate::closures::started_with;
use crate::support::dynamics::*;
use crate::support::loops::four_bar::*;
use crate::support::loops::linkage::*;
use crate::support::loops::*;
use crate::support::prelude::*;

/// The linkage as another tree: the coupler on the rocker, closed at B.
fn other_tree(b: &mut ModelBuilder, crank: f64) -> NodeId {
    let [coupler, rocker] = closed_form(crank);
    let P = [BARS[0] * crank.cos(), BARS[0] * crank.sin(), 0.0];
    let Q = [BASE + BARS[2] * rocker.cos(), BARS[2] * rocker.sin(), 0.0];
    assert!((P[0] + BARS[1] * coupler.cos() - Q[0]).abs() < 1e-14);
    let ground = ground(b);
    let A = link(b, "A", ground, [[0.0; 3], P], (MASSES[0], at_once));
    let D = link(b, "D", ground, [[BASE, 0.0, 0.0], Q], (MASSES[2], at_once));
    let C = link(b, "C", D.frame, [Q, P], (MASSES[1], at_once));
    let tip = b.offset("tip of the coupler", C.frame, P).unwrap();
    let B = revolute(b, "B", tip, E3);
    let end = b.offset("tip of the crank", A.frame, P).unwrap();
    b.close(B.frame, end).unwrap();
    A.coordinates[0]
}

#[test]
fn forces_do_not_depend_on_where_the_loop_is_closed() {
    let forces = |mut context: Context, crank: NodeId| {
        let [q, v] = started_with(&mut context, &[(crank, 0, CRANK_RATE)]);
        let nodes = ["B", "C"].map(|n| context.find(n).unwrap());
        let mut out = Vec::new();
        let options = tight(Scheme::default(), 0.3, 1e-2);
        observed(&mut context, [&q, &v], &options, &mut |context, step| {
            let at = point(&step.progress.state);
            context.energies_and_momentum(at).unwrap();
            let mut r = [0.0];
            context.evaluate(at, Evaluation::residual(&mut r)).unwrap();
            out.push(nodes.map(|n| context.joint_force(n).unwrap()[0]));
        });
        out
    };
    let mut b = ModelBuilder::new();
    let angles = linkage(&mut b, CRANK_START, at_once);
    let one = forces(Context::new(b.build().unwrap()), angles[0]);
    let mut b = ModelBuilder::new();
    let crank = other_tree(&mut b, CRANK_START);
    let other = forces(Context::new(b.build().unwrap()), crank);
    assert_eq!(one.len(), other.len());
    let mut size = 0.0_f64;
    for ([b, c], [d, e]) in one.iter().zip(&other) {
        // B acts on the coupler in one tree and on the crank in the other; C on the rocker, and on the
        // coupler. The crank's angle is the coordinate of both.
        size = size.max(b.norm());
        assert!((b + d).norm() < 1e-10 * (1.0 + b.norm()), "{b} {d}");
        assert!((c + e).norm() < 1e-10 * (1.0 + c.norm()), "{c} {e}");
    }
    assert!(size > 10.0, "{size}");
}

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
