//! Turns that map a rotor on itself.

use crate::blocks::three;
use crate::model::Context;
use crate::model::build::builder::NodeId;
use crate::time::Input;
use nalgebra::{DMatrix, Matrix6xX, Rotation3, UnitVector3, Vector3, Vector6};
use pullback_manifold::system::{CyclicSymmetry, Point, SystemError};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Difference of positions, and of velocities at unit rates, that counts as rounding of a model's digits; lengths relative to
/// that of the model.
const SAME: f64 = 1e-5;

/// Coordinates of parts that rotate: unknowns, the position of the first frame that each of them moves in a direction of its own,
/// from the axis, and the twists of that frame at unit rates of each. Lengths are relative to that of the model.
#[derive(Clone)]
struct Moved {
    unknowns: Vec<usize>,
    position: Vector3<f64>,
    twists: Matrix6xX<f64>,
}

impl Moved {
    fn turned(&self, Q: &Rotation3<f64>) -> Self {
        let mut turned = self.clone();
        turned.position = Q * self.position;
        for mut twist in turned.twists.column_iter_mut() {
            for k in [0, 3] {
                let part = Q * twist.fixed_rows::<3>(k);
                twist.fixed_rows_mut::<3>(k).copy_from(&part);
            }
        }
        turned
    }

    /// The rates at which this frame moves as another one at unit rates; `None` if it is elsewhere, or cannot.
    fn rates_of(&self, other: &Self) -> Option<DMatrix<f64>> {
        let own = &self.twists;
        if (self.position - other.position).norm() > SAME || own.shape() != other.twists.shape() {
            return None;
        }
        let rates = (own.tr_mul(own).cholesky()?).solve(&own.tr_mul(&other.twists));
        let off = own * &rates - &other.twists;
        let mut columns = off.column_iter().zip(other.twists.column_iter());
        columns
            .all(|(off, twist)| off.norm() <= SAME * twist.norm())
            .then_some(rates)
    }

    /// Both together, if they are at one position and move it in different directions.
    fn with(&self, other: &Self) -> Option<Self> {
        let columns = self.twists.column_iter().chain(other.twists.column_iter());
        let twists = Matrix6xX::from_columns(&columns.collect::<Vec<_>>());
        let near = (self.position - other.position).norm() <= SAME;
        (near && differ(&twists)).then(|| Self {
            unknowns: [&self.unknowns[..], &other.unknowns].concat(),
            position: self.position,
            twists,
        })
    }
}

/// Whether twists have different directions, none of them in the space of the others.
fn differ(twists: &Matrix6xX<f64>) -> bool {
    let mut directions = twists.clone();
    let mut columns = directions.column_iter_mut();
    let moves = columns.all(|mut twist| twist.try_normalize_mut(0.0).is_some_and(f64::is_finite));
    moves && twists.ncols() <= 6 && directions.singular_values().min() > SAME
}

/// Those of `parts` that move as one does, with their rates; of several the most alike.
fn images<'a>(parts: &'a [Moved], one: &Moved) -> Vec<(&'a Moved, DMatrix<f64>)> {
    let fitting = parts
        .iter()
        .filter_map(|part| Some((part, part.rates_of(one)?)));
    let mut fitting: Vec<_> = fitting.collect();
    let off = |(_, rates): &(&Moved, DMatrix<f64>)| {
        (rates - DMatrix::identity(rates.nrows(), rates.ncols())).amax()
    };
    let least = fitting.iter().map(off).fold(f64::INFINITY, f64::min);
    fitting.retain(|image| off(image) <= least + SAME);
    fitting
}

/// The turn of parts by a part of a full one, if it maps them on themselves. Of several at one position the order is kept.
fn turn(parts: &[Moved], axis: &UnitVector3<f64>, order: usize) -> Option<CyclicSymmetry> {
    let Q = Rotation3::from_axis_angle(axis, TAU / order as f64);
    let mut turn = Vec::new();
    for from in parts {
        let mut own = images(parts, from).into_iter();
        let rank = own.position(|(part, _)| part.unknowns == from.unknowns)?;
        let (to, rates) = images(parts, &from.turned(&Q)).into_iter().nth(rank)?;
        for (column, c) in rates.column_iter().zip(&from.unknowns) {
            turn.extend(to.unknowns.iter().zip(column).map(|(r, x)| (*r, *c, *x)));
        }
    }
    Some(CyclicSymmetry { order, turn })
}

