//! Turns that map a rotor on itself.

use crate::blocks::three;
use crate::model::build::builder::NodeId;
use crate::model::{Context, Model};
use crate::time::Input;
use nalgebra::{DMatrix, Matrix6xX, Rotation3, UnitVector3, Vector3, Vector6};
use pullback_manifold::system::{CyclicSymmetry, Point, SystemError};
use std::f64::consts::TAU;
use std::ops::Range;

/// Difference of positions, and of velocities at unit rates, that counts as rounding; lengths relative to that of the model.
const SAME: f64 = 1e-8;

/// Parts that rotate about one axis.
struct Rotor {
    axis: UnitVector3<f64>,
    coordinates: Vec<Moved>,
}

/// The coordinates of a node: its unknowns, the position of the first frame that they move, from the axis, and the twists of that
/// frame at unit rates of each. Lengths are relative to that of the model.
struct Moved {
    unknowns: Range<usize>,
    position: Vector3<f64>,
    twists: Matrix6xX<f64>,
}

impl Moved {
    fn turned(&self, Q: &Rotation3<f64>) -> Self {
        let mut twists = self.twists.clone();
        for mut twist in twists.column_iter_mut() {
            for k in [0, 3] {
                let turned = Q * twist.fixed_rows::<3>(k);
                twist.fixed_rows_mut::<3>(k).copy_from(&turned);
            }
        }
        Self {
            unknowns: self.unknowns.clone(),
            position: Q * self.position,
            twists,
        }
    }

    /// The rates at which this frame moves as another one at unit rates; `None` if it is elsewhere, or cannot.
    fn rates_of(&self, other: &Self) -> Option<DMatrix<f64>> {
        let own = &self.twists;
        if (self.position - other.position).norm() > SAME || own.shape() != other.twists.shape() {
            return None;
        }
        let rates = (own.tr_mul(own).cholesky()?).solve(&own.tr_mul(&other.twists));
        ((own * &rates - &other.twists).amax() <= SAME).then_some(rates)
    }
}

impl Rotor {
    /// The turn by a part of a full one, if it maps the rotor on itself.
    fn turn(&self, order: usize) -> Option<CyclicSymmetry> {
        let Q = Rotation3::from_axis_angle(&self.axis, TAU / order as f64);
        let mut turn = Vec::new();
        for from in &self.coordinates {
            let turned = from.turned(&Q);
            let mut images = self.coordinates.iter();
            let (to, rates) = images.find_map(|to| Some((to, to.rates_of(&turned)?)))?;
            for (column, c) in rates.column_iter().zip(from.unknowns.clone()) {
                turn.extend(to.unknowns.clone().zip(column).map(|(r, x)| (r, c, *x)));
            }
        }
        Some(CyclicSymmetry { order, turn })
    }

    /// The smallest turn that maps the rotor on itself, up to a third of a full one.
    fn symmetry(&self) -> Option<CyclicSymmetry> {
        let ring = |moved: &Moved| {
            let height = moved.position.dot(&self.axis);
            (moved.position.cross(&self.axis).norm(), height)
        };
        // A frame is turned to one at its radius and height.
        let mut rings = self
            .coordinates
            .iter()
            .map(ring)
            .filter(|(radius, _)| *radius > SAME);
        let most = rings.next().map_or(4, |(radius, height)| {
            let same = |other: &(f64, f64)| (other.0 - radius).hypot(other.1 - height) <= SAME;
            1 + rings.filter(same).count()
        });
        (3..=most).rev().find_map(|order| self.turn(order))
    }
}

impl Model {
    /// The unknowns of each node, with the first frame that they move.
    fn first_frames(&self) -> Vec<(Range<usize>, NodeId)> {
        let all = (0..).zip(self.nodes.iter());
        let mut first: Vec<_> = all.map(|(n, node)| node.is_frame().then_some(n)).collect();
        for (n, node, _) in self.nodes.mapped().rev() {
            for parent in node.all_parents().map(|parent| parent as usize) {
                if !self.nodes[parent].is_frame() {
                    first[parent] = first[n as usize];
                }
            }
        }
        let blocks = (0..self.pattern.blocks()).map(|block| self.pattern.unknowns(block));
        let blocks = blocks.filter(|unknowns| !unknowns.is_empty());
        blocks
            .filter_map(|unknowns| {
                let node = self.node_of(self.coordinates[unknowns.start]);
                Some((unknowns, NodeId(first[node]?)))
            })
            .collect()
    }
}

