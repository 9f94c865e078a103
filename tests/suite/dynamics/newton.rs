//! How Newton's method converges within a step: what the pulled-back tangents promise.
//!
//! The tangent at an iterate takes the stresses in K_σ from the iterate before, extrapolated over
//! the last correction (`Evaluation::previous`). What it differs by from the exact tangent is of
//! the order of the last correction squared, so that with corrections cₖ and residuals rₖ
//!
//! ```text
//! rₖ₊₁ = O(cₖ²) + O(cₖ₋₁²) cₖ,     rₖ ~ cₖ
//! ```
//!
//! which is quadratic convergence as soon as cₖ₋₁² is below cₖ, that is from the second correction
//! on. In the first iteration the iterate before is the state at the beginning of the step.

use crate::support::beams;
use crate::support::dynamics::*;
use crate::support::prelude::*;
use crate::support::program::example;
use pullback::manifold::sparse::BlockPattern;

/// A flexible beam from a support that is thrown into motion; at its end a rigid link, on that a
/// hinge, on that a second beam with a heavy end: every frame that a joint has as parent is free.
fn thrown_beams() -> Context {
    let mut b = ModelBuilder::new();
    let carriage = b.node("carriage", [0.0; 3]).unwrap();
    b.support(carriage, &[Dof::Y, Dof::Z, Dof::RY, Dof::RZ]);
    // 1 − cos: from rest, with full acceleration.
    for (dof, amplitude, omega) in [(Dof::X, 0.3, 6.0), (Dof::RX, 0.4, 5.0)] {
        let from_rest = Sine {
            offset: amplitude,
            ..sine(-amplitude, omega, FRAC_PI_2)
        };
        b.prescribe(carriage, dof, from_rest);
    }
    let wrist = b.node("wrist", [0.0, 0.5, 0.0]).unwrap();
    beam(&mut b, "first", [carriage, wrist], 2);
    let arm = b.offset("arm", wrist, [0.4, 0.7, -0.3]).unwrap();
    let frame = revolute(&mut b, "hinge", arm, [0.2, 1.0, 0.3]).frame;
    heavy_body(&mut b, "hub", frame, 1.0, [0.1, 0.0, 0.2]);
    let tip = b.node("tip", [1.4, 0.7, -0.3]).unwrap();
    beam(&mut b, "second", [frame, tip], 4);
    heavy_body(&mut b, "end", tip, 2.0, [0.1, 0.1, 0.0]);
    Context::new(b.build().unwrap())
}

fn beam(b: &mut ModelBuilder, name: &str, ends: [NodeId; 2], elements: usize) {
    let J = Matrix3::from_diagonal(&Vector3::new(0.02, 0.01, 0.01));
    let [_, EA, A_rho, _] = DATA;
    let section = Section::diagonal(EA, [EA; 2], 10.0, [10.0; 2]).unwrap();
    let section = section.with_mass(A_rho, J).unwrap();
    beams::beam(b, name, ends, elements, section);
}

/// A model whose tangent is the exact one times a factor: no extrapolated stresses.
struct Plain {
    model: Context,
    factor: f64,
}

impl System for Plain {
    fn pattern(&self) -> &BlockPattern {
        self.model.pattern()
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let S = out.S.map(|(mut weights, S)| {
            weights.K *= self.factor;
            weights.C *= self.factor;
            weights.M *= self.factor;
            (weights, S)
        });
        let previous = None;
        self.model.evaluate(at, Evaluation { S, previous, ..out })
    }

    fn name(&self, i: usize) -> String {
        self.model.name(i)
    }

    fn scales(&self) -> Scales {
        self.model.scales()
    }
}

impl Modelled for Plain {
    fn model(&mut self) -> &mut Context {
        &mut self.model
    }
}

/// Length of an element, axial stiffness, mass per length and step size.
const DATA: [f64; 4] = [0.25, 1e4, 1.0, 0.05];

/// Largest residuals (N and N m) of the iterations of the first steps, of a composite scheme those of the
/// first substep.
fn residuals<Y: Modelled>(mut system: Y, scheme: Scheme, predictor: Predictor) -> Vec<Vec<f64>> {
    let h = DATA[3];
    let mut options = tight(scheme, 4.0 * h, h);
    options.newton.predictor = predictor;
    let mut steps = Vec::new();
    observed(&mut system, [&[], &[]], &options, &mut |_, step| {
        let all = step.residuals;
        // A converged state, which has no correction, ends a substep.
        let end = all.iter().position(|i| i.damping == 0.0).unwrap();
        let largest = |i: &Iteration| i.residual[0].max(i.residual[1]);
        steps.push(all[..=end].iter().map(largest).collect());
    });
    steps
}

