//! Building a model: nodes, elements, supports; then one check of the whole and the numbering.

use super::assembly::{MAX_NODES, Workspace};
use super::dependence::{self, Dependence};
use super::placement::Placement;
use super::{Attached, Form, Model, ModelError, NONE, Node, Prescribed, Source, Span};
use crate::element::Element;
use crate::time::{Constant, TimeFunction};
use nalgebra::Vector3;
use pullback_manifold::map::Parametrization;
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{Kind, Point};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Coordinates of a frame node.
pub(super) const FRAME: usize = 6;

/// What the coordinates of a frame node measure.
pub(super) const FRAME_KINDS: [Kind; FRAME] = {
    use Kind::{Angle, Length};
    [Length, Length, Length, Angle, Angle, Angle]
};

/// A node of the builder that made it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub(crate) u32);

/// An element of the builder that made it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ElementId(pub(crate) u32);

/// The six coordinates of a frame node, in global components.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dof {
    /// Displacement along e1.
    X,
    /// Displacement along e2.
    Y,
    /// Displacement along e3.
    Z,
    /// Rotation vector component about e1.
    RX,
    /// Rotation vector component about e2.
    RY,
    /// Rotation vector component about e3.
    RZ,
}

impl Dof {
    /// All six, in the order of the coordinates.
    pub const ALL: [Self; FRAME] = [Self::X, Self::Y, Self::Z, Self::RX, Self::RY, Self::RZ];
    /// The three displacements.
    pub const TRANSLATIONS: [Self; 3] = [Self::X, Self::Y, Self::Z];
    /// The three rotations.
    pub const ROTATIONS: [Self; 3] = [Self::RX, Self::RY, Self::RZ];

    /// Position among the six coordinates.
    pub fn index(self) -> usize {
        self as usize
    }
}

/// Names of the six coordinates of a frame.
pub(super) const DOF_NAMES: [&str; FRAME] = [
    "displacement along e1",
    "displacement along e2",
    "displacement along e3",
    "rotation about e1",
    "rotation about e2",
    "rotation about e3",
];

/// Collects a model and checks it when [`ModelBuilder::build`] is called.
#[derive(Default)]
pub struct ModelBuilder {
    nodes: Vec<Node>,
    names: HashMap<String, NodeId>,
    elements: Vec<Attached>,
    prescribed: Vec<(NodeId, usize, Box<dyn TimeFunction>)>,
}

