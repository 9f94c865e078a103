//! The components of a model one by one, with the units of their coordinates.

use crate::elements::{Component, FrameAt};
use crate::maps::plain;
use crate::vectors::dot;
use crate::{CoordinateGroup, Layout, TestState};
use nalgebra::{DVector, Vector3};
use pullback_elements::element::{Element, Motion};
use pullback_elements::model::{Context, Node, NodeForm};
use pullback_manifold::map::{MapGraph, Parametrization, Read, ToChart, ToPose};
use pullback_manifold::system::{
    Energetics, Energies, Evaluation, Events, Quantity, System, SystemError,
};
use std::ops::Range;

/// Element `k` with its layout; `units` are those of the nodes.
pub(super) fn element<'a>(
    context: &'a Context,
    k: usize,
    units: &[f64],
) -> Component<&'a dyn Element> {
    let e = &context.elements()[k];
    let element = e.element();
    let load = element.properties().load;
    let what = if load { "load" } else { "element" };
    let own = extent(context, e.nodes());
    let unit = |n: usize| if own > 0.0 { own } else { units[n] };
    let name = format!("{what} {} ({})", e.name(), plain(element.kind()));
    component(context, name, element, e.nodes(), &unit)
}

/// The state of element `k`, in its chart, without motion.
pub(super) fn element_state(context: &Context, k: usize, t: f64) -> TestState {
    let e = &context.elements()[k];
    let x = match e.element().properties().reads_poses {
        true => parent_state(context, e.nodes(), t).x,
        false => {
            let [x, ..] = context.element_motion(k);
            DVector::from_vec(x)
        }
    };
    TestState::statics(t, x)
}

/// The maps of a model between the charts of frames: the mapped node, its map, the parents. Maps from a chart to a pose
/// and back are left out.
pub(super) fn maps(
    context: &Context,
) -> impl Iterator<Item = (u32, Box<dyn Parametrization>, &[u32])> {
    context.mapped_nodes().iter().filter_map(|&n| {
        let node = &context.nodes()[n as usize];
        let map = context.map_of(node)?;
        let parents = node.parents(map.segment());
        let is_pose = |n: &u32| context.nodes()[*n as usize].form() == NodeForm::Pose;
        if let [parent] = parents
            && node.is_frame()
            && context.nodes()[*parent as usize].is_frame()
            && is_pose(&n) != is_pose(parent)
        {
            return None;
        }
        if !parents.iter().chain([&n]).any(is_pose) {
            return Some((n, map.duplicate(), parents));
        }
        let mut graph = MapGraph::new(map.dims().0);
        let mut first = 0;
        let mut reads = Vec::new();
        for m in parents {
            let len = context.nodes()[*m as usize].range().len();
            let read = match is_pose(m) {
                true => graph.add(Box::new(ToPose), vec![(Read::Input(first), len)]),
                false => Read::Input(first),
            };
            reads.push((read, len));
            first += len;
        }
        let child = graph.add(map.duplicate(), reads);
        if is_pose(&n) {
            let read = vec![(child, node.range().len())];
            graph.add(Box::new(ToChart::default()), read);
        }
        Some((n, Box::new(graph.with_outputs(1)) as Box<_>, parents))
    })
}

/// The map of a node with the layout of its coordinates.
pub(super) fn joint<'a>(
    context: &Context,
    (n, map, parents): (u32, &'a dyn Parametrization, &[u32]),
    units: &[f64],
) -> Component<&'a dyn Parametrization> {
    let node = &context.nodes()[n as usize];
    let kind = plain(context.map_of(node).map_or("", |map| map.kind()));
    let name = match node.is_frame() {
        true => format!("joint {} ({kind})", node.name()),
        false if kind == LOOP => format!("{} ({kind})", node.name()),
        false => format!("coordinate {} ({kind})", node.name()),
    };
    component(context, name, map, parents, &|n| units[n])
}

/// The kind of the map of a closed loop, whose node has a name of its own.
const LOOP: &str = "closed loop";

/// The layout of the values of a node's map.
pub(super) fn rows(context: &Context, n: u32, units: &[f64]) -> Layout {
    component(context, String::new(), (), &[n], &|n| units[n]).layout
}

