//! Validation, numbering and pattern of a model.

use crate::element::{Motion, Response};
use crate::model::assembly::scatter_map::ScatterMap;
use crate::model::assembly::workspace::Workspace;
use crate::model::build::builder::{ModelBuilder, NodeId};
use crate::model::build::connections::check_connections;
use crate::model::build::dependency_graph::{self, Alternatives, ancestors};
use crate::model::build::elimination_order::outward;
use crate::model::build::prescribed::{
    check_reparametrized, prescribed_rotations, resolve_prescribed,
};
use crate::model::constraints::start;
use crate::model::kinematics::formulation;
use crate::model::kinematics::pose::mark_unread;
use crate::model::loops;
use crate::model::state::ModelState;
use crate::model::{
    Context, ElementEntry, Model, ModelError, NONE, Node, NodeForm, Nodes, Prescribed, Span,
};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{CoordinateInfo, Quantity};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Extent of the nodes over the radius of gyration, below which their positions differ by rounding errors.
const ONE_PLACE: f64 = 1e-12;

impl ModelBuilder {
    /// Checks the model, numbers its unknowns and finds the pattern.
    ///
    /// # Errors
    /// [`ModelError`] with the cause.
    pub fn build(mut self) -> Result<Model, ModelError> {
        let (extent, gyration) = (extent(&self.nodes), gyration(&self));
        let [length, extent] = match extent > ONE_PLACE * gyration.unwrap_or(0.0) {
            true => [extent; 2],
            false => [gyration.unwrap_or(1.0), 0.0],
        };
        start::check_values(&self.nodes, &self.starts, length)?;
        let (forces, enforced) = self.enforce_closings(length)?;
        if self.nodes.is_empty() {
            return Err(ModelError::Empty);
        }
        let prescribed: Vec<NodeId> = self.prescribed.iter().map(|(n, ..)| *n).collect();
        self.check_own(&prescribed, || "a support or prescribed motion".to_owned())?;
        let starts: Vec<NodeId> = self.starts.keys().map(|(n, _)| *n).collect();
        self.check_own(&starts, || "an initial value".to_owned())?;
        let (mut reports, positions) = self.close_loops(&enforced, length)?;
        self.add_dummy_dof(&reports)?;
        reports.extend(forces);
        let starts = std::mem::take(&mut self.starts);
        assembled(
            self.numbered(reports, [length, extent])?,
            starts,
            &positions,
        )
    }

    /// The model with its unknowns numbered and the positions of all tangents, not assembled.
    fn numbered(
        self,
        reports: Vec<loops::LoopReport>,
        [length, extent]: [f64; 2],
    ) -> Result<Model, ModelError> {
        let Self {
            mut nodes,
            mut elements,
            mut prescribed,
            closings,
            rotations,
            inputs,
            carried,
            ..
        } = self;
        formulation::apply(rotations, &mut nodes, &mut prescribed);
        arrange_coordinates(&mut nodes);
        mark_unread(&mut nodes, &elements);
        let mut nodes = Nodes {
            mapped: dependency_graph::order(&nodes),
            all: nodes,
        };
        let alternatives = Alternatives::new(&nodes)?;
        let operators = dependency_graph::arrange(&mut nodes);
        let mut prescribed = resolve_prescribed(&nodes, prescribed)?;
        check_connections(&nodes, &elements, &closings, &prescribed)?;
        check_reparametrized(&nodes, &elements, &prescribed)?;

        let numbering = Numbering::new(&nodes, &elements, &prescribed);
        let quantities: Vec<Quantity> = nodes.iter().flat_map(|n| n.quantities.clone()).collect();
        let infos: Vec<CoordinateInfo> = nodes.iter().flat_map(|n| infos(n, length)).collect();
        let pattern = pattern(&elements, &alternatives, &numbering)
            .with_coordinates(|i| infos[numbering.coordinates[i]]);
        let Numbering {
            unknowns,
            coordinates,
            mut scatter_map,
            ..
        } = numbering;
        mark(&mut elements, &nodes, &scatter_map.rows);
        let [coupled, scratch] = scatter_map.arrange(&nodes, &elements);
        prescribed.sort_unstable_by_key(|p| p.coordinate);
        let levers = levers(&nodes, &elements, extent);
        let room = [operators, coupled, scratch];
        let is_enforced = |k: &usize| elements[*k].element.abilities().enforced.is_some();
        let mut model = Model {
            spans: nodes.iter().map(Span::of).collect(),
            spin_frames: formulation::turning(&nodes).collect(),
            reports,
            enforced: (0..elements.len()).filter(is_enforced).collect(),
            initial: Vec::new(),
            start: ModelState::default(),
            prescribed_rotations: prescribed_rotations(&nodes, &prescribed),
            quantities,
            work: Workspace::new(&nodes, &elements, room, scatter_map, length, levers),
            nodes,
            carried,
            elements,
            prescribed,
            coordinates,
            unknowns,
            length,
            pattern,
        };
        model.start = ModelState::new(&model, inputs);
        Ok(model)
    }