/// The turns that map parts on themselves, up to a third of a full one, the smallest first: coordinate by coordinate, and with
/// those at one position together, as the two of a universal joint.
fn symmetries(parts: Vec<Moved>, axis: &UnitVector3<f64>) -> Vec<CyclicSymmetry> {
    let ring = |moved: &Moved| {
        let height = moved.position.dot(axis);
        (moved.position.cross(axis).norm(), height)
    };
    // A frame is turned to one at its radius and height.
    let mut rings = (parts.iter().map(ring)).filter(|(radius, _)| *radius > SAME);
    let most = rings.next().map_or(4, |(radius, height)| {
        let same = |other: &(f64, f64)| (other.0 - radius).hypot(other.1 - height) <= SAME;
        1 + rings.filter(same).count()
    });
    let mut together: Vec<Moved> = Vec::new();
    for part in &parts {
        let wider = together
            .iter_mut()
            .find_map(|group| Some((group.with(part)?, group)));
        match wider {
            Some((wider, group)) => *group = wider,
            None => together.push(part.clone()),
        }
    }
    let orders = (3..=most).rev();
    let both = [parts, together];
    orders
        .flat_map(|order| both.each_ref().map(|parts| turn(parts, axis, order)))
        .flatten()
        .filter(|symmetry| !symmetry.turn.is_empty())
        .collect()
}

impl Context {
    /// The turns by a part of a full one, up to a third, that map all that rotates with the speed of an input on itself: the
    /// positions of nodes at time 0 and coordinates `q`, and the directions of their coordinates. The smallest is first. None
    /// if nothing rotates with that speed about one axis.
    ///
    /// Masses and stiffnesses are not compared.
    ///
    /// # Errors
    /// [`SystemError`] if `q` is outside a chart.
    pub fn cyclic_symmetries(
        &mut self,
        speed: Input,
        q: &[f64],
    ) -> Result<Vec<CyclicSymmetry>, SystemError> {
        let before = self.state.inputs[speed.0];
        let rotor = rotor(self, speed, q);
        self.set_input(speed, before);
        let (parts, axis) = rotor?;
        Ok(symmetries(parts, &axis))
    }
}

/// What rotates with the speed of an input, and its axis; nothing if there is no such axis.
fn rotor(
    context: &mut Context,
    speed: Input,
    q: &[f64],
) -> Result<(Vec<Moved>, UnitVector3<f64>), SystemError> {
    let model = Arc::clone(&context.model);
    let frames: Vec<NodeId> = model.frames().map(|(frame, _)| frame).collect();
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
        return Ok((Vec::new(), Vector3::x_axis()));
    };
    let (velocity, axis) = spin(first);
    // v = ω × (x − center).
    let center = positions[first] + axis.cross(&velocity);
    let mut coordinates = Vec::new();
    for node in model.nodes.iter() {
        let unknowns: Vec<usize> = node.range().filter_map(|c| model.unknown_of(c)).collect();
        if unknowns.is_empty() {
            continue;
        }
        let mut moving = Vec::new();
        for &u in &unknowns {
            v[u] = 1.0;
            moving.push(twists(context, q, &v, &frames)?);
            v[u] = 0.0;
        }
        let at = |k: usize| {
            let columns: Vec<_> = moving.iter().map(|all| all[k] - slow[k]).collect();
            Some((k, Matrix6xX::from_columns(&columns))).filter(|(_, twists)| differ(twists))
        };
        let Some((k, twists)) = (0..frames.len()).find_map(at) else {
            continue;
        };
        let ((velocity, omega), position) = (spin(k), positions[k] - center);
        if omega.norm().max(velocity.norm()) <= SAME {
            continue;
        }
        if (omega - axis).norm() > SAME || (velocity - axis.cross(&position)).norm() > SAME {
            return Ok((Vec::new(), Vector3::x_axis()));
        }
        coordinates.push(Moved {
            unknowns,
            position,
            twists,
        });
    }
    let axis = UnitVector3::new_normalize(axis);
    Ok((coordinates, axis))
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
