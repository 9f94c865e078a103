//! The updated Lagrangian formulation, as a chart that is centred anew after every step, against
//! the total one and an exact motion.
#![allow(non_snake_case, clippy::unwrap_used)]

use crate::support::dynamics::{observed, second_order, slopes, tight};
use nalgebra::{Matrix3, Rotation3, Vector3};
use pullback::elements::body::RigidBody;
use pullback::elements::model::{Context, ModelBuilder, NodeId};
use pullback::integrators::dynamics::Scheme;
use pullback::manifold::map::{Increment, Map};
use pullback::manifold::system::{Quantity, System};

/// A free symmetrical body with the angular velocity (3, 0, 4).
fn body(updated: bool) -> (Context, NodeId, Vec<f64>) {
    let mut b = ModelBuilder::new();
    let (node, rotation) = if updated {
        let kinds = [[Quantity::Length; 3], [Quantity::Angle; 3]].concat();
        let own = b.coordinates("increment", &kinds).unwrap();
        let map = Increment::<6>::default().boxed();
        (b.mapped_node("O", [0.0; 3], map, &[own]).unwrap(), own)
    } else {
        let node = b.node("O", [0.0; 3]).unwrap();
        (node, node)
    };
    let J = Matrix3::from_diagonal(&Vector3::new(2.0, 2.0, 1.0));
    let body = RigidBody::new(1.0, J, Vector3::zeros()).unwrap();
    b.element("body", body, &[node]).unwrap();
    let context = Context::new(b.build().unwrap());
    let mut v = vec![0.0; context.pattern().dim()];
    for (k, omega) in [(3, 3.0), (5, 4.0)] {
        context.set(&mut v, rotation, k, omega);
    }
    (context, node, v)
}

/// Distance of the rotation at t = 2 from the exact one, and the number of changes of chart.
fn error(updated: bool, scheme: Scheme, n: usize) -> (f64, usize) {
    let to = 2.0;
    let (mut context, node, v) = body(updated);
    let options = tight(scheme, to, to / n as f64);
    let mut R = Matrix3::zeros();
    let progress = observed(&mut context, [&[], &v], &options, &mut |context, _| {
        R = context.node_state(node).R;
    });
    // Landau & Lifshitz, Mechanics, section 33: about L with |L|/J₁, about its axis with
    // Ω₃ (1 − J₃/J₁).
    let precession = Rotation3::new(Vector3::new(3.0, 0.0, 2.0) * to);
    let exact = precession * Rotation3::new(Vector3::z() * (2.0 * to));
    (
        (R - exact.into_inner()).norm(),
        progress.summary.chart_changes,
    )
}

#[test]
fn the_updated_lagrangian_keeps_the_order_of_every_scheme() {
    for scheme in second_order() {
        let run = |n| error(true, scheme, n);
        let runs = [200, 400, 800].map(run);
        // Every step centres the chart anew.
        assert!(
            runs.iter().zip([200, 400, 800]).all(|(r, n)| r.1 >= n),
            "{runs:?}"
        );
        let errors = runs.map(|r| r.0);
        for slope in slopes(&errors) {
            assert!((slope - 2.0).abs() < 0.1, "{}: {errors:?}", scheme.name);
        }
    }
    let third = [100, 200, 400].map(|n| error(true, Scheme::radau(), n).0);
    for slope in slopes(&third) {
        assert!((slope - 3.0).abs() < 0.1, "radau: {third:?}");
    }
}

#[test]
fn total_and_updated_formulations_are_different_schemes_with_one_limit() {
    let [total, updated] = [false, true].map(|updated| error(updated, Scheme::default(), 800).0);
    assert!(total < 1e-3 && updated < 1e-3, "{total:e} {updated:e}");
    // The scheme is applied to other coordinates: its error is not the same.
    assert!(
        (total - updated).abs() > 1e-2 * total.max(updated),
        "{total:e} {updated:e}"
    );
}
