//! Energy along motions: the balance of power.

use crate::support::beams;
use crate::support::dynamics::*;
use crate::support::prelude::*;

/// Energies at the end of a run.
fn balance(context: &mut Context, v: &[f64], scheme: Scheme, to: f64, n: usize) -> EnergyBalance {
    let options = DynamicOptions {
        energies: true,
        ..tight(scheme, to, to / n as f64)
    };
    let progress = observed(context, [&[], v], &options, &mut |_, _| ());
    progress.summary.energy.unwrap()
}

#[test]
fn the_power_balance_closes_to_the_order_of_the_scheme() {
    for scheme in second_order() {
        let mut supplied = 0.0;
        let defects = [200, 400, 800].map(|n| {
            // A driven shaft carries an arm; on it a damped hinge; on that a flexible beam.
            let (mut b, ground) = grounded();
            let shaft = revolute(&mut b, "shaft", ground, [0.3, 0.2, 1.0]);
            b.prescribe_coordinate(shaft.coordinates[0], 0, sine(1.5, 2.0, 0.0));
            let arm = b.offset("arm", shaft.frame, [0.4, 0.0, 0.0]).unwrap();
            heavy_body(&mut b, "hub", arm, 1.0, [0.1, 0.2, 0.0]);
            let hinge = revolute(&mut b, "hinge", arm, [0.0, 1.0, 0.0]);
            let law = CoordinateLaw {
                k: 5.0,
                k3: 2.0,
                c: 0.8,
                x0: -0.2,
            };
            let damper = CoordinateSpring::new(law).unwrap();
            b.element("damper", damper, &[hinge.coordinates[0]])
                .unwrap();
            let tip = b.node("tip", [1.2, 0.0, 0.0]).unwrap();
            let damping = Damping {
                mass: 0.1,
                stiffness: 0.01,
            };
            let section = soft(1.0).with_damping(damping).unwrap();
            let force = [0.0, 0.0, -9.81 * section.inertia.mass];
            let nodes = beams::beam(&mut b, "beam", [hinge.frame, tip], 2, section);
            for (k, pair) in nodes.windows(2).enumerate() {
                let positions = [b.position(pair[0]), b.position(pair[1])];
                let weight = LineLoad::new(&positions, force, false, Constant(1.0)).unwrap();
                b.element(format!("weight {k}"), weight, pair).unwrap();
            }
            let mut context = Context::new(b.build().unwrap());
            // The beam begins to move with the shaft, which turns at 3 rad/s.
            let omega = Vector3::new(0.3, 0.2, 1.0).normalize() * 3.0;
            let q = vec![0.0; context.pattern().dim()];
            let mut v = turning(&mut context, &q, omega);
            context.set(&mut v, hinge.coordinates[0], 0, 0.5);
            let energy = balance(&mut context, &v, scheme, 1.0, n);
            supplied = energy.work;
            energy.largest_defect
        });
        assert!(supplied.abs() > 0.5, "the drive is to do something");
        assert_order(scheme.name, &defects, 2.0, 0.1);
    }
}
