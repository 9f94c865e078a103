//! When Newton's method may stop: states that are no equilibrium are not called one, and rounding
//! errors do not keep one from being found. All against closed forms.

use crate::support::beams::{COLUMN, beam, line};
use crate::support::closures::{body_of, fixed};
use crate::support::dynamics::{observed, weighed};
use crate::support::prelude::*;
use crate::support::program::assert_close;

/// Displacement of the crown of a von Mises truss of height `rise` and half span 1 (stiffness 1 of
/// each bar) under a load that presses it down, with another node held `far` away.
fn truss(rise: f64, load: f64, far: f64) -> Result<f64, StaticsError> {
    let nodes = format!("other = [{far:?}, 0, 0]\nT = ");
    let text = super::corrections::truss(1.0, rise, load).replace("T = ", &nodes)
        + &body_of("other", 1.0, "")
        + &fixed("other");
    let mut context = assemble_text("truss.toml", &text).unwrap().context;
    equilibrium(&mut context, &StaticOptions::default())?;
    let crown = context.find("T").unwrap();
    Ok(context.coordinate(crown, 1).unwrap()[0])
}

#[test]
fn a_node_far_away_does_not_blur_a_limit_load() {
    // f(y) = 2 y (ℓ₀/ℓ − 1) with ℓ² = 1 + y²; f′ = 0 where ℓ³ = ℓ₀.
    let rise = 0.1_f64;
    let rest = (1.0 + rise * rise).sqrt();
    let force = |y: f64| 2.0 * y * (rest / (1.0 + y * y).sqrt() - 1.0);
    let top = (rest.powf(2.0 / 3.0) - 1.0).sqrt();
    for far in [2.0, 1e6, 1e12] {
        for part in [1.001, 1.0001] {
            let above = truss(rise, part * force(top), far);
            assert!(above.is_err(), "{part} at {far:e}: {above:?}");
        }
        for part in [0.99, 0.9999] {
            let load = part * force(top);
            let y = rise + truss(rise, load, far).unwrap();
            assert!(y > top, "before the limit point");
            let what = format!("{part} at {far:e}");
            assert_close(force(y) / load, 1.0, 1e-8, what);
        }
    }
}

#[test]
fn a_stiff_spring_keeps_what_turns_on_it() {
    // Two masses of 1 on a spring of length 1 at 1 rad/s: the angle is t, L = ½. The trapezoidal rule
    // is off by h²/12 of the angle, and L by what it leaves of the spring's length.
    for (k, gravity) in [(1e6, 0.0), (1e9, 0.0), (1e11, 0.0), (1e11, 1e-3)] {
        let mut b = ModelBuilder::new();
        let masses = [("a", 0.0), ("b", 1.0)].map(|(name, x)| {
            let node = b.node(name, [x, 0.0, 0.0]).unwrap();
            let body = RigidBody::new(1.0, Matrix3::identity(), Vector3::zeros()).unwrap();
            weighed(&mut b, name, node, body, [0.0, 0.0, -gravity]);
            node
        });
        let spring = AxialSpring::new(&masses.map(|n| b.position(n)), k, 0.0).unwrap();
        b.element("spring", spring, &masses).unwrap();
        let mut context = Context::new(b.build().unwrap());
        let n = context.initial().len();
        let (q, mut v) = (vec![0.0; n], vec![0.0; n]);
        for (node, rate) in [(masses[0], -0.5), (masses[1], 0.5)] {
            v[context.unknown(node, Dof::Y).unwrap()] = rate;
        }
        let mut options = DynamicOptions::new(1.0, 0.01);
        options.scheme = Scheme::chung_hulbert(0.8).unwrap();
        observed(&mut context, [&q, &v], &options, &mut |_, _| ());
        let at = |node: NodeId, k: usize| context.coordinate(node, k).unwrap();
        let [x, y] = [0, 1].map(|k| at(masses[1], k)[0] - at(masses[0], k)[0]);
        let [u, w] = [0, 1].map(|k| at(masses[1], k)[1] - at(masses[0], k)[1]);
        let angle = y.atan2(1.0 + x);
        let momentum = 0.5 * ((1.0 + x) * w - y * u);
        let what = format!("{k:e}, {gravity}");
        assert_close(angle, 1.0, 1e-4, &what);
        assert_close(momentum, 0.5, 1e-4, &what);
    }
}