    /// Closes loops by maps; returns the reports, and the start of loops that are closed by forces.
    fn close_loops(
        &mut self,
        enforced: &[loops::Closing],
        length: f64,
    ) -> Result<(Vec<loops::LoopReport>, loops::Positions), ModelError> {
        let mut preferred = std::mem::take(&mut self.preferred);
        preferred.extend(self.starts.keys().map(|&(n, _)| n));
        let used = self.elements.iter().flat_map(|e| e.nodes.iter());
        preferred.extend(used.map(|&n| NodeId(n)));
        let setting = loops::Setting {
            functions: &self.prescribed,
            inputs: &self.inputs,
            starts: &self.starts,
            preferred: &preferred,
            length,
        };
        let given = self.nodes.len() as u32;
        let nodes = &mut self.nodes;
        let reports = loops::close(nodes, &self.closings, &setting)?;
        let mut starts = self.starts.clone();
        // A loop that a map closes has its values where its own coordinates are zero.
        for &(NodeId(n), _) in self.starts.keys() {
            for m in ancestors(nodes, &[n], None, |d| &d.segments) {
                let dim = nodes[m as usize].dim;
                let new = (0..dim).filter(|_| m >= given && nodes[m as usize].is_own());
                starts.extend(new.map(|k| ((NodeId(m), k), 0.0)));
            }
        }
        let setting = loops::Setting {
            starts: &starts,
            ..setting
        };
        let positions = loops::positions(nodes, enforced, &setting);
        self.starts = starts;
        Ok((reports, positions))
    }
}

/// Numbers the coordinates of all nodes.
fn arrange_coordinates(nodes: &mut [Node]) {
    let mut total = 0;
    for node in nodes {
        node.first = total;
        total += node.dim;
    }
}

/// Notes which elements have prescribed and mapped coordinates.
fn mark(elements: &mut [ElementEntry], nodes: &[Node], rows: &[u32]) {
    for e in elements {
        let held = |&n: &u32| rows[nodes[n as usize].range()].contains(&NONE);
        e.dependent_coordinates = e.nodes.iter().any(held);
        e.mapped = e.nodes.iter().any(|&n| !nodes[n as usize].is_own());
    }
}

/// The pattern, with room for all nodes that an element may depend on; a joint without elements carries
/// no force.
fn pattern(
    elements: &[ElementEntry],
    alternatives: &Alternatives,
    numbering: &Numbering,
) -> BlockPattern {
    let (blocks, sizes) = (&numbering.scatter_map.blocks, &numbering.sizes);
    // Elements on one body all have the same set.
    let sets: HashSet<Vec<u32>> = elements
        .iter()
        .flat_map(|e| alternatives.of(&e.nodes))
        .collect();
    let block = |n: &u32| Some(blocks[*n as usize]).filter(|&b| b != NONE);
    let blocks_of = |set: Vec<u32>| -> Vec<u32> { set.iter().filter_map(block).collect() };
    BlockPattern::new(sizes, sets.into_iter().map(blocks_of))
}

/// The model with its loops assembled from initial values.
fn assembled(
    model: Model,
    starts: HashMap<(NodeId, usize), f64>,
    positions: &[(u32, usize, f64)],
) -> Result<Model, ModelError> {
    let mut starts: Vec<((NodeId, usize), f64)> = starts.into_iter().collect();
    starts.sort_unstable_by_key(|v| v.0);
    let values: Vec<(usize, f64)> = (starts.into_iter())
        .filter_map(|((n, k), x)| Some((model.unknown_at(n, k)?, x)))
        .collect();
    let mut context = Context::new(model);
    context.locate_tangents();
    context.start_element_charts(0.0, &vec![0.0; context.coordinates.len()]);
    let initial = context.assemble_enforced(&values, positions)?;
    let Context { model, state, work } = context;
    let mut model = Arc::unwrap_or_clone(model);
    (model.initial, model.start, model.work) = (initial, state, work);
    Ok(model)
}

/// The unknowns, block by block, away from the supports.
struct Numbering {
    /// Unknown of each coordinate, or [`NONE`].
    unknowns: Vec<u32>,
    /// Coordinate of each unknown.
    coordinates: Vec<usize>,
    /// Number of unknowns of each block.
    sizes: Vec<usize>,
    /// Rows and blocks, without positions.
    scatter_map: ScatterMap,
}

