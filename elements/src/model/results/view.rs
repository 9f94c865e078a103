//! Access to the nodes, maps and elements of a model, for tools such as the conformance kit.

use crate::element::Element;
use crate::model::assembly::element_workspace::switched_rotations;
use crate::model::build::builder::{DOF_NAMES, FRAME};
use crate::model::charts::nodes::FreeRotation;
use crate::model::kinematics::complement::ComplementOperators;
use crate::model::kinematics::node_entries::collect;
use crate::model::{Context, ElementEntry, Model, NONE, Node, NodeForm};
use nalgebra::Vector3;
use pullback_manifold::domain::DomainError;
use pullback_manifold::system::{Charts, Point, Quantity, SystemError};
use std::ops::Range;

impl Node {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reference position, global components; zero for scalar coordinates.
    pub fn position(&self) -> Vector3<f64> {
        self.position
    }

    /// Kind of its coordinates.
    pub fn form(&self) -> NodeForm {
        self.form
    }

    /// Quantities of its coordinates.
    pub fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    /// Range of its coordinates in those of all nodes ([`Context::configuration`]).
    pub fn range(&self) -> Range<usize> {
        self.first..self.first + self.dim
    }

    /// Name of coordinate `k` of this node.
    pub fn coordinate_name(&self, k: usize) -> String {
        if self.is_frame() || (self.form == NodeForm::Increment && self.dim == FRAME) {
            format!("node {}, {}", self.name, DOF_NAMES[k])
        } else if self.dim == 1 {
            self.name.clone()
        } else {
            format!("{}, coordinate {}", self.name, k + 1)
        }
    }

    /// Parents of its map on a segment
    /// ([`Segments::segment`](pullback_manifold::map::Segments::segment)), as indices of
    /// [`Model::nodes`]; none without a map.
    pub fn parents(&self, segment: usize) -> &[u32] {
        self.mapped().map_or(&[], |d| &d.segments[segment])
    }
}

impl ElementEntry {
    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The element, or load.
    pub fn element(&self) -> &dyn Element {
        &*self.element
    }

    /// Its nodes, as indices of [`Model::nodes`].
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }
}

impl Model {
    /// All nodes, in the order of their coordinates.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The mapped nodes, as indices of [`Model::nodes`], parents first.
    pub fn mapped_nodes(&self) -> &[u32] {
        &self.nodes.mapped
    }

    /// All elements and loads.
    pub fn elements(&self) -> &[ElementEntry] {
        &self.elements
    }

    /// The unknown of coordinate `c` of all nodes, if it is free.
    pub fn unknown_of(&self, c: usize) -> Option<usize> {
        let u = self.unknowns[c];
        (u != NONE).then_some(u as usize)
    }

    /// The free rotation vectors whose chart may change.
    pub fn free_rotations(&self) -> Vec<FreeRotation> {
        let all = 0..self.nodes.len();
        all.filter_map(|n| self.free_rotation(n)).collect()
    }
}

impl Context {
    /// Coordinates, velocities and accelerations of all nodes, in the configuration last set.
    pub fn configuration(&self) -> [&[f64]; 3] {
        [&self.work.x, &self.work.v, &self.work.a]
    }

    /// Coordinates, velocities and accelerations of an element in its chart, in the configuration last
    /// set.
    pub fn element_motion(&self, k: usize) -> [Vec<f64>; 3] {
        let (e, switched) = (&self.model.elements[k], self.state.elements[k].switched);
        let n = e.element.dim();
        let mut motion = self.configuration().map(|all| {
            let mut own = vec![0.0; n];
            collect(&e.nodes, &self.model.spans, all, &mut own);
            own
        });
        for (_, psi) in switched_rotations(e, switched, &self.model.spans) {
            let [x, v, a] = motion.each_mut().map(|own| &mut own[psi.clone()]);
            ComplementOperators::default().apply(x, v, a);
        }
        motion
    }

    /// Forces of element `k` at rest in its chart and in the configuration last set, as in an
    /// assembly: omitted equations have no multipliers.
    ///
    /// # Errors
    /// [`DomainError`] outside the element's domain.
    pub fn element_forces(&mut self, k: usize) -> Result<Vec<f64>, DomainError> {
        let (e, state) = (&self.model.elements[k], &self.state.elements[k]);
        let w = &mut self.work;
        w.local
            .read((e, state), &self.model.spans, [&w.x, &w.v, &w.a]);
        w.local
            .evaluate((e, state), w.t, true, None, false, false)?;
        Ok(w.local.r[..e.element.dim()].to_vec())
    }

    /// Sets the charts of a run that starts here, without reparametrizations. Rotation vectors are
    /// below π in norm.
    ///
    /// # Errors
    /// [`SystemError`] if a map is outside its domain.
    pub fn settle_charts(&mut self, t: f64, q: &[f64]) -> Result<(), SystemError> {
        self.fold_prescribed_rotations(t);
        // A slide enters the line of its state first, and then the present one.
        let at = Point::statics(t, q);
        self.update_maps(at)?;
        self.update_maps(at)?;
        self.start(t, q);
        Ok(())
    }

    /// Follows a change of charts at one state, from coordinates `before` to `after`, with maps and
    /// elements as at the end of a step.
    ///
    /// # Errors
    /// [`SystemError`] if a map is outside its domain.
    pub fn follow_charts(
        &mut self,
        t: f64,
        before: &[f64],
        after: &[f64],
    ) -> Result<(), SystemError> {
        self.look_before(Point::statics(t, before));
        self.update_maps(Point::statics(t, after))?;
        self.follow_element_charts(t);
        Ok(())
    }

    /// Freezes every map to its piece at a state at rest, or releases it
    /// ([`MapState::freeze_piece`](pullback_manifold::map::MapState::freeze_piece)).
    pub fn freeze_pieces(&mut self, at: Option<(f64, &[f64])>) {
        let known = at.is_none_or(|(t, q)| self.expand(Point::statics(t, q)).is_ok());
        for (_, _, d) in self.model.nodes.mapped().filter(|_| known) {
            let (w, maps) = (&mut self.work, &mut self.state.maps);
            let len = collect(d.parents(maps), &self.model.spans, &w.x, &mut w.local.q);
            if let Some(state) = maps[d.index].state() {
                state.freeze_piece(at.map(|(t, _)| (t, &w.local.q[..len])));
            }
        }
        self.work.known.forget();
    }

    /// Whether omitted equations of multipliers are checked, and the choice is revised: not at
    /// states that violate the equations.
    pub fn watch_equations(&mut self, on: bool) {
        self.state.unwatched = !on;
    }
}
