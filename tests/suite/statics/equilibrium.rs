//! Statics of beams: how Newton's method converges, and what does not belong to a system.

use crate::support::beams::beam_with;
use crate::support::prelude::*;

/// A cantilever of unit length along e1 with a force across its tip, or across that of a second beam behind a rigid link.
fn frame((EA, elements, interpolation): (f64, usize, Interpolation), linked: bool) -> Context {
    let mut b = ModelBuilder::new();
    let section = Section::diagonal(EA, [EA; 2], 1.0, [1.0; 2]).unwrap();
    let rod = |b: &mut ModelBuilder, name, from, tip| {
        let tip = b.node(format!("tip of {name}"), tip).unwrap();
        beam_with(b, name, [from, tip], elements, section, interpolation);
        tip
    };
    let root = b.node("root", [0.0; 3]).unwrap();
    let mut tip = rod(&mut b, "rod", root, [1.0, 0.0, 0.0]);
    if linked {
        let link = b.offset("link", tip, [1.0, 0.5, 0.0]).unwrap();
        tip = rod(&mut b, "arm", link, [2.0, 0.5, 0.0]);
    }
    b.support(root, &Dof::ALL);
    let load = NodalLoad::new(LoadKind::DeadForce, [0.0, 2.0, 0.5], Proportional(1.0));
    b.element("load", load, &[tip]).unwrap();
    Context::new(b.build().unwrap())
}

fn cantilever(EA: f64, elements: usize, interpolation: Interpolation) -> Context {
    frame((EA, elements, interpolation), false)
}

/// The iterations of load steps, none of which may be rejected.
fn iterations(mut context: Context, steps: usize) -> usize {
    let options = StaticOptions::equal_steps(steps);
    let proceed = &mut |_: &mut Context, _: &Step<'_>| ControlFlow::Continue(());
    let summary = solve_statics(&mut context, &mut vec![], &options, proceed).unwrap();
    assert_eq!(summary.rejected, 0);
    summary.iterations
}

#[test]
fn slenderness_does_not_change_the_number_of_iterations() {
    // Plain Newton's method needs more and smaller steps the larger EA L²/EI is; with stresses
    // extrapolated in the tangent it does not (Magisano et al. 2017).
    for interpolation in [Interpolation::Total, Interpolation::Geodesic] {
        let counts =
            [1e2, 1e4, 1e6, 1e8].map(|EA| iterations(cantilever(EA, 20, interpolation), 1));
        let (least, most) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        assert!(*most <= 10 && most - least <= 2, "{counts:?}");
    }
}

#[test]
fn rigid_links_between_slender_beams_do_not_change_the_number_of_iterations() {
    // A correction is not linear at a mapped node: stresses extrapolated from it would be as wrong as those of the iterate.
    for interpolation in [Interpolation::Total, Interpolation::Geodesic] {
        let counts =
            [1e2, 1e4, 1e6, 1e8].map(|EA| iterations(frame((EA, 10, interpolation), true), 5));
        assert!(counts.iter().all(|n| *n <= 50), "{counts:?}");
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
