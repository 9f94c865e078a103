//! Rigid mechanisms: one step of Newmark's scheme, without and with the balance of energy of a run, in steps of the
//! classical Runge-Kutta method for the same mechanism through `System::evaluate`.
//!
//! `cargo bench --bench mechanisms` prints the table. A Runge-Kutta step is four evaluations of the residual
//! and the mass matrix, each with one solution for the accelerations; it has no Newton iteration, no balance of
//! energy and no output.

#![allow(missing_docs)]

use pullback::input::assemble_text;
use pullback::integrators::linear_solver::{BlockLu, LinearSolver, MatrixSymmetry};
use pullback::manifold::system::{Evaluation, Point, System, Weights};
use pullback::prelude::*;
use std::error::Error;
use std::time::Instant;

/// Models with the size and the number of the steps.
const MODELS: [(&str, &str, f64, usize); 3] = [
    ("UR5 arm", include_str!("models/ur5.toml"), 1e-3, 1000),
    (
        "spatial slider-crank",
        include_str!("models/spatial_slider_crank.toml"),
        5e-4,
        400,
    ),
    (
        "four-bar linkage",
        include_str!("../examples/models/four_bar.toml"),
        1e-3,
        400,
    ),
];

/// q̈ from M q̈ = r(q, q̇, 0).
struct Accelerations {
    context: Context,
    solver: BlockLu,
    M: Vec<f64>,
    zero: Vec<f64>,
}

impl Accelerations {
    fn new(context: Context) -> Result<Self, Box<dyn Error>> {
        Ok(Self {
            solver: BlockLu::new(context.pattern(), MatrixSymmetry::General)?,
            M: vec![0.0; context.pattern().len()],
            zero: vec![0.0; context.pattern().dim()],
            context,
        })
    }

    fn at(&mut self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Box<dyn Error>> {
        let at = Point {
            t,
            q,
            v,
            a: &self.zero,
        };
        (self.context).evaluate(at, Evaluation::with_tangent(a, Weights::MASS, &mut self.M))?;
        self.solver.factorise_and_solve(&self.M, a)?;
        Ok(())
    }

    /// Seconds of a step of the classical Runge-Kutta method, from q and v on.
    fn seconds(
        &mut self,
        (mut q, mut v): (Vec<f64>, Vec<f64>),
        h: f64,
        steps: usize,
    ) -> Result<f64, Box<dyn Error>> {
        let n = q.len();
        let mut rates = vec![[vec![0.0; n], vec![0.0; n]]; 4];
        let (mut x, mut w) = (q.clone(), v.clone());
        let start = Instant::now();
        for step in 0..steps {
            for (k, c) in [0.0, 0.5, 0.5, 1.0].into_iter().enumerate() {
                for i in 0..n {
                    let [dq, dv] = &rates[k.saturating_sub(1)];
                    (x[i], w[i]) = (q[i] + c * h * dq[i], v[i] + c * h * dv[i]);
                }
                let [dq, dv] = &mut rates[k];
                dq.copy_from_slice(&w);
                self.at((step as f64 + c) * h, &x, &w, dv)?;
            }
            for (rate, weight) in rates.iter().zip([1.0, 2.0, 2.0, 1.0]) {
                for i in 0..n {
                    q[i] += weight * h / 6.0 * rate[0][i];
                    v[i] += weight * h / 6.0 * rate[1][i];
                }
            }
        }
        Ok(start.elapsed().as_secs_f64() / steps as f64)
    }
}

/// Seconds of a step of Newmark's scheme, with or without the balance of energy.
fn newmark_seconds(
    mut context: Context,
    (q, v): (&[f64], &[f64]),
    h: f64,
    steps: usize,
    energies: bool,
) -> Result<f64, Box<dyn Error>> {
    let options = DynamicOptions {
        scheme: Scheme::newmark(0.25, 0.5)?,
        energies,
        ..DynamicOptions::new(steps as f64 * h, h)
    };
    let state = start(&context, 0.0, q, v)?;
    let mut run = Simulation::new(&mut context, state, &options)?;
    let begin = Instant::now();
    while run.step()?.is_some() {}
    Ok(begin.elapsed().as_secs_f64() / steps as f64)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("a step in us:           Newmark  with energies  Runge-Kutta  ratios");
    for (name, text, h, steps) in MODELS {
        let job = assemble_text(name, text)?;
        let (q, v) = (job.start.q, job.start.v);
        let mut ratios = [const { Vec::new() }; 2];
        let mut best = [f64::INFINITY; 3];
        for _ in 0..9 {
            let newmark =
                |energies| newmark_seconds(job.context.clone(), (&q, &v), h, steps, energies);
            let mut explicit = Accelerations::new(job.context.clone())?;
            let runge_kutta = explicit.seconds((q.clone(), v.clone()), h, steps)?;
            let seconds = [newmark(false)?, newmark(true)?, runge_kutta];
            for (ratios, seconds) in ratios.iter_mut().zip(seconds) {
                ratios.push(seconds / runge_kutta);
            }
            for (best, seconds) in best.iter_mut().zip(seconds) {
                *best = best.min(seconds);
            }
        }
        let [without, with] = ratios.map(|mut ratios| {
            ratios.sort_by(f64::total_cmp);
            ratios[4]
        });
        let [newmark, energies, runge_kutta] = best.map(|seconds| 1e6 * seconds);
        println!(
            "{name:22}  {newmark:7.1}  {energies:13.1}  {runge_kutta:11.1}  {without:.2} {with:.2}"
        );
    }
    Ok(())
}
