//! Statics of beams: how Newton's method converges, and what does not belong to a system.

use crate::support::beams::beam_with;
use crate::support::prelude::*;

/// A cantilever of unit length along e1 with a force across its tip.
fn cantilever(EA: f64, elements: usize, interpolation: Interpolation) -> Context {
    let mut b = ModelBuilder::new();
    let ends = [("root", 0.0), ("tip", 1.0)].map(|(name, x)| b.node(name, [x, 0.0, 0.0]).unwrap());
    let section = Section::diagonal(EA, [EA; 2], 1.0, [1.0; 2]).unwrap();
    beam_with(&mut b, "rod", ends, elements, section, interpolation);
    b.support(ends[0], &Dof::ALL);
    let load = NodalLoad::new(LoadKind::DeadForce, [0.0, 2.0, 0.5], Proportional(1.0));
    b.element("load", load, &ends[1..]).unwrap();
    Context::new(b.build().unwrap())
}

#[test]
fn slenderness_does_not_change_the_number_of_iterations() {
    // Plain Newton's method needs more and smaller steps the larger EA L²/EI is; with stresses
    // extrapolated in the tangent it does not (Magisano et al. 2017).
    let count = |EA, interpolation| {
        let mut context = cantilever(EA, 20, interpolation);
        let options = StaticOptions::equal_steps(1);
        let proceed = &mut |_: &mut Context, _: &Step<'_>| ControlFlow::Continue(());
        let summary = solve_statics(&mut context, &mut vec![], &options, proceed).unwrap();
        assert_eq!(summary.rejected, 0);
        summary.iterations
    };
    for interpolation in [Interpolation::Total, Interpolation::Geodesic] {
        let counts = [1e2, 1e4, 1e6, 1e8].map(|EA| count(EA, interpolation));
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(*most <= 10 && most - least <= 2, "{counts:?}");
    }
}

#[test]
fn vectors_of_another_length_and_impossible_events_are_refused() {
    let mut context = cantilever(1e4, 1, Interpolation::Total);
    let path = |events| ArcLengthOptions {
        events,
        ..ArcLengthOptions::default()
    };
    let long = "q has 8 entries; the system has 6 unknowns";
    let statics = StaticOptions::default();
    let loads = LoadSteps::new(&mut context, vec![0.0; 8], &statics).err();
    assert_eq!(loads.unwrap().to_string(), long);
    let steps = PathSteps::new(&mut context, vec![0.0; 8], &path(Vec::new())).err();
    assert_eq!(steps.unwrap().to_string(), long);
    let (newton, shape) = (StaticNewtonOptions::default(), [1.0; 3]);
    let at = Point::statics(0.9, &[0.0; 6]);
    let point = critical_point(&mut context, at, Some(&shape), &newton).err();
    let long = "shape has 3 entries; the system has 6 unknowns";
    assert_eq!(point.unwrap().to_string(), long);
    let (unknown, value) = (6, 0.5);
    for event in [Event::Coordinate { unknown, value }, Event::Load(f64::NAN)] {
        let steps = PathSteps::new(&mut context, Vec::new(), &path(vec![(event, true)])).err();
        assert!(matches!(steps, Some(StaticsError::Event(_))), "{event:?}");
    }
}

#[test]
fn results_are_the_same_to_the_last_bit_in_every_run() {
    let rod = || cantilever(1e4, 30, Interpolation::Geodesic);
    let run = || equilibrium(&mut rod(), &StaticOptions::default()).unwrap();
    assert_eq!(run(), run());
}
