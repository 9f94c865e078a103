//! A rigid bar upright on a torsion spring, under a dead load P: P = k θ / (l sin θ) beside θ = 0, on which no load moves it.

use crate::support::dynamics::{grounded, revolute, spring};
use pullback::integrators::linearization::buckling;
use pullback::integrators::statics::{
    ArcLengthOptions, Event, LoadSteps, PathSteps, StaticNewtonOptions, StaticOptions,
    StaticsError, critical_point,
};
use pullback::manifold::system::Point;
use pullback::prelude::*;

/// With k = l = 1.
fn bar() -> Context {
    let (mut b, ground) = grounded();
    let foot = revolute(&mut b, "foot", ground, [0.0, 1.0, 0.0]);
    let top = b.offset("top", foot.frame, [0.0, 0.0, 1.0]).unwrap();
    spring(&mut b, 1.0, foot.coordinates[0]);
    let force = NodalLoad::new(LoadKind::DeadForce, [0.0, 0.0, -1.0], Proportional(1.0));
    b.element("P", force, &[top]).unwrap();
    Context::new(b.build().unwrap())
}

fn options(events: Vec<(Event, bool)>) -> ArcLengthOptions {
    ArcLengthOptions {
        events,
        switch_branch: true,
        ..ArcLengthOptions::default()
    }
}

#[test]
fn it_leaves_the_path_without_displacements() {
    let mut context = bar();
    let options = options(vec![(Event::Bifurcation, false), (Event::Load(1.5), true)]);
    let mut run = PathSteps::new(&mut context, Vec::new(), &options).unwrap();
    let mut critical = None;
    while let Some(step) = run.step().unwrap() {
        critical = critical.or((step.event == Some(0)).then_some(step.t));
    }
    assert!((critical.unwrap() - 1.0).abs() < 1e-10, "{critical:?}");
    let theta = run.q()[0];
    assert!((theta / theta.sin() - 1.5).abs() < 1e-8, "{theta}");
}

#[test]
fn its_critical_load_is_found_although_no_load_moves_it() {
    let found = buckling(&mut bar(), Point::statics(0.0, &[0.0]), 1).unwrap();
    assert!((found[0].load - 1.0).abs() < 1e-10, "{}", found[0].load);
}

#[test]
fn vectors_of_another_length_and_impossible_events_are_refused() {
    let mut context = bar();
    let said = |error: Option<StaticsError>| error.map(|error| error.to_string());
    let long = "q has 2 entries; the system has 1 unknowns";
    let statics = StaticOptions::default();
    let loads = LoadSteps::new(&mut context, vec![0.0; 2], &statics).err();
    assert_eq!(said(loads).as_deref(), Some(long));
    let path = PathSteps::new(&mut context, vec![0.0; 2], &options(Vec::new())).err();
    assert_eq!(said(path).as_deref(), Some(long));
    let (newton, shape) = (StaticNewtonOptions::default(), [1.0; 3]);
    let at = Point::statics(0.9, &[0.0]);
    let point = critical_point(&mut context, at, Some(&shape), &newton).err();
    let long = "shape has 3 entries; the system has 1 unknowns";
    assert_eq!(said(point).as_deref(), Some(long));
    let (unknown, value) = (1, 0.5);
    for event in [Event::Coordinate { unknown, value }, Event::Load(f64::NAN)] {
        let path = PathSteps::new(&mut context, Vec::new(), &options(vec![(event, true)])).err();
        assert!(matches!(path, Some(StaticsError::Event(_))), "{event:?}");
    }
}