/// The motion of the parents of a map in the present configuration.
pub(super) fn parent_state(context: &Context, parents: &[u32], t: f64) -> TestState {
    let own = |&m: &u32| context.node_motion(&context.nodes()[m as usize]);
    let all: Vec<[Vec<f64>; 3]> = parents.iter().map(own).collect();
    let part = |k: usize| all.iter().flat_map(move |own| own[k].iter().copied());
    let [x, v, a] = [0, 1, 2].map(|k| DVector::from_vec(part(k).collect()));
    TestState { t, x, v, a }
}

fn component<T>(
    context: &Context,
    name: String,
    thing: T,
    nodes: &[u32],
    unit: &dyn Fn(usize) -> f64,
) -> Component<T> {
    let (mut groups, mut first) = (Vec::new(), 0);
    let (mut frames, mut rotations) = (Vec::new(), Vec::new());
    for &n in nodes {
        let node = &context.nodes()[n as usize];
        for (range, name, kind) in groups_of(node) {
            let range = range.start + first..range.end + first;
            groups.push(group(node, range, name, kind, unit(n as usize)));
        }
        match node.form() {
            NodeForm::Frame | NodeForm::Pose => frames.push(FrameAt {
                first,
                position: node.position(),
            }),
            NodeForm::Rotation if is_alone(node) => rotations.push(first),
            _ => {}
        }
        first += node.range().len();
    }
    Component {
        name,
        thing,
        layout: Layout::new(groups),
        frames,
        rotations,
    }
}

/// The largest distance between frames among nodes, unless it is a rounding error of their positions.
fn extent(context: &Context, nodes: &[u32]) -> f64 {
    let positions = || {
        let nodes = nodes.iter().map(|&n| &context.nodes()[n as usize]);
        nodes.filter(|n| n.is_frame()).map(Node::position)
    };
    positions()
        .flat_map(|a| positions().map(move |b| (a - b).norm()))
        .filter(|distance| *distance > 1e-12 * context.length())
        .fold(0.0, f64::max)
}

/// A typical length at each node: that of the smallest element at the node, or else of the model.
pub(super) fn node_units(context: &Context) -> Vec<f64> {
    let mut units = vec![f64::INFINITY; context.nodes().len()];
    for e in context.elements() {
        let size = extent(context, e.nodes());
        for &n in e.nodes().iter().filter(|_| size > 0.0) {
            let unit = &mut units[n as usize];
            *unit = unit.min(size);
        }
    }
    // The unit of a joint's coordinates is that of the joined parts.
    for &n in context.mapped_nodes().iter().rev() {
        let node = &context.nodes()[n as usize];
        let map = context.map_of(node);
        let parents = map.map_or(&[][..], |map| node.parents(map.segment()));
        let all = || parents.iter().chain([&n]).map(|&m| m as usize);
        let least = all().map(|m| units[m]).fold(f64::INFINITY, f64::min);
        for m in all() {
            if units[m].is_infinite() {
                units[m] = least;
            }
        }
    }
    let missing = units.iter_mut().filter(|u| u.is_infinite());
    missing.for_each(|u| *u = context.length());
    units
}

/// The layout of the unknowns.
pub(super) fn layout(context: &Context, units: &[f64]) -> Layout {
    let mut groups: Vec<CoordinateGroup> = Vec::new();
    for (n, node) in context.nodes().iter().enumerate() {
        for (range, name, kind) in groups_of(node) {
            let all = range.start + node.range().start..range.end + node.range().start;
            let mut unknowns = all.filter_map(|c| context.unknown_of(c));
            if let Some(first) = unknowns.next() {
                let range = first..first + 1 + unknowns.count();
                groups.push(group(node, range, name, kind, units[n]));
            }
        }
    }
    Layout::new(groups)
}

/// The rate of prescribed coordinates, in radians and lengths of the model, in the present configuration.
pub(super) fn prescribed_rate(context: &Context) -> f64 {
    let [_, v, a] = context.configuration();
    let own = (context.nodes().iter()).filter(|n| context.map_of(n).is_none());
    let coordinates = own.flat_map(|node| node.range().zip(node.quantities()));
    let rate = |(c, kind): (usize, &Quantity)| {
        let unit = match kind {
            Quantity::Length => context.length(),
            _ => 1.0,
        };
        (v[c].abs() / unit).max((a[c].abs() / unit).sqrt())
    };
    let prescribed = coordinates.filter(|(c, _)| context.unknown_of(*c).is_none());
    prescribed.map(rate).fold(0.0, f64::max)
}

