//! The maps of joints: from the pose of a parent and the coordinates of a joint to the child.

use super::link::{Link, unit};
use super::{Joint, Slide};
use crate::blocks::{three, three_or_zero};
use nalgebra::{SVector, Vector3};
use pullback_manifold::domain::{CHART_EDGE, DomainError};
use pullback_manifold::map::{
    Map, MapGraph, MapState, Order, Parametrization, Read, Segments, ToChart, ToPose, write_block,
    write_geometric_stiffness, write_orders,
};
use pullback_manifold::system::ChartChanges;
use std::f64::consts::TAU;

/// A joint as a map (pose of the parent, q) ↦ pose of the child: see [`ToPose`].
///
/// For a child that rotates freely, its rotation vector Ψ is among the coordinates, and the map gives its
/// chart: (pose of the parent, q, Ψ) ↦ (d, Ψ) of the child. A pose that is not a unit quaternion is outside the
/// domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMap<J, const D: usize> {
    link: Link<J, D>,
    turns_freely: bool,
}

impl<J, const D: usize> JointMap<J, D>
where
    J: Joint<D> + Clone + 'static,
{
    /// The map of a joint.
    pub fn new(joint: J) -> Self {
        let (link, turns_freely) = (Link::new(joint, Vector3::zeros()), false);
        Self { link, turns_freely }
    }

    /// The map of a joint whose child rotates freely.
    pub fn turning_freely(joint: J) -> Self {
        Self {
            turns_freely: true,
            ..Self::new(joint)
        }
    }

    /// The map of the same joint at a position in the axes of the parent, which adds to that of its pose.
    #[must_use]
    pub fn at(self, position: Vector3<f64>) -> Self {
        let link = Link::new(self.link.joint, position);
        Self { link, ..self }
    }

    /// The same map between charts, (d, Ψ of the parent, q) ↦ (d, Ψ of the child), \[M04\] (207).
    pub fn between_charts(self) -> MapGraph {
        let (d, turns_freely) = (self.dims().0, self.turns_freely);
        let mut graph = MapGraph::new(d);
        let parent = graph.add(Box::new(ToPose), vec![(Read::Input(0), 6)]);
        let reads = vec![(parent, 6), (Read::Input(6), d - 6)];
        let child = graph.add(Box::new(self), reads);
        if !turns_freely {
            graph.add(Box::new(ToChart::default()), vec![(child, 6)]);
        }
        graph.with_outputs(1)
    }
}

impl<J, const D: usize> Parametrization for JointMap<J, D>
where
    J: Joint<D> + Clone + 'static,
{
    fn kind(&self) -> &'static str {
        std::any::type_name::<J>()
    }

    fn dims(&self) -> (usize, usize) {
        (6 + D + if self.turns_freely { 3 } else { 0 }, 6)
    }

    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        let own = self.link.domain(t, q)?;
        match self.turns_freely {
            // The child's chart ends.
            true => DomainError::within(own.min(TAU - three_or_zero(q, 6 + D).norm()), CHART_EDGE),
            false => Ok(own),
        }
    }

    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        let at = match out.len() {
            1 => self.link.carried_at_rest(t, motion[0]),
            _ => self.link.carried(t, motion),
        };
        if self.turns_freely {
            for (k, [x, B]) in out.iter_mut().enumerate() {
                x[3..].copy_from_slice(three_or_zero(motion[k], 6 + D).as_slice());
                B.fill(0.0);
                write_block(B, 6, [3, 6 + D], &unit(k));
            }
        } else {
            at.write_rotation(out);
        }
        at.write_position(out);
    }

    /// \[M04\] (212) for any joint.
    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        K.fill(0.0);
        let moment = match self.turns_freely {
            true => Vector3::zeros(),
            false => three_or_zero(f, 3),
        };
        let n = self.dims().0;
        self.link
            .write_stiffness((t, q), [&three_or_zero(f, 0), &moment], (K, n));
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl<J: Joint<D>, const D: usize> MapState for JointMap<J, D> {
    fn freeze_piece(&mut self, at: Option<(f64, &[f64])>) {
        self.link.freeze_piece(at);
    }
}

/// A joint along a chain of beam elements: its segment is part of its state.
impl Parametrization for Slide {
    fn dims(&self) -> (usize, usize) {
        (13, 6)
    }

    fn domain(&mut self, t: f64, q: &[f64]) -> Result<f64, DomainError> {
        Map::domain(self, t, &SVector::from_column_slice(q))
    }

    fn evaluate(&mut self, t: f64, motion: [&[f64]; 3], out: &mut [Order<'_>]) {
        write_orders(self, t, motion, out);
    }

    fn geometric_stiffness(&mut self, t: f64, q: &[f64], f: &[f64], K: &mut [f64]) {
        write_geometric_stiffness(self, t, q, f, K);
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }

    fn segments(&self) -> Option<&dyn Segments> {
        Some(self)
    }
}

impl MapState for Slide {
    fn change_charts(&mut self, _t: f64, q: &[f64]) -> ChartChanges {
        let psi = [3, 9].map(|k| three(q, k));
        let on = self.chain.change_segments(q[12]);
        // After a change of element, `q` belongs to the nodes of the old one.
        let residual = self.turn.choose((!on).then_some(psi)) || on;
        let charts = usize::from(residual);
        ChartChanges { charts, residual }
    }

    fn enter(&mut self, segment: usize) {
        self.chain.enter(segment as f64);
    }

    fn save(&self) -> Vec<f64> {
        let complements = self.turn.complements.map(f64::from);
        vec![self.chain.line() as f64, complements[0], complements[1]]
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        let &[line, first, last] = saved else {
            return false;
        };
        self.turn.complements = [first, last].map(|c| c != 0.0);
        let known = self.chain.enter(line);
        // At once, wherever on the line.
        self.chain.change_segments(0.0);
        known
    }
}

impl Segments for Slide {
    fn count(&self) -> usize {
        self.chain.count()
    }

    fn segment(&self) -> usize {
        self.chain.line()
    }

    fn overshoot(&self, h: f64, from: [&[f64]; 2], to: [&[f64]; 2]) -> Option<(f64, usize)> {
        let [from, to] = [from, to].map(|[q, v]| [q[12], v[12]]);
        self.chain.leaves(h, from, to)
    }
}
