//! The components of a model one by one, with the units of their coordinates.

use crate::elements::FrameAt;
use crate::{CoordinateGroup, Layout, State, plain};
use nalgebra::{DVector, Vector3};
use pullback_elements::element::{Element, Motion};
use pullback_elements::model::{Context, Node, NodeForm};
use pullback_manifold::map::{MapGraph, Parametrization, Read, ToChart, ToPose};
use pullback_manifold::system::{Evaluation, Point, Quantity, System, SystemError};
use std::ops::Range;

/// One component, with its coordinates.
pub(super) struct Component<T> {
    /// What it is called in reports.
    pub name: String,
    pub thing: T,
    pub layout: Layout,
    /// Those of its coordinates that are frames.
    pub frames: Vec<FrameAt>,
    /// First coordinates of rotation vectors that are no frame's.
    pub rotations: Vec<usize>,
}

/// A rotation vector that can be written in another chart: unknowns of its components.
pub(super) type Rotation = [Option<usize>; 3];

pub(super) fn is_frame(node: &Node) -> bool {
    matches!(node.form(), NodeForm::Frame | NodeForm::Pose)
}

/// Element `k` with its layout; `units` are those of the nodes.
pub(super) fn element<'a>(
    context: &'a Context,
    k: usize,
    units: &[f64],
) -> Component<&'a dyn Element> {
    let e = &context.elements()[k];
    let element = e.element();
    let what = if element.properties().load {
        "load"
    } else {
        "element"
    };
    let own = extent(context, e.nodes()).unwrap_or(0.0);
    let unit = |n: usize| if own > 0.0 { own } else { units[n] };
    let name = format!("{what} {} ({})", e.name(), plain(element.kind()));
    component(context, name, element, e.nodes(), &unit)
}

/// The state of element `k`, in its chart, without motion.
pub(super) fn element_state(context: &Context, k: usize, t: f64) -> State {
    let e = &context.elements()[k];
    let x = match e.element().properties().reads_poses {
        true => parent_state(context, e.nodes(), t).x,
        false => {
            let [x, ..] = context.element_motion(k);
            DVector::from_vec(x)
        }
    };
    State::statics(t, x)
}

/// The maps of a model: the node that follows, its map, the nodes that this reads; between the charts of
/// frames, without those from a chart to a pose and back.
pub(super) fn maps(
    context: &Context,
) -> impl Iterator<Item = (u32, Box<dyn Parametrization>, &[u32])> {
    context.mapped_nodes().iter().filter_map(|&n| {
        let node = &context.nodes()[n as usize];
        let map = context.map_of(node)?;
        let parents = node.parents(map.segment());
        let is_pose = |n: &u32| context.nodes()[*n as usize].form() == NodeForm::Pose;
        if let [parent] = parents
            && is_frame(node)
            && is_frame(&context.nodes()[*parent as usize])
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
            graph.add(
                Box::new(ToChart::default()),
                vec![(child, node.range().len())],
            );
        }
        Some((n, Box::new(graph.with_outputs(1)) as Box<_>, parents))
    })
}

/// The map of a node with the layout of what it takes.
pub(super) fn joint<'a>(
    context: &Context,
    (n, map, parents): (u32, &'a dyn Parametrization, &[u32]),
    units: &[f64],
) -> Component<&'a dyn Parametrization> {
    let node = &context.nodes()[n as usize];
    let kind = plain(context.map_of(node).map_or("", |map| map.kind()));
    let name = match is_frame(node) {
        true => format!("joint {} ({kind})", node.name()),
        false if kind == LOOP => format!("{} ({kind})", node.name()),
        false => format!("coordinate {} ({kind})", node.name()),
    };
    component(context, name, map, parents, &|n| units[n])
}

/// The kind of the map of a closed loop, whose node's name says what it is.
const LOOP: &str = "closed loop";

/// The layout of what the map of a node gives.
pub(super) fn rows(context: &Context, n: u32, units: &[f64]) -> Layout {
    component(context, String::new(), (), &[n], &|n| units[n]).layout
}