impl ModelBuilder {
    /// An empty model.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a frame node (displacement and rotation, six coordinates) at a reference place.
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`], [`ModelError::NotFinite`].
    pub fn node(&mut self, name: impl Into<String>, place: [f64; 3]) -> Result<NodeId, ModelError> {
        self.add_node(name.into(), place, Form::Frame, &FRAME_KINDS, Source::Own)
    }

    /// Adds coordinates that are no frame: those a joint releases, say.
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`].
    pub fn coordinates(
        &mut self,
        name: impl Into<String>,
        kinds: &[Kind],
    ) -> Result<NodeId, ModelError> {
        self.add_node(name.into(), [0.0; 3], Form::Coordinates, kinds, Source::Own)
    }

    /// Adds a rotation vector of its own: the three coordinates that a spherical joint releases.
    /// It changes its chart like that of a frame.
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`].
    pub fn rotation(&mut self, name: impl Into<String>) -> Result<NodeId, ModelError> {
        let kinds = [Kind::Angle; 3];
        self.add_node(name.into(), [0.0; 3], Form::Rotation, &kinds, Source::Own)
    }

    /// Adds a frame node whose six coordinates follow from those of `masters` through a map.
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`], [`ModelError::NotFinite`]; [`ModelError::JointDimension`] when
    /// the map does not take the masters' coordinates to six; [`ModelError::ForeignNode`].
    pub fn mapped_node(
        &mut self,
        name: impl Into<String>,
        place: [f64; 3],
        map: Box<dyn Parametrization>,
        masters: &[NodeId],
    ) -> Result<NodeId, ModelError> {
        self.mapped_node_along(name, place, map, &[masters])
    }

    /// As [`ModelBuilder::mapped_node`], for a map that travels along several sets of masters
    /// ([`Map::segment`](pullback_manifold::map::Map::segment) tells which one it reads).
    ///
    /// # Errors
    /// As [`ModelBuilder::mapped_node`].
    pub fn mapped_node_along(
        &mut self,
        name: impl Into<String>,
        place: [f64; 3],
        map: Box<dyn Parametrization>,
        segments: &[&[NodeId]],
    ) -> Result<NodeId, ModelError> {
        let name = name.into();
        let (d, n) = map.dims();
        for masters in segments {
            self.check_own(masters, || format!("joint at node {name}"))?;
            if masters.len() > MAX_NODES {
                return Err(ModelError::TooManyNodes {
                    element: format!("(joint at node {name})"),
                    found: masters.len(),
                    limit: MAX_NODES,
                });
            }
            let found: usize = masters.iter().map(|m| self.nodes[m.0 as usize].dim).sum();
            if d != found || n != FRAME {
                return Err(ModelError::JointDimension {
                    node: name,
                    masters: self.names_of(masters),
                    map: (d, n),
                    found,
                });
            }
        }
        let numbers = |masters: &&[NodeId]| masters.iter().map(|m| m.0).collect();
        let segments = segments.iter().map(numbers).collect();
        let source = Source::Mapped(Box::new(Dependence::new(map, segments, d)));
        self.add_node(name, place, Form::Frame, &FRAME_KINDS, source)
    }

    fn add_node(
        &mut self,
        name: String,
        place: [f64; 3],
        form: Form,
        kinds: &[Kind],
        source: Source,
    ) -> Result<NodeId, ModelError> {
        if place.iter().any(|x| !x.is_finite()) {
            return Err(ModelError::NotFinite { node: name, place });
        }
        let id = NodeId(self.nodes.len() as u32);
        match self.names.entry(name.clone()) {
            Entry::Occupied(_) => return Err(ModelError::DuplicateNode { node: name }),
            Entry::Vacant(entry) => entry.insert(id),
        };
        self.nodes.push(Node {
            name,
            place: place.into(),
            form,
            dim: kinds.len(),
            kinds: kinds.to_vec(),
            first: 0,
            source,
        });
        Ok(id)
    }

    /// The node of a name.
    ///
    /// # Errors
    /// [`ModelError::UnknownNode`], which lists the names there are.
    pub fn find(&self, name: &str) -> Result<NodeId, ModelError> {
        self.names.get(name).copied().ok_or_else(|| {
            let mut known: Vec<&str> = self.nodes.iter().map(|n| n.name.as_str()).collect();
            let many = known.len() > 12;
            known.truncate(12);
            ModelError::UnknownNode {
                node: name.to_owned(),
                known: known.join(", ") + if many { ", ..." } else { "" },
            }
        })
    }

    /// Name of a node.
    pub fn node_name(&self, node: NodeId) -> &str {
        &self.nodes[node.0 as usize].name
    }

    /// Reference place of a node.
    pub fn place(&self, node: NodeId) -> Vector3<f64> {
        self.nodes[node.0 as usize].place
    }

    fn check_own(&self, nodes: &[NodeId], what: impl Fn() -> String) -> Result<(), ModelError> {
        if nodes.iter().all(|n| (n.0 as usize) < self.nodes.len()) {
            Ok(())
        } else {
            Err(ModelError::ForeignNode { what: what() })
        }
    }

    fn names_of(&self, nodes: &[NodeId]) -> String {
        let names: Vec<&str> = nodes.iter().map(|&n| self.node_name(n)).collect();
        names.join(", ")
    }

    /// Adds an element or a load on nodes.
    ///
    /// # Errors
    /// [`ModelError::Dimension`] when the nodes do not have the coordinates that it expects.
    pub fn element(
        &mut self,
        name: impl Into<String>,
        element: impl Element + 'static,
        nodes: &[NodeId],
    ) -> Result<ElementId, ModelError> {
        self.boxed_element(name.into(), Box::new(element), nodes)
    }

    /// As [`ModelBuilder::element`], for an element that is boxed already.
    ///
    /// # Errors
    /// As [`ModelBuilder::element`].
    pub fn boxed_element(
        &mut self,
        name: String,
        element: Box<dyn Element>,
        nodes: &[NodeId],
    ) -> Result<ElementId, ModelError> {
        self.check_own(nodes, || format!("element {name}"))?;
        if nodes.len() > MAX_NODES {
            return Err(ModelError::TooManyNodes {
                element: name,
                found: nodes.len(),
                limit: MAX_NODES,
            });
        }
        let found: usize = nodes.iter().map(|n| self.nodes[n.0 as usize].dim).sum();
        if found != element.dim() {
            return Err(ModelError::Dimension {
                expected: element.dim(),
                found,
                nodes: self.names_of(nodes),
                element: name,
            });
        }
        self.elements.push(Attached {
            name,
            dead: element.is_dead(),
            element,
            nodes: nodes.iter().map(|n| n.0).collect(),
            switched: 0,
            mapped: false,
            pulled: 0,
            blocks: 0,
            first_block: 0,
            first_position: 0,
        });
        Ok(ElementId(self.elements.len() as u32 - 1))
    }

    /// Holds coordinates of a node at zero.
    pub fn support(&mut self, node: NodeId, dofs: &[Dof]) {
        for &dof in dofs {
            self.prescribe(node, dof, Constant(0.0));
        }
    }

    /// Prescribes a coordinate of a frame node as a function of time (of the load parameter in
    /// statics).
    pub fn prescribe(&mut self, node: NodeId, dof: Dof, function: impl TimeFunction + 'static) {
        self.prescribe_boxed(node, dof, Box::new(function));
    }

    /// As [`ModelBuilder::prescribe`], for a function that is boxed already.
    pub fn prescribe_boxed(&mut self, node: NodeId, dof: Dof, function: Box<dyn TimeFunction>) {
        self.prescribe_coordinate(node, dof.index(), function);
    }

    /// Prescribes coordinate `k` of any node: the angle of a revolute joint, say.
    pub fn prescribe_coordinate(
        &mut self,
        node: NodeId,
        k: usize,
        function: Box<dyn TimeFunction>,
    ) {
        self.prescribed.push((node, k, function));
    }

    /// Checks the model, numbers its unknowns and finds the pattern.
    ///
    /// # Errors
    /// [`ModelError`] naming what is wrong. Whether the supports suffice is asked by statics
    /// ([`Model::check_supports`]): a free structure is a fine model for dynamics.
    pub fn build(self) -> Result<Model, ModelError> {
        let Self {
            mut nodes,
            mut elements,
            prescribed,
            ..
        } = self;
        if nodes.is_empty() {
            return Err(ModelError::Empty);
        }
        let mut total = 0;
        for node in &mut nodes {
            node.first = total;
            total += node.dim;
        }
        let operators = dependence::arrange(&mut nodes);
        check_connections(&nodes, &elements)?;
        let prescribed = resolve_prescribed(&nodes, prescribed)?;

        // Numbering: block by block, away from the supports.
        let mut free: Vec<bool> = nodes
            .iter()
            .flat_map(|n| std::iter::repeat_n(n.is_own(), n.dim))
            .collect();
        for p in &prescribed {
            free[p.coordinate] = false;
        }
        let mut unknowns = vec![NONE; total];
        let mut coordinates = Vec::new();
        let mut sizes = Vec::new();
        let mut placement = Placement {
            rows: vec![Vec::new(); nodes.len()],
            blocks: vec![NONE; nodes.len()],
            ..Placement::default()
        };
        for n in outward(&nodes, &elements, &prescribed) {
            let node = &nodes[n];
            let mut size = 0;
            let rows = node
                .range()
                .map(|c| {
                    if !free[c] {
                        return NONE;
                    }
                    unknowns[c] = coordinates.len() as u32;
                    coordinates.push(c);
                    size += 1;
                    size - 1
                })
                .collect();
            placement.rows[n] = rows;
            if size > 0 {
                placement.blocks[n] = sizes.len() as u32;
                sizes.push(size as usize);
            }
        }
        if coordinates.is_empty() {
            return Err(ModelError::NothingFree);
        }

        // The pattern has room for whatever an element or a joint may come to depend on.
        let blocks_of = |set: Vec<u32>| -> Vec<u32> {
            let block = |n: &u32| Some(placement.blocks[*n as usize]).filter(|&b| b != NONE);
            set.iter().filter_map(block).collect()
        };
        let dependent: Vec<u32> = (0..nodes.len() as u32)
            .filter(|&n| !nodes[n as usize].is_own())
            .collect();
        let groups = elements.iter().map(|e| &e.nodes[..]);
        let groups = groups.chain(dependent.iter().map(std::slice::from_ref));
        let groups = groups.flat_map(|group| dependence::alternatives(&nodes, group));
        let pattern = BlockPattern::new(&sizes, groups.map(blocks_of));
        placement.locate(&nodes, &mut elements, &pattern);

        let corner = |pick: fn(f64, f64) -> f64| {
            nodes
                .iter()
                .filter(|n| n.is_frame())
                .map(|n| n.place)
                .reduce(|a, b| a.zip_map(&b, pick))
                .unwrap_or_default()
        };
        let length = Some((corner(f64::max) - corner(f64::min)).norm())
            .filter(|&l| l > 0.0)
            .unwrap_or(1.0);
        let driven_rotations = (0..nodes.len())
            .filter(|&n| {
                let first = nodes[n].first;
                nodes[n].is_frame()
                    && (3..6).all(|i| prescribed.iter().any(|p| p.coordinate == first + i))
            })
            .map(|n| (n, 0))
            .collect();
        let kinds = nodes.iter().flat_map(|n| n.kinds.clone()).collect();
        let work = Workspace::new(&nodes, &elements, operators, length);
        let span = |node: &Node| Span {
            first: node.first as u32,
            dim: node.dim as u32,
        };
        let spans = nodes.iter().map(span).collect();
        let mut model = Model {
            nodes,
            spans,
            dependent,
            elements,
            prescribed,
            driven_rotations,
            coordinates,
            unknowns,
            kinds,
            length,
            pattern,
            placement,
            work,
        };
        let zero = vec![0.0; model.coordinates.len()];
        let start = Point {
            t: 0.0,
            q: &zero,
            v: &[],
            a: &[],
        };
        // A joint outside its domain is named when the model is first evaluated.
        if model.expand(start).is_ok() {
            model.choose_element_charts();
        }
        Ok(model)
    }
}

