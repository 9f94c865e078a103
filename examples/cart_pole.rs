//! A controller from the linear equations of motion: a pole is balanced on a cart.

#![allow(non_snake_case)]

use nalgebra::DMatrix;
use pullback::Failure;
use pullback::elements::joint::{Prismatic, Revolute};
use pullback::elements::load::CoordinateForce;
use pullback::elements::time::Input;
use pullback::integrators::linearization::{linearize, output_derivatives};
use pullback::manifold::system::Point;
use pullback::prelude::*;

const CART: f64 = 2.0;
const BOB: f64 = 0.5;
const LENGTH: f64 = 1.2;
const G: f64 = 9.81;

/// A cart on a rail, which a force pushes, and a bob on a massless pole above it.
fn model() -> Result<(Model, Input), Failure> {
    let mut builder = ModelBuilder::new();
    let ground = builder.node("ground", [0.0; 3])?;
    builder.support(ground, &Dof::ALL);
    let cart = builder.attach("cart", ground, Prismatic::new([1.0, 0.0, 0.0])?)?;
    builder.element("cart", PointMass::new(CART)?, &[cart.frame])?;
    let hinge = builder.attach("hinge", cart.frame, Revolute::new([0.0, 1.0, 0.0])?)?;
    let bob = builder.offset("bob", hinge.frame, [0.0, 0.0, LENGTH])?;
    let mass = PointMass::new(BOB)?;
    builder.element("bob", mass, &[bob])?;
    builder.element("weight", mass.weight([0.0, 0.0, -G], Constant(1.0)), &[bob])?;
    let force = builder.input(0.0);
    let push = CoordinateForce::new(force);
    builder.element("push", push, &[cart.coordinates[0]])?;
    Ok((builder.build()?, force))
}

/// Gains that give A − b kᵀ these eigenvalues, by Ackermann's formula.
fn gains(A: &DMatrix<f64>, b: &DMatrix<f64>, poles: [f64; 4]) -> Option<DMatrix<f64>> {
    let n = A.nrows();
    let identity = DMatrix::identity(n, n);
    let polynomial = (poles.iter()).fold(identity.clone(), |p, pole| p * (A - &identity * *pole));
    let mut reached = DMatrix::zeros(n, n);
    let mut column = b.clone();
    for k in 0..n {
        reached.set_column(k, &column.column(0));
        column = A * column;
    }
    let last = identity.rows(n - 1, 1).into_owned();
    Some(last * reached.try_inverse()? * polynomial)
}

fn main() -> Result<(), Failure> {
    let (model, force) = model()?;
    let mut context = Context::new(model);

    // The pole stands upright at q = 0. Outputs: the coordinates themselves.
    let at = Point::statics(0.0, &[0.0; 2]);
    let lin = linearize(&mut context, at)?;
    let outputs = output_derivatives(&mut context, at, |_, at| Ok(at.q.to_vec()))?;
    let space = lin.state_space(&outputs)?;
    // Upright, it falls with the eigenvalue √((M + m) g / (M l)).
    let falls = f64::sqrt((CART + BOB) * G / (CART * LENGTH));
    let found = space.A.complex_eigenvalues();
    let largest = found.iter().fold(0.0, |most: f64, x| most.max(x.re));
    assert!((largest / falls - 1.0).abs() < 1e-12, "{found}");

    let poles = [-2.0, -2.5, -3.0, -3.5];
    let k = gains(&space.A, &space.B, poles).ok_or("the force does not reach the pole")?;
    println!("gains: {k:.3}");

    // The nonlinear motion from a tilt of 0.2 rad, with the force held between samples.
    let h = 0.005;
    let first = start(&context, 0.0, &[0.0, 0.2], &[0.0; 2])?;
    let mut run = Simulation::new(&mut context, first, &DynamicOptions::new(5.0, h))?;
    loop {
        let state = run.state();
        let x = DMatrix::from_iterator(4, 1, state.q.iter().chain(&state.v).copied());
        let u = -(&k * x)[(0, 0)];
        run.set_input(force, u);
        if run.step()?.is_none() {
            break;
        }
    }
    let state = run.state();
    println!("after {} s: {:?}", state.t, state.q);
    // The slowest pole leaves e⁻¹⁰ of the tilt.
    assert!(state.q.iter().all(|q| q.abs() < 1e-3));
    Ok(())
}
