//! The planar four-bar linkage as a model of bodies on joints.

use super::DOWN;
use super::four_bar::*;
use crate::support::dynamics::{ground, revolute, weighed};
use crate::support::prelude::*;

pub const E3: [f64; 3] = [0.0, 0.0, 1.0];

/// How weights come on: at once, and in statics with the load parameter.
type Weights = fn() -> Box<dyn TimeFunction>;

pub fn at_once() -> Box<dyn TimeFunction> {
    Box::new(Constant(1.0))
}

pub fn growing() -> Box<dyn TimeFunction> {
    Box::new(Proportional(1.0))
}

/// A uniform bar between two positions, on a pin at the first one.
pub fn link(
    b: &mut ModelBuilder,
    name: &str,
    on: NodeId,
    [from, to]: [[f64; 3]; 2],
    (m, weights): (f64, Weights),
) -> JointNodes {
    let pin = b.offset(format!("pin {name}"), on, from).unwrap();
    let made = revolute(b, name, pin, E3);
    let along = Vector3::from(to) - Vector3::from(from);
    let J = (Matrix3::identity() * along.norm_squared() - along * along.transpose()) * (m / 12.0);
    let body = RigidBody::new(m, J, along * 0.5).unwrap();
    let weight = body.weight(DOWN, weights());
    b.element(format!("bar {name}"), body, &[made.frame])
        .unwrap();
    b.element(format!("weight {name}"), weight, &[made.frame])
        .unwrap();
    made
}

/// The linkage drawn at an angle of the crank and closed by a method, and its joints A to D.
pub fn linkage(b: &mut ModelBuilder, crank: f64, weights: Weights, by: Closure) -> [NodeId; 4] {
    let at = |angle: f64, l: f64, from: [f64; 3]| {
        [from[0] + l * angle.cos(), from[1] + l * angle.sin(), 0.0]
    };
    let [_, rocker] = closed_form(BARS, crank);
    let O = [0.0; 3];
    let P = at(crank, BARS[0], O);
    let D = [BARS[3], 0.0, 0.0];
    let Q = at(rocker, BARS[2], D);
    let ground = ground(b);
    let A = link(b, "A", ground, [O, P], (MASSES[0], weights));
    let B = link(b, "B", A.frame, [P, Q], (MASSES[1], weights));
    let rocker = link(b, "D", ground, [D, Q], (MASSES[2], weights));
    let tip = b.offset("tip of the coupler", B.frame, Q).unwrap();
    let C = revolute(b, "C", tip, E3);
    let end = b.offset("tip of the rocker", rocker.frame, Q).unwrap();
    b.close_by(C.frame, end, by).unwrap();
    [
        A.coordinates[0],
        B.coordinates[0],
        C.coordinates[0],
        rocker.coordinates[0],
    ]
}

/// Crank about e3 and rocker about e1, with a coupler between two ball joints that may spin about the
/// line between them: the rotation of the first of these, and that line.
pub fn balls(b: &mut ModelBuilder, by: Closure) -> (NodeId, Vector3<f64>) {
    let ground = ground(b);
    let (P, Q, D) = ([0.3, 0.0, 0.0], [0.0, 1.0, 0.9], [0.0, 1.0, 0.0]);
    let A = link(b, "A", ground, [[0.0; 3], P], (1.0, at_once));
    let tip = b.offset("crank pin", A.frame, P).unwrap();
    let B = b.spherical("B", tip).unwrap();
    let along = Vector3::from(Q) - Vector3::from(P);
    let e = along.normalize();
    let J = Matrix3::identity() * 0.2 - e * e.transpose() * 0.15;
    let body = RigidBody::new(0.7, J, along * 0.5).unwrap();
    weighed(b, "coupler", B.frame, body, DOWN);
    let end = b.offset("coupler end", B.frame, Q).unwrap();
    let C = b.spherical("C", end).unwrap();
    let foot = b.offset("foot", ground, D).unwrap();
    let rocker = revolute(b, "D", foot, [1.0, 0.0, 0.0]);
    let body = RigidBody::new(1.0, Matrix3::identity() * 0.3, Vector3::new(0.0, 0.0, 0.45));
    b.element("rocker", body.unwrap(), &[rocker.frame]).unwrap();
    let child = b.offset("rocker end", rocker.frame, Q).unwrap();
    b.close_by(C.frame, child, by).unwrap();
    (B.coordinates[0], e)
}
