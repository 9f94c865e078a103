//! Blades and shafts in steady rotation, in coordinates relative to a rotating hub.
#![allow(clippy::unwrap_used, non_snake_case)]

use super::assert_near;
use super::beams::{BEAM, Beam, omegas};
use crate::support::beams::straight;
use crate::support::dynamics::{grounded, revolute};
use pullback::elements::beam::Interpolation;
use pullback::elements::time::{Input, SteadyRotation};
use pullback::integrators::linearization::{
    Linearized, ModeOptions, SteadyMotion, linearize, modes,
};
use pullback::manifold::system::Point;
use pullback::prelude::*;

/// A beam of length 1 along x on a hub that rotates about an axis, held at some of the relative coordinates
/// of its ends.
struct Rotor {
    context: Context,
    speed: Input,
}

impl Rotor {
    fn new(beam: &Beam, axis: [f64; 3], elements: usize, held: [&[usize]; 2]) -> Self {
        let (mut b, ground) = grounded();
        let joint = revolute(&mut b, "hub", ground, axis);
        let speed = b.input(0.0);
        b.prescribe_coordinate(joint.coordinates[0], 0, SteadyRotation(speed));
        let line = BeamLine {
            elements,
            order: 3,
            section: beam.section(),
        };
        let last = elements * line.order;
        let mut nodes = Vec::new();
        for k in 0..=last {
            let position = [k as f64 / last as f64, 0.0, 0.0];
            let node = b
                .relative_node(format!("n{k}"), joint.frame, position)
                .unwrap();
            let held = match k {
                0 => held[0],
                k if k == last => held[1],
                _ => &[],
            };
            for &k in held {
                b.prescribe_coordinate(node.coordinates[0], k, Constant(0.0));
            }
            nodes.push(node.frame);
        }
        let axis = straight(&b, [nodes[0], nodes[last]]);
        b.line_through("beam", &axis, &nodes, &line, Interpolation::Total)
            .unwrap();
        let context = Context::new(b.build().unwrap());
        Self { context, speed }
    }

    /// The linear equations in a steady rotation.
    fn linearize(&mut self, speed: f64) -> Linearized {
        let mut steady = SteadyMotion::new(&mut self.context, 0.0, self.speed);
        let options = StaticOptions {
            to: speed,
            ..StaticOptions::default()
        };
        let q = match speed > 0.0 {
            true => equilibrium(&mut steady, &options).unwrap(),
            false => vec![0.0; self.context.initial().len()],
        };
        self.context.set_input(self.speed, speed);
        let zeros = vec![0.0; q.len()];
        let at = Point {
            t: 0.0,
            q: &q,
            v: &zeros,
            a: &zeros,
        };
        linearize(&mut self.context, at).unwrap()
    }
}

/// Frequencies of the lowest modes, which are neither damped nor unstable.
fn undamped(lin: &Linearized, count: usize) -> Vec<f64> {
    let found = modes(lin, &ModeOptions::lowest(count)).unwrap();
    assert!(
        found
            .modes
            .iter()
            .all(|mode| mode.damping_ratio().abs() < 1e-10)
    );
    assert!(found.modes.iter().all(|mode| mode.residual < 1e-12));
    omegas(&found)
}

/// (ρA + ρI κ²) ω² ∓ 2 ρI κ² Ω ω = EI κ⁴ with κ = nπ/L for forward and backward whirl, seen from the shaft.
#[test]
fn whirl_of_a_spinning_shaft() {
    let shaft = Beam {
        EA: 1e6,
        GA: 1e8,
        GJ: 1e6,
        EI: [1.0, 1.0],
        I_rho: [1e-3; 2],
        ..BEAM
    };
    let held: [&[usize]; 2] = [&[0, 1, 2, 3], &[1, 2]];
    let mut rotor = Rotor::new(&shaft, [1.0, 0.0, 0.0], 16, held);
    for speed in [0.0, 2.0, 5.0] {
        let mut exact = Vec::new();
        for n in [1.0, 2.0] {
            let k = n * std::f64::consts::PI;
            let (m, g) = (1.0 + 1e-3 * k * k, 1e-3 * k * k * speed);
            let whirl = |s: f64| (s * g + (g * g + m * k.powi(4)).sqrt()) / m;
            exact.extend([whirl(1.0) - speed, whirl(-1.0) + speed]);
        }
        for (found, exact) in undamped(&rotor.linearize(speed), 4).into_iter().zip(exact) {
            assert_near(found, exact, 1e-6);
        }
    }
}