/// For each unknown its node, its number among the coordinates of the node, and its quantity.
pub(super) fn unknowns(context: &Context) -> Vec<(usize, usize, Quantity)> {
    let nodes = context.nodes().iter().enumerate();
    let coordinates = nodes.flat_map(|(n, node)| {
        let own = node.range().zip(node.quantities()).enumerate();
        own.map(move |(k, (c, &kind))| (c, (n, k, kind)))
    });
    let free = coordinates.filter_map(|(c, of)| Some((context.unknown_of(c)?, of)));
    // They are numbered in another order.
    let mut free: Vec<_> = free.collect();
    free.sort_unstable_by_key(|(u, _)| *u);
    free.into_iter().map(|(_, of)| of).collect()
}

/// Whether a map may reparametrize.
pub(super) fn reparametrizes(context: &Context) -> bool {
    let mapped = context.mapped_nodes().iter();
    let mut maps = mapped.filter_map(|&n| context.map_of(&context.nodes()[n as usize]));
    maps.any(|map| map.duplicate().reparametrization().is_some())
}

/// Motion and energies of a model, which do not depend on charts, and its residual.
pub(super) struct Observables {
    /// Residual of the unknowns, in their charts.
    pub r: Vec<f64>,
    /// For each frame its position, a direction fixed in it, velocity, angular velocity and acceleration.
    pub frames: Vec<[Vector3<f64>; 5]>,
    pub energies: Energies,
}

/// Evaluates a model at a state in motion.
pub(super) fn observables(
    context: &mut Context,
    s: &TestState,
) -> Result<Observables, SystemError> {
    let mut r = vec![0.0; s.x.len()];
    context.evaluate(s.point(), Evaluation::residual(&mut r))?;
    let direction = Vector3::new(0.48, -0.6, 0.64);
    let frames = context.frames().map(|(n, _)| {
        let n = context.node_state(n);
        let direction = n.R * direction;
        [n.position, direction, n.velocity, n.omega, n.acceleration]
    });
    let frames = frames.collect();
    let energies = context.energies(s.point())?;
    Ok(Observables {
        r,
        frames,
        energies,
    })
}

/// The power of elements that exert forces at rest and have no energy, such as control forces, in the last evaluated
/// motion. They count as loads.
pub(super) fn silent_power(context: &mut Context, t: f64) -> f64 {
    let mut power = 0.0;
    let inputs = Events::inputs(context).to_vec();
    for k in 0..context.elements().len() {
        let element = context.elements()[k].element();
        let [x, v, _] = context.element_motion(k);
        let rest = Motion {
            t,
            inputs: &inputs,
            x: &x,
            v: &[],
            a: &[],
            previous: None,
        };
        if element.properties().load || element.abilities().energy(&rest) != 0.0 {
            continue;
        }
        // Outside of a domain the previous evaluation has failed.
        power += context.element_forces(k).map_or(0.0, |r| dot(&r, &v));
    }
    power
}

/// Whether a rotation is that of a child itself, not relative to its parent.
fn is_alone(node: &Node) -> bool {
    node.quantities().len() == 3
}

/// The groups of a node's coordinates: their numbers, name and quantity.
fn groups_of(node: &Node) -> Vec<(Range<usize>, String, Quantity)> {
    let name = node.name();
    match node.form() {
        NodeForm::Frame | NodeForm::Pose => {
            let [displacement, rotation] =
                ["displacement", "rotation"].map(|what| format!("{what} of node {name}"));
            vec![
                (0..3, displacement, Quantity::Length),
                (3..6, rotation, Quantity::Angle),
            ]
        }
        NodeForm::Rotation if is_alone(node) => vec![(0..3, name.to_owned(), Quantity::Angle)],
        _ => (node.quantities().iter().enumerate())
            .map(|(k, &kind)| (k..k + 1, node.coordinate_name(k), kind))
            .collect(),
    }
}

fn group(
    node: &Node,
    range: Range<usize>,
    name: String,
    kind: Quantity,
    length: f64,
) -> CoordinateGroup {
    let (unit, reach) = match kind {
        Quantity::Length => (length, node.position().norm() / length),
        _ => (1.0, 0.0),
    };
    CoordinateGroup {
        name,
        range,
        unit,
        reach,
    }
}
