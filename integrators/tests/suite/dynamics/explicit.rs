//! The explicit schemes: stable steps, waves, what they refuse.

use crate::support::dynamics::*;
use crate::support::linear_solver::filled;
use crate::support::*;
use std::f64::consts::PI;

/// Masses on a line between walls, springs of stiffness k between them.
struct Chain {
    pattern: BlockPattern,
    k: f64,
    K: Vec<f64>,
    m: Vec<f64>,
    evaluations: usize,
}

impl Chain {
    fn new(n: usize, k: f64, m: f64) -> Self {
        let pattern = BlockPattern::new(&vec![1; n], (1..n as u32).map(|i| [i - 1, i]));
        Self {
            K: filled(&pattern, |i, j| if i == j { 2.0 * k } else { -k }),
            pattern,
            k,
            m: vec![m; n],
            evaluations: 0,
        }
    }

    /// ω of its mode j, the largest for j = n: 2 √(k/m) sin(jπ/(2(n + 1))).
    fn frequency(&self, j: usize) -> f64 {
        let n = self.m.len();
        2.0 * (self.k / self.m[0]).sqrt() * (0.5 * PI * j as f64 / (n + 1) as f64).sin()
    }

    fn mode(&self, j: usize) -> Vec<f64> {
        let n = self.m.len();
        let wave = |i: usize| (PI * (j * (i + 1)) as f64 / (n + 1) as f64).sin();
        (0..n).map(wave).collect()
    }
}

impl System for Chain {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        self.evaluations += 1;
        let forces = self.m.iter().zip(at.a).map(|(m, a)| -m * a);
        out.r.iter_mut().zip(forces).for_each(|(r, f)| *r = f);
        self.pattern.multiply_add(-1.0, &self.K, at.q, out.r);
        if let Some((w, S)) = out.S {
            S.iter_mut().zip(&self.K).for_each(|(S, K)| *S = w.K * K);
            let diagonal = self.pattern.diagonal().zip(&self.m);
            diagonal.for_each(|(i, m)| S[i] += w.M * m);
        }
        Ok(())
    }

    fn name(&self, i: usize) -> String {
        format!("mass {i}")
    }

    fn energetics(&mut self) -> Option<&mut dyn Energetics> {
        Some(self)
    }
}

impl Energetics for Chain {
    fn energies(&mut self, at: Point<'_>) -> Result<Energies, SystemError> {
        let mut Kq = vec![0.0; self.m.len()];
        self.pattern.multiply_add(1.0, &self.K, at.q, &mut Kq);
        let kinetic = self.m.iter().zip(at.v).map(|(m, v)| 0.5 * m * v * v).sum();
        Ok(Energies {
            kinetic,
            stored: 0.5 * Kq.iter().zip(at.q).map(|(f, q)| f * q).sum::<f64>(),
            ..Energies::default()
        })
    }
}

fn run(chain: &mut Chain, q: &[f64], options: &DynamicOptions) -> Result<Progress, DynamicsError> {
    attempt(chain, [q, &[]], options)
}

fn explicit(to: f64, h: f64) -> DynamicOptions {
    steps_of(Scheme::central_difference(), to, h)
}

#[test]
fn steps_beyond_the_stable_one_are_refused_with_what_it_is() {
    for (n, k, m) in [
        (1, 3.0, 2.0),
        (2, 1.0, 1.0),
        (30, 50.0, 0.2),
        (400, 1e6, 1e-3),
    ] {
        let mut chain = Chain::new(n, k, m);
        let exact = chain.frequency(n);
        let q = chain.mode(1);
        let h = 2.0 / exact;
        let error = run(&mut chain, &q, &explicit(100.0 * h, 1.001 * h)).unwrap_err();
        let DynamicsError::StepTooLarge {
            stable, frequency, ..
        } = error
        else {
            panic!("{error}");
        };
        // Upper modes of long chains lie as close as 1 to n²: what is found is among them.
        let gap = (frequency / exact - 1.0).abs();
        assert!(gap < 1e-5, "{n}: {frequency} {exact}");
        assert!((stable / h - 1.0).abs() < 1e-5, "{n}: {stable} {h}");
        // An accepted step is told the same.
        let accepted = run(&mut chain, &q, &explicit(10.0 * h, 0.999 * h)).unwrap();
        assert_eq!(accepted.summary.stable_step, Some(stable));
    }
    // One light mass in a chain sets the step, and is named.
    let mut chain = Chain::new(10, 50.0, 1.0);
    chain.m[6] = 1e-4;
    // ω² = 2 k/m and 50 by the neighbours, 2 (k/√m)² m/(2 k).
    refused! {
        run(&mut chain, &[], &explicit(1.0, 0.1)) => [
            "step 0.1 is too large for central difference",
            "stable for steps of at most 1.99995",
            "mass 6 is stiffest for its mass",
            "take smaller steps (those of `adaptive` by `max_step`), or a scheme that is stable at every step",
        ],
    }
    // Adaptive steps may grow up to max_step.
    let options = adaptive(explicit(1.0, 1e-3), 1e-3, 1.0);
    let chain = &mut Chain::new(3, 10.0, 1.0);
    refused! { run(chain, &[], &options) => ["step 1.0 is too large"] }
}

