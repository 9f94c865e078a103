//! What graphs keep of the maps in them.

use crate::support::*;
use nalgebra::Vector1;

/// The ordinate of a point on the unit circle, less 0.8, of its abscissa.
fn ordinate(choice: Choice) -> MapGraph {
    let circle = ImplicitMap::of(Circle, 1, 0.0, [0.5, 0.9], choice).unwrap();
    let mut graph = MapGraph::new(1);
    let point = graph.add(Box::new(circle), vec![(Read::Input(0), 1)]);
    graph.add(Linear::<2, 1>::pick(1, 0.8).boxed(), vec![(point, 2)]);
    graph.with_outputs(1)
}

#[test]
fn a_graph_saves_and_restores_the_state_of_its_maps() {
    let mut moved: Box<dyn Parametrization> = Box::new(ordinate(Choice::Fixed));
    let mut fresh = moved.clone();
    let at_start = fresh.save();
    moved.state().unwrap().change_charts(0.0, &[0.2]);
    let saved = moved.save();
    assert_ne!(saved, at_start);
    for wrong in [&saved[1..], &[], &[&saved[..], &[0.0]].concat()] {
        assert!(!fresh.clone().restore(wrong));
    }
    assert!(fresh.restore(&saved));
    assert_eq!(fresh.save(), saved);
    let [moved, fresh] = [moved, fresh].map(|map| tangent(&*map, 0.0, &[0.25]));
    assert_eq!(moved, fresh);
}

#[test]
fn an_implicit_map_saves_and_restores_the_state_of_its_equations() {
    let equations = Box::new(ordinate(Choice::Fixed));
    let map = ImplicitMap::new(equations.clone(), about(&[None], 1), 0.0, &[]).unwrap();
    let mut moved: Box<dyn Parametrization> = Box::new(map);
    let mut fresh = moved.clone();
    moved.state().unwrap().change_charts(0.3, &[]);
    let saved = moved.save();
    let own = saved.len() - equations.save().len();
    assert!(own < saved.len() && !fresh.restore(&saved[..own]));
    assert!(fresh.restore(&saved));
    assert_eq!(fresh.save(), saved);
}

/// A height above the ground.
#[derive(Clone)]
struct Height;

impl Map<1, 1> for Height {
    fn phi<S: Scalar>(&self, _t: S, q: &Vector1<S>) -> Vector1<S> {
        *q
    }

    fn is_objective(&self) -> bool {
        false
    }
}

#[test]
fn a_graph_is_objective_if_its_maps_are() {
    for (map, objective) in [
        (Height.boxed(), false),
        (Linear::sum([2.0], 0.0).boxed(), true),
    ] {
        let mut graph = MapGraph::new(1);
        graph.add(map, vec![(Read::Input(0), 1)]);
        assert_eq!(graph.is_objective(), objective);
    }
}

#[test]
fn maps_of_a_graph_keep_their_coordinates() {
    let circle = ImplicitMap::of(Circle, 1, 0.0, [0.5, 0.9], Choice::Split);
    assert!(circle.unwrap().reparametrization().is_some());
    assert!(ordinate(Choice::Split).reparametrization().is_none());
    assert!(ordinate(Choice::Fixed).reparametrization().is_none());
}