impl Numbering {
    fn new(nodes: &Nodes, elements: &[ElementEntry], prescribed: &[Prescribed]) -> Self {
        let own = |n: &Node| std::iter::repeat_n(n.is_own(), n.dim);
        let mut free: Vec<bool> = nodes.iter().flat_map(own).collect();
        for p in prescribed {
            free[p.coordinate] = false;
        }
        let mut out = Self {
            unknowns: vec![NONE; free.len()],
            coordinates: Vec::new(),
            sizes: Vec::new(),
            scatter_map: ScatterMap::new(nodes.len(), free.len()),
        };
        for n in outward(nodes, elements, prescribed) {
            let mut size = 0;
            for c in nodes[n].range().filter(|&c| free[c]) {
                out.unknowns[c] = out.coordinates.len() as u32;
                out.coordinates.push(c);
                out.scatter_map.rows[c] = size;
                size += 1;
            }
            if size > 0 {
                out.scatter_map.blocks[n] = out.sizes.len() as u32;
                out.sizes.push(size as usize);
            }
        }
        out
    }
}

/// The kinds of the coordinates of a node in a model of this size.
fn infos(node: &Node, length: f64) -> impl Iterator<Item = CoordinateInfo> + '_ {
    node.quantities.iter().map(move |&quantity| CoordinateInfo {
        quantity,
        size: quantity.size(length),
        magnitude: Some(match quantity {
            Quantity::Length if node.is_frame() => node.position.norm(),
            Quantity::Length => length,
            Quantity::Angle | Quantity::Other => 1.0,
        }),
        is_multiplier: node.form == NodeForm::Multipliers,
    })
}

/// Shortest and longest lever of the model: the least distance between different node positions of
/// an element or a joint, and the extent of the whole; zero and infinity if there is none.
fn levers(nodes: &[Node], elements: &[ElementEntry], extent: f64) -> [f64; 2] {
    if extent == 0.0 {
        return [0.0, f64::INFINITY];
    }
    let mut shortest = f64::INFINITY;
    let mut look = |group: &[u32]| {
        let all = group.iter().map(|&n| &nodes[n as usize]);
        let frames: Vec<&Node> = all.filter(|n| n.is_frame()).collect();
        for (i, a) in frames.iter().enumerate() {
            let apart = frames[..i].iter();
            let apart = apart.map(|b| (a.position - b.position).norm());
            let apart = apart.filter(|d| *d > f64::EPSILON * extent);
            shortest = apart.fold(shortest, f64::min);
        }
    };
    for e in elements {
        look(&e.nodes);
    }
    for (n, node) in (0..).zip(nodes).filter(|(_, node)| node.is_frame()) {
        for parents in node.segments() {
            look(&[parents, &[n][..]].concat());
        }
    }
    [if shortest.is_finite() { shortest } else { 0.0 }, extent]
}

/// Diagonal of the box around all frames; zero if all have the same position.
fn extent(nodes: &[Node]) -> f64 {
    let corner = |pick: fn(f64, f64) -> f64| {
        let frames = nodes.iter().filter(|n| n.is_frame()).map(|n| n.position);
        frames
            .reduce(|a, b| a.zip_map(&b, pick))
            .unwrap_or_default()
    };
    (corner(f64::max) - corner(f64::min)).norm()
}

/// Radius of gyration of all bodies about their nodes: the size of a model whose nodes have one position.
fn gyration(builder: &ModelBuilder) -> Option<f64> {
    let (mut mass, mut inertia) = (0.0, 0.0);
    let bodies = builder.elements.iter().filter(|e| e.nodes.len() == 1);
    for ElementEntry { element, nodes, .. } in bodies {
        let n = element.dim();
        let (zeros, mut r, mut M) = (vec![0.0; n], vec![0.0; n], vec![0.0; n * n]);
        let at = Motion {
            t: 0.0,
            inputs: &builder.inputs,
            x: &zeros,
            v: &zeros,
            a: &zeros,
            previous: None,
        };
        let mut out = Response {
            r: &mut r,
            K: None,
            C: None,
            M: Some(&mut M),
            r_t: None,
        };
        element.evaluate(&at, &mut out).ok()?;
        let nodes = nodes.iter().map(|&k| &builder.nodes[k as usize]);
        let quantities = nodes.flat_map(|node| &node.quantities);
        for (quantity, m) in quantities.zip(M.iter().step_by(n + 1)) {
            match quantity {
                Quantity::Length => mass += m / 3.0,
                Quantity::Angle => inertia += m / 2.0,
                Quantity::Other => {}
            }
        }
    }
    let radius = f64::sqrt(inertia / mass);
    (radius > 0.0 && radius.is_finite()).then_some(radius)
}
