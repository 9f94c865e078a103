//! Statics of beams: how Newton's method converges.

use crate::support::beams::beam;
use crate::support::prelude::*;

/// A cantilever of unit length along e1 with a load at its tip.
fn cantilever(EA: f64, elements: usize, load: NodalLoad) -> Context {
    let mut b = ModelBuilder::new();
    let ends = [("root", 0.0), ("tip", 1.0)].map(|(name, x)| b.node(name, [x, 0.0, 0.0]).unwrap());
    let section = Section::diagonal(EA, [EA; 2], 1.0, [1.0; 2]).unwrap();
    beam(&mut b, "rod", ends, elements, section);
    b.support(ends[0], &Dof::ALL);
    b.element("load", load, &ends[1..]).unwrap();
    Context::new(b.build().unwrap())
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