/// All nodes by their distance from the supports, counted in elements.
///
/// Elimination takes the last first: from free ends towards supports every partial structure is
/// held by what is still to come, and pivots keep their size. The other way round the last pivot
/// of a cantilever would be its tip stiffness, small by the cube of the number of elements.
fn outward(nodes: &[Node], elements: &[Attached], prescribed: &[Prescribed]) -> Vec<usize> {
    let mut touching: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    let mut groups: Vec<Vec<usize>> = Vec::with_capacity(elements.len());
    let indices = |nodes: &[u32]| nodes.iter().map(|&n| n as usize).collect::<Vec<_>>();
    groups.extend(elements.iter().map(|e| indices(&e.nodes)));
    for (n, node) in nodes.iter().enumerate() {
        if let Source::Mapped(d) = &node.source {
            for masters in &d.segments {
                groups.push(indices(masters));
                groups.last_mut().into_iter().for_each(|g| g.push(n));
            }
        }
    }
    for (g, group) in groups.iter().enumerate() {
        for &n in group {
            touching[n].push(g);
        }
    }
    let mut coordinate_node = Vec::new();
    for (n, node) in nodes.iter().enumerate() {
        coordinate_node.extend(std::iter::repeat_n(n, node.dim));
    }
    let mut reached = vec![false; nodes.len()];
    let mut used = vec![false; groups.len()];
    let mut order: Vec<usize> = Vec::with_capacity(nodes.len());
    let mut next = 0;
    let held = prescribed.iter().map(|p| coordinate_node[p.coordinate]);
    for n in held {
        if !std::mem::replace(&mut reached[n], true) {
            order.push(n);
        }
    }
    for seed in 0..=nodes.len() {
        while next < order.len() {
            for &g in &touching[order[next]] {
                if std::mem::replace(&mut used[g], true) {
                    continue;
                }
                for &m in &groups[g] {
                    if !std::mem::replace(&mut reached[m], true) {
                        order.push(m);
                    }
                }
            }
            next += 1;
        }
        // Parts without a support follow, each from its first node.
        if seed < nodes.len() && !reached[seed] {
            reached[seed] = true;
            order.push(seed);
        }
    }
    order
}

