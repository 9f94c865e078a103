//! What it costs not to derive by hand: elements by their energies over the same ones by hand.
//!
//! ```text
//! cargo bench --bench energy
//! ```
//!
//! Results are compared by the tests of the elements.

#![allow(missing_docs)]

use nalgebra::{Matrix3, Matrix6};
use pullback::elements::beam::Beam;
use pullback::elements::element::{Element, Motion, Response};
use pullback::elements::energy::EnergyElement;
use pullback::elements::spring::{AxialSpring, Bushing};
use pullback::manifold::system::Weights;
use pullback::prelude::*;
use std::hint::black_box;
use std::thread::sleep;
use std::time::Duration;

mod race;

#[path = "../examples/elements/elastic_joint.rs"]
mod elastic_joint;
#[path = "../examples/elements/gravity.rs"]
mod gravity;
#[path = "../examples/elements/polynomial_spring.rs"]
mod polynomial_spring;
#[path = "../examples/elements/strain_beam.rs"]
#[allow(dead_code, reason = "one of its two measures is timed")]
mod strain_beam;
use elastic_joint::ElasticJoint;
use gravity::Gravity;
use polynomial_spring::PolynomialSpring;
use race::race;
use strain_beam::{FrameInertia, Reissner, strain_beam};

/// What is asked of an element.
#[derive(Clone, Copy)]
enum Job {
    Residual,
    Static,
    Parts,
    Combined,
}

fn run(element: &dyn Element, job: Job, motion: &[Vec<f64>; 3], out: &mut [Vec<f64>; 4]) {
    out.iter_mut().for_each(|o| o.fill(0.0));
    let [r, K, C, M] = out;
    let [x, v, a] = black_box(motion);
    let moving = !matches!(job, Job::Static);
    let at = Motion {
        t: 0.0,
        inputs: &[],
        x,
        v: if moving { v } else { &[] },
        a: if moving { a } else { &[] },
        previous: None,
    };
    if let (Job::Combined, Some(combined)) = (job, element.abilities().combined) {
        let weights = Weights {
            K: 1.0,
            C: 20.0,
            M: 400.0,
        };
        combined.add(&at, r, &mut [Some((weights, K)), None, None])
    } else {
        let parts = matches!(job, Job::Parts | Job::Combined);
        let mut out = Response {
            r,
            K: (!matches!(job, Job::Residual)).then_some(&mut K[..]),
            C: parts.then_some(&mut C[..]),
            M: parts.then_some(&mut M[..]),
            r_t: None,
        };
        element.evaluate(&at, &mut out)
    }
    .expect("inside the domain");
    black_box(&out);
}

/// Races of which one must be within the limit: neighbours on a machine slow the side that needs more of the
/// caches, for seconds; a loss shows in all.
const RACES: usize = 10;

/// Prints what each job costs on either side; none may cost more than `limit` times the one by hand.
fn compare(
    name: &str,
    by_energy: &dyn Element,
    by_hand: &dyn Element,
    jobs: &[(&str, Job)],
    limit: f64,
) {
    let n = by_hand.dim();
    let wave = |phase: f64| -> Vec<f64> { (0..n).map(|i| (i as f64 + phase).sin()).collect() };
    let motion = [wave(0.1), wave(0.7), wave(1.9)];
    let buffers = || [n, n * n, n * n, n * n].map(|n| vec![0.0; n]);
    for (what, job) in jobs {
        let (mut one, mut other) = (buffers(), buffers());
        let mut ratio = f64::INFINITY;
        for _ in 0..RACES {
            let now = race(
                || run(by_hand, *job, &motion, &mut one),
                || run(by_energy, *job, &motion, &mut other),
            );
            ratio = ratio.min(now);
            if ratio <= limit {
                break;
            }
            sleep(Duration::from_millis(500));
        }
        println!("{ratio:7.1}  {name}: {what}");
        assert!(
            ratio <= limit,
            "{name}, {what}: {ratio:.1} times instead of {limit}"
        );
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    const ALL: [(&str, Job); 4] = [
        ("r", Job::Residual),
        ("r, K in statics", Job::Static),
        ("r, K, C, M", Job::Parts),
        ("r, combined tangent", Job::Combined),
    ];
    println!("by energies over by hand:");
    let positions = [Vector3::zeros(), Vector3::new(0.8, 0.5, -0.3)];
    let along = (positions[1] - positions[0]).normalize();
    let frame = pullback::elements::model::frame_along(&along, None);
    let section = Section::diagonal(1e4, [4e3, 4e3], 2.0, [3.0, 4.0])?
        .with_mass(2.0, Matrix3::from_diagonal(&[3.0, 1.0, 2.0].into()))?;
    let hand = Beam::<2>::new(&positions, &|_| frame, &section)?;
    let energy = strain_beam(Reissner, &positions, &frame, &section)?;
    compare("Reissner beam", &energy, &hand, &ALL, 45.0);
    let hand = RigidBody::new(2.0, Matrix3::identity(), Vector3::new(0.1, 0.2, 0.3))?;
    let body = FrameInertia {
        inertia: *hand.inertia(),
        drag: 0.0,
    };
    // By hand it reads poses, at a third of what it costs in charts.
    compare("rigid body", &body.into_element(), &hand, &ALL[2..], 190.0);
    let hand = AxialSpring::new(&positions, 3.0, 0.7)?;
    let spring = PolynomialSpring {
        positions,
        rest_length: (positions[1] - positions[0]).norm(),
        k: [3.0],
        c: 0.7,
    };
    compare(
        "axial spring",
        &spring.into_element(),
        &hand,
        &ALL[..3],
        130.0,
    );
    let potential = {
        let element = Gravity {
            position: positions[1],
            center: Vector3::zeros(),
            mu: 3.0,
            mass: 2.0,
        }
        .into_element();
        let motion = [0.1, 0.7, 1.9].map(|p: f64| (0..6).map(|i| (i as f64 + p).sin()).collect());
        let buffers = || [6, 36, 36, 36].map(|n| vec![0.0; n]);
        let (mut one, mut other) = (buffers(), buffers());
        race(
            || run(&element, Job::Static, &motion, &mut one),
            || run(&element, Job::Parts, &motion, &mut other),
        )
    };
    let one = Matrix6::identity();
    let hand = Bushing::new(&positions, &Matrix3::identity(), &(one * 3.0), &(one * 0.7))?;
    let joint = ElasticJoint {
        u0: positions[1] - positions[0],
        K: one * 3.0,
        D: one * 0.7,
    };
    // 204 to 225 in runs of one build: the limit is for a loss, not for the noise of a machine.
    compare("bushing", &joint.into_element(), &hand, &ALL[..3], 260.0);
    println!(
        "a potential without T and D, in motion over at rest: {:.2}",
        potential
    );
    Ok(())
}