/// A round rod along e₁ under its own weight, radius 10 mm, density of steel, and its nodes.
fn rod(E: f64, length: f64, elements: usize) -> (ModelBuilder, Vec<NodeId>) {
    let mut b = ModelBuilder::new();
    let ends = [("a", 0.0), ("b", length)].map(|(name, x)| b.node(name, [x, 0.0, 0.0]).unwrap());
    let area = std::f64::consts::PI * 1e-4;
    let I = std::f64::consts::PI * 1e-8 / 4.0;
    let (EA, EI, rho) = (E * area, E * I, 7850.0);
    let J = Matrix3::from_diagonal(&Vector3::new(2.0, 1.0, 1.0)) * (rho * I);
    let section = Section::diagonal(EA, [0.35 * EA; 2], 0.8 * EI, [EI; 2]).unwrap();
    let section = section.with_mass(rho * area, J).unwrap();
    let nodes = beam(&mut b, "rod", ends, elements, section);
    for pair in nodes.windows(2) {
        let positions = [b.position(pair[0]), b.position(pair[1])];
        let weight = [0.0, -9.81 * rho * area, 0.0];
        let load = LineLoad::new(&positions, weight, false, Constant(1.0)).unwrap();
        let name = format!("weight of {}", b.node_name(pair[0]));
        b.element(name, load, pair).unwrap();
    }
    (b, nodes)
}

/// Runs from rest.
fn fall(context: &mut Context, options: &DynamicOptions) -> Summary {
    let rest = vec![0.0; context.initial().len()];
    observed(context, [&rest, &rest], options, &mut |_, _| ()).summary
}

#[test]
fn coupled_stages_of_a_stiff_rod_stop_at_rounding_errors() {
    // A free steel rod falls from rest: −g t²/2 in as many steps as were asked for.
    for E in [2.1e11, 2.1e13] {
        let (b, nodes) = rod(E, 1.0, 4);
        let mut context = Context::new(b.build().unwrap());
        let mut options = DynamicOptions::new(1.0, 0.01);
        options.scheme = Scheme::radau();
        let summary = fall(&mut context, &options);
        assert_eq!((summary.steps, summary.failed), (100, 0), "E = {E:e}");
        for node in [nodes[0], nodes[4]] {
            let [fallen, ..] = context.coordinate(node, 1).unwrap();
            assert_close(fallen, -9.81 / 2.0, 1e-8, E);
        }
    }
}

#[test]
fn rounding_errors_cost_no_iteration() {
    // Forces of elements of 10 mm are rounded by 1e-16 E A 10 m / 10 mm, more than the tolerance
    // allows: convergence is quadratic down to there, and the next correction would mend nothing.
    let (mut b, nodes) = rod(2.1e11, 10.0, 1000);
    b.support(nodes[0], &Dof::ALL);
    let mut context = Context::new(b.build().unwrap());
    let summary = fall(&mut context, &DynamicOptions::new(0.4, 0.02));
    assert_eq!((summary.steps, summary.failed), (20, 0));
    let iterations = summary.iterations;
    assert!(iterations <= 60, "{iterations} in 20 steps");
}

#[test]
fn a_load_on_a_support_measures_nothing() {
    // A cantilever of EI = L = 1 under 10 across its tip, bent far; the elastica by elliptic integrals
    // (Bisshopp & Drucker 1945) ends at 1 − 0.55500, 0.81061; the mesh is the same in both runs.
    let bent = |pressed: f64| {
        let loads = [("B", 10.0), ("A", -pressed)].map(|(node, force)| {
            format!("[[loads]]\nnode = \"{node}\"\nforce = [0, {force:e}, 0]\n")
        });
        let text = line(COLUMN, 6, 3, &(fixed("A") + &loads.concat()));
        let mut context = assemble_text("model.toml", &text).unwrap().context;
        equilibrium(&mut context, &StaticOptions::default()).unwrap();
        let tip = context.find("B").unwrap();
        [0, 1].map(|k| context.coordinate(tip, k).unwrap()[0])
    };
    let expected = bent(0.0);
    for pressed in [1.0, 1e8, 1e11, 1e15] {
        let found = bent(pressed);
        for (found, expected) in found.into_iter().zip(expected) {
            assert_close(found, expected, 1e-9, pressed);
        }
    }
}
