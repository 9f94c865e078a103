//! Elements by their energies in models, against closed forms.

use crate::support::dynamics::{assert_order, observed};
use crate::support::prelude::*;
use crate::support::program::assert_close;
use gravity::Gravity;
use pullback::elements::energy::EnergyElement;
use strain_beam::{GreenLagrange, Reissner, StrainMeasure, strain_beam};

#[path = "../../../examples/elements/gravity.rs"]
mod gravity;
#[path = "../../../examples/elements/strain_beam.rs"]
mod strain_beam;

const LENGTH: f64 = 2.0;
const EA: f64 = 300.0;
const EI: f64 = 4.0;

/// The tip of a cantilever along e1 of n elements under a load at its tip: position and rotation.
fn tip<M: StrainMeasure + Copy + 'static>(measure: M, n: usize, load: NodalLoad) -> NodeState {
    let mut b = ModelBuilder::new();
    let section = Section::diagonal(EA, [100.0, 100.0], 3.0, [EI, EI]).unwrap();
    let x = |i: usize| LENGTH * i as f64 / n as f64;
    let node = |i| b.node(format!("n{i}"), [x(i), 0.0, 0.0]).unwrap();
    let nodes: Vec<NodeId> = (0..=n).map(node).collect();
    for (i, ends) in nodes.windows(2).enumerate() {
        let positions = [b.position(ends[0]), b.position(ends[1])];
        let beam = strain_beam(measure, &positions, &Matrix3::identity(), &section).unwrap();
        b.element(format!("e{i}"), beam, ends).unwrap();
    }
    b.support(nodes[0], &Dof::ALL);
    b.element("load", load, &[nodes[n]]).unwrap();
    let mut context = Context::new(b.build().unwrap());
    equilibrium(&mut context, &StaticOptions::default()).unwrap();
    context.node_state(nodes[n])
}

/// A moment bends a beam of any measure into an arc, nothing is stretched.
fn bends_into_an_arc<M: StrainMeasure + Copy + 'static>(measure: M) {
    let angle = 0.75 * PI;
    let moment = [0.0, 0.0, angle * EI / LENGTH];
    let arc = Vector3::new(angle.sin(), 1.0 - angle.cos(), 0.0) * (LENGTH / angle);
    let errors = [4, 8, 16].map(|n| {
        let load = NodalLoad::new(LoadKind::SpatialMoment, moment, Proportional(1.0));
        let state = tip(measure, n, load);
        assert_close(state.psi.z, angle, 1e-9, n);
        (state.d + Vector3::x() * LENGTH - arc).norm()
    });
    assert_order("arc", &errors, 2.0, 0.05);
}

#[test]
fn beams_of_both_measures_bend_into_the_same_arc() {
    bends_into_an_arc(Reissner);
    bends_into_an_arc(GreenLagrange);
}

#[test]
fn bars_of_the_two_measures_stretch_by_their_laws() {
    let stretch = 1.2;
    let pull =
        |force: f64| NodalLoad::new(LoadKind::DeadForce, [force, 0.0, 0.0], Proportional(1.0));
    let elongation = (stretch - 1.0) * LENGTH;
    let state = tip(Reissner, 3, pull(EA * (stretch - 1.0)));
    assert_close(state.d.x, elongation, 1e-9, "Reissner");
    let force = EA * 0.5 * (stretch * stretch - 1.0) * stretch;
    let state = tip(GreenLagrange, 3, pull(force));
    assert_close(state.d.x, elongation, 1e-9, "Green and Lagrange");
}

#[test]
fn a_planet_is_at_its_aphelion_after_half_its_year() {
    // Perihelion at 1, eccentricity 0.5: semi-axis 2, aphelion at −3, half a year π √(a³/μ).
    let (mu, mass) = (5.0, 0.7);
    let half: f64 = PI * (8.0_f64 / mu).sqrt();
    let speed = (mu * 1.5_f64).sqrt();
    let errors = [400, 800].map(|steps| {
        let mut b = ModelBuilder::new();
        let planet = b.node("planet", [1.0, 0.0, 0.0]).unwrap();
        b.support(planet, &[Dof::Z, Dof::RX, Dof::RY, Dof::RZ]);
        b.element("mass", PointMass::new(mass).unwrap(), &[planet])
            .unwrap();
        let gravity = Gravity {
            position: b.position(planet),
            center: Vector3::zeros(),
            mu,
            mass,
        };
        b.element("gravity", gravity.into_element(), &[planet])
            .unwrap();
        let mut context = Context::new(b.build().unwrap());
        let options = DynamicOptions::new(half, half / f64::from(steps));
        let from = [&[0.0; 2][..], &[0.0, speed]];
        let end = observed(&mut context, from, &options, &mut |_, _| ()).state;
        (end.q[0] + 4.0).hypot(end.q[1])
    });
    assert_order("planet", &errors, 2.0, 0.05);
    assert!(errors[1] < 1e-3, "{errors:?}");
}
