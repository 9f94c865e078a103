//! ∂r/∂u: forces that are inputs, and prescribed coordinates.

use crate::support::dynamics::grounded;
use pullback::elements::joint::Prismatic;
use pullback::elements::load::CoordinateForce;
use pullback::elements::spring::AxialSpring;
use pullback::integrators::linearization::linearize;
use pullback::manifold::system::Point;
use pullback::prelude::*;

/// A mass on a rail, pushed by an input, and held by a spring of stiffness 7 from a point that a second input moves.
#[test]
fn a_force_and_a_moved_support() {
    let (mut b, ground) = grounded();
    let x = [1.0, 0.0, 0.0];
    let cart = b
        .attach("cart", ground, Prismatic::new(x).unwrap())
        .unwrap();
    let body = PointMass::new(2.0).unwrap();
    b.element("mass", body, &[cart.frame]).unwrap();
    let [push, base] = [0.5, 0.1].map(|value| b.input(value));
    let force = CoordinateForce::new(push);
    b.element("push", force, &[cart.coordinates[0]]).unwrap();
    let anchor = b.node("anchor", [-1.0, 0.0, 0.0]).unwrap();
    b.support(anchor, &Dof::ALL[1..]);
    b.prescribe(anchor, Dof::X, base);
    let ends = [anchor, cart.frame].map(|node| b.position(node));
    let spring = AxialSpring::new(&ends, 7.0, 0.0).unwrap();
    b.element("spring", spring, &[anchor, cart.frame]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    // 7 (q − 0.1) = 0.5.
    let q = [0.1 + 0.5 / 7.0];
    let lin = linearize(&mut context, Point::statics(0.0, &q)).unwrap();
    assert_eq!((lin.dim(), lin.r_u.len()), (1, 2));
    for (found, exact) in [
        (lin.r_u[0][0], 1.0),
        (lin.r_u[1][0], 7.0),
        (lin.K[0], 7.0),
        (lin.M[0], 2.0),
    ] {
        assert!((found - exact).abs() < 1e-9, "{found} {exact}");
    }
    // The inputs are as before.
    assert_eq!([push, base].map(|u| context.input(u)), [0.5, 0.1]);
}