#[test]
fn coordinates_without_mass_are_refused_by_name() {
    let mut chain = Chain::new(5, 10.0, 1.0);
    chain.m[3] = 0.0;
    let pair = steps_of(Scheme::tsitouras(), 1.0, 0.01);
    // Implicit, and stable for small steps only.
    let linear = steps_of(Scheme::newmark(1.0 / 6.0, 0.5).unwrap(), 1.0, 0.01);
    for options in [explicit(1.0, 0.01), linear, pair, adaptive(pair, 1e-6, 1.0)] {
        let needs = format!("{} needs mass in every coordinate", options.scheme.name);
        let cure = "a scheme that is stable at every step";
        refused! { run(&mut chain, &[], &options) => [&needs[..], "mass 3", cure] }
    }
}

#[test]
fn a_mode_keeps_its_amplitude_and_has_the_frequency_of_the_scheme() {
    // q = mode cos(ω̄ t) with sin(ω̄ h/2) = ω h/2 solves the difference equations exactly.
    let mut chain = Chain::new(20, 100.0, 1.0);
    let (h, steps) = (0.08, 500);
    let to = h * steps as f64;
    for j in [1, 7, 20] {
        let mode = chain.mode(j);
        let bar = 2.0 / h * (0.5 * h * chain.frequency(j)).asin();
        chain.evaluations = 0;
        let progress = run(&mut chain, &mode, &explicit(to, h)).unwrap();
        for (q, mode) in progress.state.q.iter().zip(&mode) {
            assert!((q - mode * (bar * to).cos()).abs() < 1e-9, "{j}");
        }
        // A residual with the mass matrix, and one that shows the balance.
        assert!(chain.evaluations <= 2 * steps + 5, "{}", chain.evaluations);
        assert_eq!(progress.summary.iterations, steps);
    }
}

#[test]
fn the_pair_of_tsitouras_takes_six_evaluations_and_its_stable_step() {
    let mut chain = Chain::new(20, 100.0, 1.0);
    let options = |to, step| steps_of(Scheme::tsitouras(), to, step);
    let stable = Scheme::tsitouras().properties().limit.unwrap() / chain.frequency(20);
    let refused = run(&mut chain, &[], &options(1.0, 1.001 * stable)).unwrap_err();
    let DynamicsError::StepTooLarge { stable: said, .. } = refused else {
        panic!("{refused}");
    };
    assert!((said / stable - 1.0).abs() < 1e-5, "{said} {stable}");
    let (steps, mode) = (400, chain.mode(7));
    let to = 0.9 * stable * f64::from(steps);
    chain.evaluations = 0;
    let progress = run(&mut chain, &mode, &options(to, 0.9 * stable)).unwrap();
    assert!(chain.evaluations <= 6 * steps as usize + 5);
    assert!(progress.summary.iterations <= 6 * steps as usize);
    let angle = chain.frequency(7) * to;
    for (q, mode) in progress.state.q.iter().zip(&mode) {
        assert!((q - mode * angle.cos()).abs() < 1e-5, "{q}");
    }
}

#[test]
fn schemes_of_order_three_are_refused_adaptive_steps() {
    let options = adaptive(steps_of(Scheme::radau(), 1.0, 0.1), 1e-3, 1.0);
    let chain = &mut Chain::new(3, 10.0, 1.0);
    refused! { run(chain, &[], &options) => ["schemes of order 1 or 2"] }
}

/// ẍ + 400 ẋ + 9 x = 0: h c/m = 4 is beyond the stability of the scheme, although its frequency is not.
#[test]
fn dampers_that_make_a_motion_unstable_are_noticed() {
    let mut dashpot = Oscillator {
        c: 400.0,
        kinks: Vec::new(),
        ..Oscillator::new(1.0, 9.0)
    };
    let options = steps_of(Scheme::tsitouras(), 2.0, 0.01);
    refused! { attempt(&mut dashpot, [&[0.0], &[1.0]], &options) => ["the motion is unstable"] }
    // λ = −0.0225 and −400: x = v₀ (e^(λ₁ t) − e^(λ₂ t)) / (λ₁ − λ₂).
    let options = steps_of(Scheme::tsitouras(), 2.0, 1e-4);
    let end = attempt(&mut dashpot, [&[0.0], &[1.0]], &options).unwrap();
    let x = end.state.q[0];
    let root = (200.0_f64 * 200.0 - 9.0).sqrt();
    let exact = ((-200.0 + root) * 2.0).exp() / (2.0 * root);
    assert!((x - exact).abs() < 1e-9, "{x} {exact}");
}
