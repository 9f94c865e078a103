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
