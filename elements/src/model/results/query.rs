//! Queries of a model: names, positions, section forces, supports.

use crate::element::{Motion, SectionState};
use crate::model::build::builder::{Dof, ElementId, NodeId};
use crate::model::{Context, Model, NONE, Node, NodeForm};
use nalgebra::{Matrix6, Vector3, Vector6};
use pullback_manifold::so3;
use pullback_manifold::system::{Point, SystemError};
use std::collections::BTreeMap;

impl Model {
    /// All frame nodes with their names, in the order of definition.
    pub fn frames(&self) -> impl Iterator<Item = (NodeId, &str)> + '_ {
        let frames = self.nodes_that(|n| n.form == NodeForm::Frame);
        frames.map(|(id, n)| (id, n.name.as_str()))
    }

    /// Node with a name.
    pub fn find(&self, name: &str) -> Option<NodeId> {
        let k = self.nodes.iter().position(|n| n.name == name)?;
        Some(NodeId(k as u32))
    }

    /// Name and nodes of an element.
    pub fn element(&self, id: ElementId) -> (&str, Vec<NodeId>) {
        let e = &self.elements[id.0 as usize];
        let frame = |&n: &u32| match &self.nodes[n as usize] {
            node if node.form == NodeForm::Pose => NodeId(node.partner),
            _ => NodeId(n),
        };
        (&e.name, e.nodes.iter().map(frame).collect())
    }

    /// Names of elements and loads with a tangent that is not symmetric; the stability of
    /// equilibria then follows from no potential.
    pub fn asymmetric(&self) -> impl Iterator<Item = &str> {
        let others = self
            .elements
            .iter()
            .filter(|e| !e.element.properties().symmetric);
        others.map(|e| e.name.as_str())
    }

    /// A node.
    pub fn node(&self, node: NodeId) -> &Node {
        &self.nodes[node.0 as usize]
    }

    /// Diagonal of the box around all nodes: the length that scales displacements.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Unknown of a coordinate of a frame node, if it is free.
    pub fn unknown(&self, node: NodeId, dof: Dof) -> Option<usize> {
        self.unknown_at(node, dof.index())
    }

    pub(in crate::model) fn coordinate_name(&self, c: usize) -> String {
        let n = &self.nodes[self.nodes.of_coordinate(c)];
        n.coordinate_name(c - n.first)
    }

    /// A rigid motion, in words, of a connected part of the structure that no support prevents, and a node of the part.
    /// In statics only loads can hold it, as gravity holds a cable between two hinges.
    pub fn free_motion(&self) -> Option<(NodeId, String)> {
        let mut parts: BTreeMap<usize, Vec<&Node>> = BTreeMap::new();
        for (node, part) in self.nodes.iter().zip(self.connected_parts()) {
            if node.is_frame() {
                parts.entry(part).or_default().push(node);
            }
        }
        parts.values().find_map(|frames| {
            let motion = self.unsupported(frames)?;
            Some((
                NodeId(self.nodes.of_coordinate(frames[0].first) as u32),
                motion,
            ))
        })
    }

    /// Index of the connected part of each node.
    fn connected_parts(&self) -> Vec<usize> {
        let mut part: Vec<usize> = (0..self.nodes.len()).collect();
        fn root(part: &mut [usize], mut n: usize) -> usize {
            while part[n] != n {
                part[n] = part[part[n]];
                n = part[n];
            }
            n
        }
        let mut join = |nodes: &mut dyn Iterator<Item = usize>| {
            let Some(first) = nodes.next() else { return };
            for other in nodes {
                let (a, b) = (root(&mut part, first), root(&mut part, other));
                part[a.max(b)] = a.min(b);
            }
        };
        for e in self.elements.iter().filter(|e| !e.load) {
            join(&mut e.nodes.iter().map(|&n| n as usize));
        }
        for (n, node) in self.nodes.iter().enumerate() {
            join(&mut std::iter::once(n).chain(node.all_parents().map(|m| m as usize)));
        }
        (0..self.nodes.len()).map(|n| root(&mut part, n)).collect()
    }

    /// A rigid motion of these frames that no support prevents, in words.
    fn unsupported(&self, frames: &[&Node]) -> Option<String> {
        let center: Vector3<f64> =
            frames.iter().map(|n| n.position).sum::<Vector3<f64>>() / frames.len() as f64;
        // Gram matrix of the prescribed coordinates over rigid motions (translation, rotation about
        // the centre times the model's length).
        let mut gram = Matrix6::<f64>::zeros();
        for node in frames {
            let arm = (node.position - center) / self.length;
            let mut moved = Matrix6::identity();
            moved
                .fixed_view_mut::<3, 3>(0, 3)
                .copy_from(&-so3::skew(&arm));
            let own = self.carrier(node);
            let held = |k: &usize| own.is_own() && self.unknowns[own.first + k] == NONE;
            for row in (0..6).filter(held).map(|k| moved.row(k)) {
                gram += row.transpose() * row;
            }
        }
        let eigen = gram.symmetric_eigen();
        let k = eigen.eigenvalues.imin();
        if eigen.eigenvalues[k] > 1e-12 * eigen.eigenvalues.max().max(1e-300) {
            return None;
        }
        let motion = eigen.eigenvectors.column(k).into_owned();
        Some(describe_motion(&motion, &center, self.length))
    }
}