/// Every own node must meet an element that is not a load, directly or through a joint; a mapped
/// node, which has no coordinates of its own, may carry a load alone.
fn check_connections(nodes: &[Node], elements: &[Attached]) -> Result<(), ModelError> {
    let mut connected = vec![false; nodes.len()];
    for e in elements {
        for &n in &e.nodes {
            connected[n as usize] |= !e.element.is_load();
        }
    }
    // The last link of a chain first.
    for (n, node) in nodes.iter().enumerate().rev() {
        if let Source::Mapped(d) = &node.source
            && connected[n]
        {
            for &m in d.segments.iter().flatten() {
                connected[m as usize] = true;
            }
        }
    }
    for &n in elements.iter().flat_map(|e| &e.nodes) {
        connected[n as usize] |= !nodes[n as usize].is_own();
    }
    match connected.iter().position(|c| !c) {
        None => Ok(()),
        Some(n) => Err(ModelError::Unconnected {
            node: nodes[n].name.clone(),
        }),
    }
}

fn resolve_prescribed(
    nodes: &[Node],
    prescribed: Vec<(NodeId, usize, Box<dyn TimeFunction>)>,
) -> Result<Vec<Prescribed>, ModelError> {
    let mut out: Vec<Prescribed> = Vec::with_capacity(prescribed.len());
    let mut taken = std::collections::HashSet::new();
    for (id, dof, function) in prescribed {
        let Some(node) = nodes.get(id.0 as usize) else {
            return Err(ModelError::ForeignNode {
                what: "a support or driven motion".to_owned(),
            });
        };
        if dof >= node.dim {
            return Err(ModelError::NoCoordinate {
                node: node.name.clone(),
                coordinate: dof + 1,
                dim: node.dim,
            });
        }
        let coordinate = node.coordinate_name(dof);
        if let Source::Mapped(d) = &node.source {
            let masters: Vec<&str> = d
                .masters()
                .iter()
                .map(|&m| nodes[m as usize].name.as_str())
                .collect();
            return Err(ModelError::PrescribedSlave {
                coordinate,
                masters: masters.join(", "),
            });
        }
        if !taken.insert(node.first + dof) {
            return Err(ModelError::PrescribedTwice { coordinate });
        }
        out.push(Prescribed {
            coordinate: node.first + dof,
            function,
        });
    }
    Ok(out)
}
