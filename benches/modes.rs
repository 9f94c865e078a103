//! Modes: in factorisations of the same matrix, and a linearised rotating blade.
//!
//! `cargo bench --bench modes` prints the table.

#![allow(missing_docs)]

use nalgebra::Matrix3;
use pullback::elements::joint::Revolute;
use pullback::elements::model::BeamLine;
use pullback::elements::time::{Input, SteadyRotation};
use pullback::integrators::linear_solver::{AutoSolver, LinearSolver, MatrixSymmetry};
use pullback::integrators::linearization::{
    Linearized, ModeOptions, SteadyMotion, linearize, modes,
};
use pullback::manifold::system::Point;
use pullback::prelude::*;
use std::error::Error;
use std::time::Instant;

fn section() -> Result<Section, Box<dyn Error>> {
    let section = Section::diagonal(1e6, [4e5; 2], 80.0, [100.0, 150.0])?;
    let inertia = Matrix3::from_diagonal(&[2.5e-4, 1e-4, 1.5e-4].into());
    Ok(section.with_mass(1.0, inertia)?)
}

/// A frame of `bays` by `stories` cells, `elements` in each column and girder, clamped at the ground.
fn frame(bays: usize, stories: usize, elements: usize) -> Result<Context, Box<dyn Error>> {
    let mut b = ModelBuilder::new();
    let mut nodes = Vec::new();
    for j in 0..=stories {
        for i in 0..=bays {
            let node = b.node(format!("{i}.{j}"), [i as f64, 0.0, j as f64])?;
            if j == 0 {
                b.support(node, &Dof::ALL);
            }
            nodes.push(node);
        }
    }
    let line = BeamLine::new(elements, section()?);
    let at = |i: usize, j: usize| nodes[j * (bays + 1) + i];
    for j in 0..stories {
        for i in 0..=bays {
            let girder = (i < bays).then(|| [at(i, j + 1), at(i + 1, j + 1)]);
            for ends in [Some([at(i, j), at(i, j + 1)]), girder]
                .into_iter()
                .flatten()
            {
                let axis = StraightLine::new(b.position(ends[0]), b.position(ends[1]));
                let name = format!("{} {}", b.node_name(ends[0]), b.node_name(ends[1]));
                b.line(&name, &axis, ends, &line)?;
            }
        }
    }
    Ok(Context::new(b.build()?))
}

/// How many times as long as a factorisation the ten lowest modes take: the middle one of rounds in turns, as the
/// clock of a machine changes; and the number of factorisations made.
fn compare(lin: &Linearized) -> Result<(f64, usize), Box<dyn Error>> {
    const ROUNDS: usize = 15;
    let mut solver = AutoSolver::new(&lin.pattern, MatrixSymmetry::Symmetric)?;
    let mut made = 0;
    let mut ratios = Vec::new();
    for _ in 0..ROUNDS {
        let start = Instant::now();
        for _ in 0..5 {
            solver.factorise(&lin.K)?;
        }
        let unit = start.elapsed().as_secs_f64() / 5.0;
        let start = Instant::now();
        made = modes(lin, &ModeOptions::lowest(10))?.factorisations;
        ratios.push(start.elapsed().as_secs_f64() / unit);
    }
    ratios.sort_by(f64::total_cmp);
    Ok((ratios[ROUNDS / 2], made))
}

/// A blade of 24 elements along x, clamped to a hub that turns about z.
fn blade(order: usize) -> Result<(Context, Input), Box<dyn Error>> {
    let mut b = ModelBuilder::new();
    let ground = b.node("ground", [0.0; 3])?;
    b.support(ground, &Dof::ALL);
    let hub = b.attach("hub", ground, Revolute::new([0.0, 0.0, 1.0])?)?;
    let speed = b.input(0.0);
    b.prescribe_coordinate(hub.coordinates[0], 0, SteadyRotation(speed));
    let line = BeamLine {
        order,
        relative_to: Some(hub.frame),
        ..BeamLine::new(24, section()?)
    };
    let root = b.offset("root", hub.frame, [0.0; 3])?;
    let tip = b.relative_node("tip", hub.frame, [1.0, 0.0, 0.0])?;
    let axis = StraightLine::new(b.position(root), b.position(tip.frame));
    b.line("blade", &axis, [root, tip.frame], &line)?;
    Ok((Context::new(b.build()?), speed))
}

/// Milliseconds of a linearisation about the steady rotation, and of its ten lowest modes: the least of some rounds.
fn blade_times(order: usize) -> Result<[f64; 2], Box<dyn Error>> {
    let (mut context, speed) = blade(order)?;
    let options = StaticOptions::default();
    let q = equilibrium(&mut SteadyMotion::new(&mut context, 0.0, speed), &options)?;
    context.set_input(speed, options.to);
    let zeros = vec![0.0; q.len()];
    let at = Point {
        t: 0.0,
        q: &q,
        v: &zeros,
        a: &zeros,
    };
    let mut best = [f64::INFINITY; 2];
    for _ in 0..50 {
        let start = Instant::now();
        let lin = linearize(&mut context, at)?;
        let between = Instant::now();
        modes(&lin, &ModeOptions::lowest(10))?;
        for (best, time) in best.iter_mut().zip([between - start, between.elapsed()]) {
            *best = best.min(1e3 * time.as_secs_f64());
        }
    }
    Ok(best)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("rotating blade, 24 elements  unknowns  linearisation  ten modes");
    for order in 1..=3 {
        let [linearisation, modes] = blade_times(order)?;
        let unknowns = 24 * 6 * order;
        println!("order {order:22}  {unknowns:8}  {linearisation:10.2} ms  {modes:6.2} ms");
    }
    println!("ten lowest modes            unknowns  factorisations made  time in factorisations");
    for (name, mut context) in [
        ("beam", frame(0, 1, 16_667)?),
        ("frame of 20 by 20", frame(20, 20, 20)?),
    ] {
        let q = vec![0.0; context.initial().len()];
        let lin = linearize(&mut context, Point::statics(0.0, &q))?;
        let (ratio, made) = compare(&lin)?;
        let unknowns = lin.dim();
        println!("{name:26}  {unknowns:8}  {made:19}  {ratio:22.1}");
    }
    Ok(())
}
