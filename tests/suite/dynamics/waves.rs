//! A wave in a bar of beam elements by the explicit central difference: d'Alembert's solution, and
//! the largest stable step of a bar of linear elements with consistent mass.

use crate::support::beams::{beam, line};
use crate::support::dynamics::{assert_order, observed};
use crate::support::prelude::*;
use crate::support::program::{assert_says, directory, printed, results, write};

/// Stiffness EA, mass per length and length of the bar, which is free.
const EA: f64 = 100.0;
const A_RHO: f64 = 1.0;
const LENGTH: f64 = 1.0;

/// Velocity of waves, √(EA/Aρ).
fn velocity() -> f64 {
    (EA / A_RHO).sqrt()
}

/// A blow of this duration: P₀ sin⁴(πt/T), with all derivatives that anybody asks for continuous.
#[derive(Clone, Copy, Debug)]
struct Blow {
    force: f64,
    duration: f64,
}

impl Blow {
    /// ∫P from 0 to t.
    fn impulse(&self, t: f64) -> f64 {
        let (t, x) = (t.clamp(0.0, self.duration), PI / self.duration);
        self.force
            * (0.375 * t - (2.0 * x * t).sin() / (4.0 * x) + (4.0 * x * t).sin() / (32.0 * x))
    }
}

impl TimeFunction for Blow {
    fn at(&self, t: f64, _: &[f64]) -> [f64; 3] {
        if !(0.0..self.duration).contains(&t) {
            return [0.0; 3];
        }
        let w = PI / self.duration;
        let (s, c) = (w * t).sin_cos();
        let second = 12.0 * s * s * c * c - 4.0 * s.powi(4);
        [s.powi(4), 4.0 * w * s.powi(3) * c, w * w * second].map(|x| self.force * x)
    }
}

/// The bar of `elements` elements along e1, struck at its left end; its nodes.
fn bar(elements: usize, blow: Blow) -> (Context, Vec<NodeId>) {
    let mut b = ModelBuilder::new();
    let ends = [0.0, LENGTH].map(|x| b.node(format!("x{x}"), [x, 0.0, 0.0]).unwrap());
    // Nothing is as stiff for its mass as stretching.
    let section = Section::diagonal(EA, [10.0, 10.0], 10.0, [10.0, 10.0]).unwrap();
    let J = Matrix3::from_diagonal(&Vector3::new(2.0, 1.0, 1.0));
    let section = section.with_mass(A_RHO, J).unwrap();
    let nodes = beam(&mut b, "bar", ends, elements, section);
    let strike = NodalLoad::new(LoadKind::DeadForce, [1.0, 0.0, 0.0], blow);
    b.element("blow", strike, &nodes[..1]).unwrap();
    (Context::new(b.build().unwrap()), nodes)
}

fn explicit(to: f64, h: f64) -> DynamicOptions {
    DynamicOptions {
        scheme: Scheme::central_difference(),
        ..DynamicOptions::new(to, h)
    }
}

/// 2/ω of the highest mode of a bar of elements of length ℓ, ω² = 6 (c/ℓ)² (1 − cos θ)/(2 + cos θ) at θ = π.
fn stable(elements: usize) -> f64 {
    LENGTH / elements as f64 / (3_f64.sqrt() * velocity())
}

#[test]
fn a_blow_runs_through_the_bar_and_back_as_d_alembert_has_it() {
    let blow = Blow {
        force: 0.1,
        duration: 0.05,
    };
    let c = velocity();
    // u = (c/EA) ∫P over t − x/c, and over t − (2L − x)/c once it has come back from the free end.
    let exact = |x: f64, t: f64| -> f64 {
        let ways = [x, 2.0 * LENGTH - x].into_iter();
        ways.map(|way| c / EA * blow.impulse(t - way / c)).sum()
    };
    let error = |elements: usize| {
        let (mut context, nodes) = bar(elements, blow);
        // Until it is back in the middle, and over the elements' own step as a whole number of steps.
        let to = 1.6 * LENGTH / c;
        let h = to / (to / (0.9 * stable(elements))).ceil();
        let mut worst = [0.0_f64; 2];
        let options = explicit(to, h);
        observed(&mut context, [&[]; 2], &options, &mut |context, step| {
            let t = step.progress.state.t;
            for (k, &node) in nodes.iter().enumerate() {
                let x = LENGTH * k as f64 / elements as f64;
                let node = context.node_state(node);
                worst[0] = worst[0].max((node.d.x - exact(x, t)).abs());
                worst[1] = worst[1].max(node.d.yz().norm());
            }
        });
        worst
    };
    let errors = [40, 80, 160].map(error);
    // Waves of length 2π/k are faster by (kℓ)²/24 for the elements and (ckh)²/24 for the scheme: what runs
    // as f(x − ct) is off by ct f‴ (ℓ² + c²h²)/24, f‴ = P″/(EA c²), |P″| ≤ 4 P₀ (π/T)², and twice that
    // where it comes back.
    let square = (LENGTH / 160.0).powi(2) * (1.0 + 0.81 / 3.0);
    let third = 4.0 * blow.force * (PI / blow.duration).powi(2) / (EA * c * c);
    let dispersed = 1.6 * LENGTH * third * square / 24.0;
    let found = errors[2][0] / dispersed;
    assert!((0.5..2.0).contains(&found), "{errors:?} {dispersed:e}");
    assert_order("wave", &errors.map(|e| e[0]), 2.0, 0.1);
    assert!(errors.iter().all(|e| e[1] < 1e-12), "{errors:?}");
}

#[test]
fn the_stable_step_is_that_of_linear_elements_with_consistent_mass() {
    let blow = Blow {
        force: 0.0,
        duration: 1.0,
    };
    for elements in [10, 80] {
        let exact = stable(elements);
        let run = |h: f64| -> Result<Summary, DynamicsError> {
            let (mut context, _) = bar(elements, blow);
            let first = start(&context, 0.0, &[], &[])?;
            let mut run = Simulation::new(&mut context, first, &explicit(5.0 * h, h))?;
            run.finish()?;
            Ok(run.progress().summary)
        };
        let told = run(0.99 * exact).unwrap().stable_step.unwrap();
        assert!((told / exact - 1.0).abs() < 1e-5, "{told} {exact}");
        let Err(DynamicsError::StepTooLarge { stable, .. }) = run(1.01 * exact) else {
            panic!("{elements}: this step was accepted");
        };
        assert!((stable / exact - 1.0).abs() < 1e-5, "{stable} {exact}");
    }
}

#[test]
fn the_program_tells_the_stable_step_of_an_accepted_one() {
    let rest = "[sections.main.mass]\nA_rho = 1\nJ = [2, 1, 1]\n\
        [[initial]]\nline = \"line\"\nvelocity = [1, 0, 0]\n\
        [analysis.dynamic]\nto = 0.05\nstep = 0.005\nscheme = \"central-difference\"\n";
    let stiffness = "EA = 100, GA = [10, 10], GJ = 10, EI = [10, 10]";
    let out = directory("waves");
    write(&out, &line(stiffness, 10, 1, rest));
    let said = printed(&out, "run model.toml");
    let told = results(&out.join("model.out"))["statistics"]["stable_step"]
        .as_f64()
        .unwrap();
    assert!((told / stable(10) - 1.0).abs() < 1e-5, "{told}");
    // 0.1/(√3 · 10)
    assert_says(&said, &["stable for steps of at most 5.7735"]);
}