impl Context {
    /// Describes the present state of the map of a node, such as its independent coordinates and
    /// redundant equations.
    pub fn describe(&self, node: NodeId) -> Option<String> {
        let d = self.model.nodes[node.0 as usize].mapped()?;
        let mut map = self.state.maps[d.index].clone();
        map.implicit().map(|map| map.describe())
    }

    /// Describes how the loops of [`ModelBuilder::close`](crate::model::ModelBuilder::close) are closed:
    /// the joints of attached children, the joints that close loops, and their present independent
    /// coordinates.
    pub fn descriptions(&self) -> Vec<String> {
        let reports = self.model.reports.iter().map(|r| {
            let of_map = r.map.and_then(|n| self.describe(NodeId(n)));
            let of_element = r.element.and_then(|k| self.describe_left_out(k));
            let own = of_map.or(of_element).map(|own| format!("; {own}"));
            r.words.clone() + &own.unwrap_or_default()
        });
        reports.chain(self.state.moved.iter().cloned()).collect()
    }

    /// Sets the whole configuration, for later queries.
    ///
    /// # Errors
    /// [`SystemError`] if a joint is outside its domain.
    pub fn configure(&mut self, at: Point<'_>) -> Result<(), SystemError> {
        self.expand(at)
    }

    /// Whether the configuration last set is one of statics.
    pub fn is_at_rest(&self) -> bool {
        !self.work.stirred
    }

    /// States of all cross-sections in the configuration last set, with their element.
    pub fn section_states(&self, t: f64) -> Vec<(ElementId, SectionState)> {
        let mut out = Vec::new();
        let mut states = Vec::new();
        for (k, e) in self.model.elements.iter().enumerate() {
            let [x, v, _] = self.element_motion(k);
            let v = if self.is_at_rest() { &[][..] } else { &v };
            let at = Motion {
                v,
                ..self.at_rest(t, &x)
            };
            e.element.abilities().section_states(&at, &mut states);
            out.extend(states.drain(..).map(|s| (ElementId(k as u32), s)));
        }
        out
    }

    /// Strain energy of all elements that are not loads, in the configuration last set.
    pub fn strain_energy(&self, t: f64) -> f64 {
        self.energy_of(t, false)
    }

    /// Potential of the loads that have one, in the configuration last set.
    pub fn load_potential(&self, t: f64) -> f64 {
        self.energy_of(t, true)
    }

    fn energy_of(&self, t: f64, load: bool) -> f64 {
        let elements = self.model.elements.iter().enumerate();
        elements
            .filter(|(_, e)| e.load == load)
            .map(|(k, e)| {
                let [x, ..] = self.element_motion(k);
                e.element.abilities().energy(&self.at_rest(t, &x))
            })
            .sum()
    }

    fn at_rest<'a>(&'a self, t: f64, x: &'a [f64]) -> Motion<'a> {
        Motion {
            t,
            inputs: &self.state.inputs,
            x,
            v: &[],
            a: &[],
            previous: None,
        }
    }

    /// Largest rotation angle of any node in the configuration last set.
    pub fn largest_rotation(&self) -> f64 {
        let frames = self.model.nodes.iter();
        let frames = frames.filter(|n| n.form == NodeForm::Frame);
        frames.map(|n| self.angle(n)).fold(0.0, f64::max)
    }
}

/// A rigid motion (translation of the centre, rotation times length) in words.
fn describe_motion(motion: &Vector6<f64>, center: &Vector3<f64>, length: f64) -> String {
    let translation: Vector3<f64> = motion.fixed_rows::<3>(0).into_owned();
    let rotation: Vector3<f64> = motion.fixed_rows::<3>(3) / length;
    // No zero has a sign.
    let rounded = |v: Vector3<f64>| v.map(|x| (1e3 * x).round() / 1e3 + 0.0);
    let show = |v: &Vector3<f64>| {
        let v = rounded(v / v[v.iamax()]);
        format!("({:.3}, {:.3}, {:.3})", v.x, v.y, v.z)
    };
    if rotation.norm() * length < 1e-6 {
        return format!("translation along {}", show(&translation));
    }
    // The axis passes through center + ω × v / ω².
    let through = rounded(center + rotation.cross(&translation) / rotation.norm_squared());
    format!(
        "rotation about the direction {} through ({:.3}, {:.3}, {:.3})",
        show(&rotation),
        through.x,
        through.y,
        through.z
    )
}