impl Context {
    /// The smallest turn, up to a third of a full one, that maps all that rotates with the speed of an input on itself: the
    /// positions of nodes at coordinates `q`, and the directions of their coordinates. `None` if there is no such turn, or
    /// nothing rotates with that speed about one axis.
    ///
    /// Masses and stiffnesses are not compared.
    ///
    /// # Errors
    /// [`SystemError`] if `q` is outside a chart.
    pub fn cyclic_symmetry(
        &mut self,
        speed: Input,
        q: &[f64],
    ) -> Result<Option<CyclicSymmetry>, SystemError> {
        let before = self.state.inputs[speed.0];
        let rotor = rotor(self, speed, q);
        self.set_input(speed, before);
        Ok(rotor?.and_then(|rotor| rotor.symmetry()))
    }
}

/// What rotates with the speed of an input.
fn rotor(context: &mut Context, speed: Input, q: &[f64]) -> Result<Option<Rotor>, SystemError> {
    let moved = context.model.first_frames();
    let frames: Vec<NodeId> = moved.iter().map(|(_, frame)| *frame).collect();
    let mut v = vec![0.0; q.len()];
    context.set_input(speed, 1.0);
    let fast = twists(context, q, &v, &frames)?;
    context.set_input(speed, 0.0);
    let slow = twists(context, q, &v, &frames)?;
    let position = |&frame: &NodeId| context.node_state(frame).position / context.model.length;
    let positions: Vec<_> = frames.iter().map(position).collect();
    let spin = |k: usize| {
        let spin = fast[k] - slow[k];
        (three(spin.as_slice(), 0), three(spin.as_slice(), 3))
    };
    let turns = |&k: &usize| (spin(k).1.norm() - 1.0).abs() <= SAME;
    let Some(first) = (0..frames.len()).find(turns) else {
        return Ok(None);
    };
    let (velocity, axis) = spin(first);
    // v = ω × (x − center).
    let center = positions[first] + axis.cross(&velocity);
    let mut coordinates = Vec::new();
    for (k, (unknowns, frame)) in moved.into_iter().enumerate() {
        let ((velocity, omega), position) = (spin(k), positions[k] - center);
        if omega.norm().max(velocity.norm()) <= SAME {
            continue;
        }
        if (omega - axis).norm() > SAME || (velocity - axis.cross(&position)).norm() > SAME {
            return Ok(None);
        }
        let mut columns = Matrix6xX::zeros(unknowns.len());
        for (u, mut column) in unknowns.clone().zip(columns.column_iter_mut()) {
            v[u] = 1.0;
            column.copy_from(&(twists(context, q, &v, &[frame])?[0] - slow[k]));
            v[u] = 0.0;
        }
        coordinates.push(Moved {
            unknowns,
            position,
            twists: columns,
        });
    }
    let axis = UnitVector3::new_normalize(axis);
    Ok(Some(Rotor { axis, coordinates }))
}

/// Velocities of frames relative to the length of the model, and their angular velocities.
fn twists(
    context: &mut Context,
    q: &[f64],
    v: &[f64],
    frames: &[NodeId],
) -> Result<Vec<Vector6<f64>>, SystemError> {
    let a = &vec![0.0; q.len()];
    context.configure(Point { t: 0.0, q, v, a })?;
    let twist = |&frame: &NodeId| {
        let state = context.node_state(frame);
        let velocity = state.velocity / context.model.length;
        Vector6::from_iterator(velocity.iter().chain(&state.omega).copied())
    };
    Ok(frames.iter().map(twist).collect())
}