/// Whether rₖ₊₁ ≤ C rₖ² down to the round-off of the stresses, in all pairs that have rₖ below
/// one hundredth of the first residual.
///
/// A correction c leaves the second-order part of the strain energy, (EA/l) c²/2, and is itself at
/// most r/S with the smallest dynamic stiffness S = 4m/h², m the mass of an element:
/// C = (EA/l) / 2S².
fn quadratic(r: &[f64]) -> bool {
    let [l, EA, A_rho, h] = DATA;
    let S = 4.0 * A_rho * l / (h * h);
    let C = 0.5 * EA / l / (S * S);
    let round_off = 1e-15 * EA / l;
    let mut near = r.windows(2).filter(|p| p[0] < 1e-2 * r[0]).peekable();
    assert!(r[0] > 100.0 && near.peek().is_some(), "too near: {r:?}");
    near.all(|p| p[1] <= C * p[0] * p[0] + round_off)
}

#[test]
fn residuals_square_from_one_iteration_to_the_next() {
    for scheme in second_order() {
        for predictor in [Predictor::Velocity, Predictor::Keep] {
            let plain = |factor| Plain {
                model: thrown_beams(),
                factor,
            };
            let extrapolated = residuals(thrown_beams(), scheme, predictor);
            let exact = residuals(plain(1.0), scheme, predictor);
            for right in extrapolated.iter().chain(&exact) {
                assert!(quadratic(right), "{scheme}, {predictor:?}: {right:?}");
            }
            // What a tangent that is wrong by one per cent would look like.
            for wrong in residuals(plain(1.01), scheme, predictor) {
                assert!(!quadratic(&wrong), "{scheme}, {predictor:?}: {wrong:?}");
            }
        }
    }
}

/// The time that a run reaches until a step fails.
fn reached<Y: System>(mut system: Y, options: &DynamicOptions, predictor: Predictor) -> f64 {
    let mut options = DynamicOptions {
        min_step: options.step,
        ..*options
    };
    options.newton.predictor = predictor;
    let first = start(&system, 0.0, &[], &[]).unwrap();
    let mut run = Simulation::new(&mut system, first, &options).unwrap();
    let outcome = run.finish();
    assert_eq!(outcome.is_err(), run.progress().summary.failed > 0);
    run.state().t
}

#[test]
fn going_on_with_the_velocity_needs_extrapolated_stresses_in_the_struck_cantilever() {
    // cases.md, case 5: with the exact tangent q + h q̇ diverges before t = 6, q does not (it does later).
    let model = || {
        let (context, _, options) = motion_of(&example("elbow"));
        (context, options)
    };
    let plain = |predictor| {
        let (model, options) = model();
        reached(Plain { model, factor: 1.0 }, &options, predictor)
    };
    let diverged = plain(Predictor::Velocity);
    assert!(diverged < 6.0, "{diverged}");
    assert!(plain(Predictor::Keep) > 6.0);
    for predictor in [Predictor::Velocity, Predictor::Keep] {
        let (model, options) = model();
        assert_eq!(reached(model, &options, predictor), 30.0);
    }
}

#[test]
fn a_smooth_step_of_a_rigid_mechanism_takes_one_iteration() {
    // Without the accelerations in the prediction it takes two.
    let taken = |predictor| {
        let text = include_str!("../../../benches/models/ur5.toml");
        let (mut context, first, mut options) = motion_of(text);
        options.newton.predictor = predictor;
        options.to = 1.1;
        let (mut progress, mut iterations) = (Progress::new(first), Vec::new());
        let seen = &mut |_: &mut Context, step: &StepReport<'_>| {
            if step.progress.state.t > 1.0 {
                iterations.push(step.iterations);
            }
            ControlFlow::Continue(())
        };
        integrate(&mut context, &mut progress, &options, seen).unwrap();
        (iterations, progress.summary.factorisations)
    };
    let (smooth, factorisations) = taken(Predictor::Velocity);
    assert!(smooth.len() >= 99, "{smooth:?}");
    assert!(smooth.iter().all(|i| *i == 1), "{smooth:?}");
    // Converged states need no tangent, nor do corrections after the first one of most steps.
    assert!(factorisations < 1200, "{factorisations}");
    let (kept, _) = taken(Predictor::Keep);
    assert!(kept.iter().all(|i| *i >= 2), "{kept:?}");
}
