//! Statics of beams: how Newton's method converges, and how it fails.

use crate::support::beams::beam;
use crate::support::prelude::*;

/// A cantilever of unit length along e1 with a load at its tip.
fn cantilever(EA: f64, elements: usize, load: NodalLoad) -> Context {
    let (mut builder, [root, tip]) = rod(EA, elements);
    builder.support(root, &Dof::ALL);
    builder.element("load", load, &[tip]).unwrap();
    Context::new(builder.build().unwrap())
}

/// A rod of unit length along e1, and its ends.
fn rod(EA: f64, elements: usize) -> (ModelBuilder, [NodeId; 2]) {
    let mut b = ModelBuilder::new();
    let ends = [("root", 0.0), ("tip", 1.0)].map(|(name, x)| b.node(name, [x, 0.0, 0.0]).unwrap());
    let section = Section::diagonal(EA, [EA; 2], 1.0, [1.0; 2]).unwrap();
    beam(&mut b, "rod", ends, elements, section);
    (b, ends)
}

fn dead(force: [f64; 3]) -> NodalLoad {
    NodalLoad::new(LoadKind::DeadForce, force, Proportional(1.0))
}

#[test]
fn follower_forces_and_spatial_moments_converge_quadratically() {
    // Both have nonsymmetric tangents: an error in them would make convergence linear.
    for (which, vector) in [
        (LoadKind::FollowerForce, [0.3, 1.0, 0.7]),
        (LoadKind::SpatialMoment, [0.4, 0.9, -0.8]),
        (LoadKind::FollowerMoment, [0.4, 0.9, -0.8]),
        (LoadKind::DeadForce, [0.3, 1.0, 0.7]),
    ] {
        let load = NodalLoad::new(which, vector, Proportional(1.0));
        let mut context = cantilever(1e3, 10, load);
        let mut ratios = Vec::new();
        let options = StaticOptions::equal_steps(1);
        solve_statics(&mut context, &mut vec![], &options, &mut |_, step| {
            ratios = step.residuals.iter().map(|i| i.correction).collect();
            ControlFlow::Continue(())
        })
        .unwrap();
        // Corrections (in units of the model) square from one iteration to the next, with a
        // constant that a structure of size one with forces of order one keeps below 100.
        let corrections: Vec<f64> = ratios.into_iter().filter(|&c| c > 0.0).collect();
        assert!(corrections.len() <= 7, "{which:?}: {corrections:?}");
        for pair in corrections.windows(2).filter(|p| p[0] < 1e-2) {
            let quadratic = pair[1] <= 100.0 * pair[0] * pair[0] + 1e-13;
            assert!(quadratic, "{which:?}: {corrections:?}");
        }
    }
}

#[test]
fn slenderness_does_not_change_the_number_of_iterations() {
    // Plain Newton's method needs more and smaller steps the larger EA L²/EI is; with stresses
    // extrapolated in the tangent it does not (Magisano et al. 2017).
    let counts = [1e2, 1e4, 1e6].map(|EA| {
        let mut context = cantilever(EA, 20, dead([0.0, 2.0, 0.5]));
        let options = StaticOptions::equal_steps(1);
        let proceed = &mut |_: &mut Context, _: &Step<'_>| ControlFlow::Continue(());
        let summary = solve_statics(&mut context, &mut vec![], &options, proceed).unwrap();
        assert_eq!(summary.rejected, 0);
        summary.iterations
    });
    let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
    assert!(*most <= 10 && most - least <= 2, "{counts:?}");
}

#[test]
fn results_are_the_same_to_the_last_bit_in_every_run() {
    let run = || {
        let mut context = cantilever(1e4, 30, dead([0.0, 5.0, 3.0]));
        equilibrium(&mut context, &StaticOptions::default()).unwrap()
    };
    assert_eq!(run(), run());
}

#[test]
fn a_driven_rotation_of_three_turns_carries_the_beam_around() {
    // The clamp turns about e3 by three turns and a bit; the unloaded beam follows as a whole.
    let angle = 6.0 * std::f64::consts::PI + 0.7;
    let (mut builder, [root, tip]) = rod(1e3, 4);
    builder.support(root, &[Dof::X, Dof::Y, Dof::Z, Dof::RX, Dof::RY]);
    builder.prescribe(root, Dof::RZ, Proportional(angle));
    let mut context = Context::new(builder.build().unwrap());
    context.check_supports().unwrap();
    let options = StaticOptions {
        max_step: 0.05,
        ..StaticOptions::default()
    };
    let observe = &mut |context: &mut Context, step: &Step<'_>| {
        let (s, c) = (angle * step.t).sin_cos();
        let gap = context.node_state(tip).position - Vector3::new(c, s, 0.0);
        assert!(gap.norm() < 1e-9, "{} {gap}", step.t);
        assert!(context.strain_energy(step.t) < 1e-16);
        ControlFlow::Continue(())
    };
    let summary = solve_statics(&mut context, &mut vec![], &options, observe).unwrap();
    assert!(summary.finished);
    assert!(summary.chart_changes >= 3 * 5);
}