/// The motion of the parents of a map, in the configuration last set.
pub(super) fn parent_state(context: &Context, parents: &[u32], t: f64) -> State {
    let own = |&m: &u32| context.node_motion(&context.nodes()[m as usize]);
    let all: Vec<[Vec<f64>; 3]> = parents.iter().map(own).collect();
    let [x, v, a] = [0, 1, 2].map(|k| {
        let values: Vec<f64> = all.iter().flat_map(|own| own[k].iter().copied()).collect();
        DVector::from_vec(values)
    });
    State { t, x, v, a }
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
            NodeForm::Rotation => rotations.push(first),
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

/// The largest distance between frames among nodes; `None` where there are none.
fn extent(context: &Context, nodes: &[u32]) -> Option<f64> {
    let positions = || {
        let nodes = nodes.iter().map(|&n| &context.nodes()[n as usize]);
        nodes.filter(|n| is_frame(n)).map(Node::position)
    };
    positions()
        .flat_map(|a| positions().map(move |b| (a - b).norm()))
        .reduce(f64::max)
}

/// A typical length at each node: the size of the smallest element that it belongs to, and of the
/// model where that has none.
pub(super) fn node_units(context: &Context) -> Vec<f64> {
    let mut units = vec![f64::INFINITY; context.nodes().len()];
    for e in context.elements() {
        if let Some(size) = extent(context, e.nodes()).filter(|&l| l > 0.0) {
            for &n in e.nodes() {
                let unit = &mut units[n as usize];
                *unit = unit.min(size);
            }
        }
    }
    // The coordinates of a joint are of the size of what it joins.
    for &n in context.mapped_nodes().iter().rev() {
        let node = &context.nodes()[n as usize];
        let parents = context
            .map_of(node)
            .map_or(&[][..], |map| node.parents(map.segment()));
        let all = || parents.iter().chain([&n]).map(|&m| m as usize);
        let least = all().map(|m| units[m]).fold(f64::INFINITY, f64::min);
        all().for_each(|m| {
            if units[m].is_infinite() {
                units[m] = least
            }
        });
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

/// Rate at which prescribed coordinates change, in radians and lengths of the model, in the
/// configuration last set.
pub(super) fn prescribed_rate(context: &Context) -> f64 {
    let [_, v, a] = context.configuration();
    let own = (context.nodes().iter()).filter(|n| context.map_of(n).is_none());
    let coordinates = own.flat_map(|node| node.range().zip(node.quantities()));
    let rate = |(c, kind): (usize, &Quantity)| {
        let unit = if *kind == Quantity::Length {
            context.length()
        } else {
            1.0
        };
        (v[c].abs() / unit).max((a[c].abs() / unit).sqrt())
    };
    let prescribed = coordinates.filter(|(c, _)| context.unknown_of(*c).is_none());
    prescribed.map(rate).fold(0.0, f64::max)
}

/// For each unknown: its node, which coordinate of the node it is, and what it measures.
pub(super) fn unknowns(context: &Context) -> Vec<(usize, usize, Quantity)> {
    let nodes = context.nodes().iter().enumerate();
    let coordinates = nodes.flat_map(|(n, node)| {
        let own = node.range().zip(node.quantities()).enumerate();
        own.map(move |(k, (c, &kind))| (c, (n, k, kind)))
    });
    let free = coordinates.filter(|(c, _)| context.unknown_of(*c).is_some());
    free.map(|(_, unknown)| unknown).collect()
}

/// Whether a map may give coordinates another meaning.
pub(super) fn reparametrizes(context: &Context) -> bool {
    maps(context).any(|(_, map, _)| map.reparametrizes())
}

/// What a model answers that does not depend on the charts of its nodes, and the residual.
pub(super) struct Snapshot {
    /// Residual of the unknowns, in their charts.
    pub r: Vec<f64>,
    /// Of every frame: position, a direction that turns with it, velocity, angular velocity,
    /// acceleration.
    pub frames: Vec<[Vector3<f64>; 5]>,
}

/// Residual and configuration at a state in motion.
pub(super) fn snapshot(context: &mut Context, s: &State) -> Result<Snapshot, SystemError> {
    let mut r = vec![0.0; s.x.len()];
    let [q, v, a] = [&s.x, &s.v, &s.a].map(|x| x.as_slice());
    context.evaluate(Point { t: s.t, q, v, a }, Evaluation::residual(&mut r))?;
    let direction = Vector3::new(0.48, -0.6, 0.64);
    let frames = context.frames().map(|(n, _)| {
        let n = context.node_state(n);
        [
            n.position,
            n.R * direction,
            n.velocity,
            n.omega,
            n.acceleration,
        ]
    });
    Ok(Snapshot {
        frames: frames.collect(),
        r,
    })
}

/// The power of elements that exert forces at rest but tell of no energy: control forces, say. They
/// count as loads, in the configuration last evaluated in motion.
pub(super) fn silent_power(context: &mut Context, t: f64) -> f64 {
    let mut power = 0.0;
    for k in 0..context.elements().len() {
        let element = context.elements()[k].element();
        let [x, v, _] = context.element_motion(k);
        let rest = Motion {
            t,
            x: &x,
            v: &[],
            a: &[],
            previous: None,
        };
        if element.properties().load || element.energy(&rest) != 0.0 {
            continue;
        }
        // Outside of a domain the evaluation before has failed.
        if let Ok(r) = context.element_forces(k) {
            power += r.iter().zip(&v).map(|(r, v)| r * v).sum::<f64>();
        }
    }
    power
}

/// The coordinates of a node in groups: which, what they are called, what they measure.
fn groups_of(node: &Node) -> Vec<(Range<usize>, String, Quantity)> {
    let name = node.name();
    match node.form() {
        NodeForm::Frame | NodeForm::Pose => vec![
            (
                0..3,
                format!("displacement of node {name}"),
                Quantity::Length,
            ),
            (3..6, format!("rotation of node {name}"), Quantity::Angle),
        ],
        NodeForm::Rotation => vec![(0..3, name.to_owned(), Quantity::Angle)],
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
    let measured = kind == Quantity::Length;
    CoordinateGroup {
        name,
        range,
        unit: if measured { length } else { 1.0 },
        reach: if measured {
            node.position().norm() / length
        } else {
            0.0
        },
    }
}
