//! Loops of joints: the builder finds which joint closes a loop, and its coordinates; against
//! closed-form kinematics and equations of motion of one freedom.

#![allow(non_snake_case, clippy::unwrap_used)]

mod dynamics_support;
mod loops_support;

use dynamics_support::*;
use loops_support::four_bar::*;
use loops_support::*;
use nalgebra::{Matrix3, Vector3};
use pullback::elements::body::RigidBody;
use pullback::elements::joint::{RevoluteNodes, offset, revolute};
use pullback::elements::model::{Model, ModelBuilder, NodeId};
use pullback::elements::time::Constant;
use pullback::integrators::dynamics::{Progress, Scheme};
use pullback::manifold::system::{Point, System};

const E3: [f64; 3] = [0.0, 0.0, 1.0];

/// A uniform bar between two places, on a pin at the first one.
fn link(
    b: &mut ModelBuilder,
    name: &str,
    on: NodeId,
    [from, to]: [[f64; 3]; 2],
    m: f64,
) -> RevoluteNodes {
    let pin = offset(b, &format!("pin {name}"), on, from).unwrap();
    let made = revolute(b, name, pin, E3).unwrap();
    let along = Vector3::from(to) - Vector3::from(from);
    let J = (Matrix3::identity() * along.norm_squared() - along * along.transpose()) * (m / 12.0);
    let body = RigidBody::new(m, J, along * 0.5).unwrap();
    let weight = body.weight(DOWN, Box::new(Constant(1.0)));
    b.element(format!("bar {name}"), body, &[made.frame])
        .unwrap();
    b.element(format!("weight {name}"), weight, &[made.frame])
        .unwrap();
    made
}

/// The linkage drawn at an angle of the crank, and its joints A to D.
fn linkage(b: &mut ModelBuilder, crank: f64) -> [NodeId; 4] {
    let at = |angle: f64, l: f64, from: [f64; 3]| {
        [from[0] + l * angle.cos(), from[1] + l * angle.sin(), 0.0]
    };
    let [_, rocker] = closed_form(crank);
    let O = [0.0; 3];
    let P = at(crank, BARS[0], O);
    let D = [BASE, 0.0, 0.0];
    let Q = at(rocker, BARS[2], D);
    let ground = ground(b);
    let A = link(b, "A", ground, [O, P], MASSES[0]);
    let B = link(b, "B", A.frame, [P, Q], MASSES[1]);
    let rocker = link(b, "D", ground, [D, Q], MASSES[2]);
    let tip = offset(b, "tip of the coupler", B.frame, Q).unwrap();
    let C = revolute(b, "C", tip, E3).unwrap();
    let end = offset(b, "tip of the rocker", rocker.frame, Q).unwrap();
    b.close(C.frame, end).unwrap();
    [A.angle, B.angle, C.angle, rocker.angle]
}

struct Motion {
    end: Vec<f64>,
    residual: f64,
    drift: f64,
    notes: Vec<(f64, String)>,
    progress: Progress,
}

fn go(mut model: Model, angles: [NodeId; 4], rate: f64, [to, step]: [f64; 2]) -> Motion {
    let n = model.pattern().dim();
    let zero = vec![0.0; n];
    let mut v = zero.clone();
    let left = model
        .fit_coordinate_rates(&zero, &mut v, &[(angles[0], 0, rate)])
        .unwrap();
    assert!(left < 1e-12, "{left:e}");
    let mut options = tight(Scheme::default(), to, step);
    options.newton.absolute = 1e-13;
    let mut out = Motion {
        end: Vec::new(),
        residual: 0.0,
        drift: 0.0,
        notes: model.notes().into_iter().map(|n| (0.0, n)).collect(),
        progress: Progress::default(),
    };
    let tips = ["tip of the coupler", "tip of the rocker"].map(|n| model.find(n).unwrap());
    let frame = model.find("C").unwrap();
    let mut start = None;
    let (mut end, mut residual, mut drift, mut notes) =
        (Vec::new(), 0.0_f64, 0.0_f64, out.notes.clone());
    out.progress = observed(&mut model, [&zero, &v], &options, &mut |model, step| {
        let both = [0, 1, 3].map(|k| model.coordinate(angles[k], 0).unwrap());
        let [a, b, d] = both;
        end = vec![a[0], a[0] + b[0], d[0], a[1], a[1] + b[1], d[1]];
        let [p, q] = tips.map(|n| model.node_state(n).place);
        let turn = model.node_state(frame).R - model.node_state(tips[1]).R;
        residual = residual.max((p - q).norm()).max(turn.norm());
        let note = model.notes()[0].clone();
        if notes.last().is_none_or(|last| last.1 != note) {
            notes.push((step.progress.state.t, note));
        }
        let s = &step.progress.state;
        let at = Point {
            t: s.t,
            q: &s.q,
            v: &s.v,
            a: &s.a,
        };
        let audit = model.audit(at).unwrap();
        let energy = audit.energies.kinetic + audit.energies.stored + audit.load_potential;
        drift = drift.max((energy - *start.get_or_insert(energy)).abs());
    });
    (out.end, out.residual, out.drift, out.notes) = (end, residual, drift, notes);
    out
}

#[test]
fn a_four_bar_linkage_of_bodies_and_joints() {
    let to = 3.0;
    let exact = four_bar_exact(to);
    let [coupler, rocker] = closed_form(CRANK_START);
    let drawn = [CRANK_START, coupler, rocker, 0.0, 0.0, 0.0];
    let runs = [2400, 4800, 9600].map(|n| {
        let mut b = ModelBuilder::new();
        let angles = linkage(&mut b, CRANK_START);
        let model = b.build().unwrap();
        assert_eq!(model.pattern().dim(), 1);
        go(model, angles, CRANK_RATE, [to, to / f64::from(n)])
    });
    for run in &runs {
        let end: Vec<f64> = run.end.iter().zip(drawn).map(|(x, d)| x + d).collect();
        println!(
            "gap {:.2e}, drift {:.2e}, residual {:.1e}, {} steps, {:?}",
            gap(&end, &exact),
            run.drift,
            run.residual,
            run.progress.summary.steps,
            run.notes
        );
        let changed = run.notes.iter().any(|(t, _)| *t > 0.01 * to);
        assert!(changed, "no change: {:?}", run.notes);
        assert!(run.residual < 1e-13, "{:e}", run.residual);
    }
    let errors: Vec<Vec<f64>> = runs
        .iter()
        .map(|r| {
            let end: Vec<f64> = r.end.iter().zip(drawn).map(|(x, d)| x + d).collect();
            vec![gap(&end, &exact), r.drift]
        })
        .collect();
    assert_slopes("four-bar", &["motion", "energy"], &errors, 2.0, 0.2);
}
