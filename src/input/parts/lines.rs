//! Lines of the file as beam elements of the model.

use super::Assembly;
use crate::input::assemble::LineGeometry;
use crate::input::file::{self, Arc, Line};
use crate::input::imperfection::Displaced;
use crate::input::{InputError, InputProblem, Location};
use nalgebra::{Unit, Vector3};
use pullback_elements::beam::{self, Interpolation};
use pullback_elements::model::{
    BeamLine, CircularArc, ModelError, NodeId, ReferenceCurve, StraightLine,
};

/// Most elements of a line; more are taken for a typing error.
const MOST_ELEMENTS: usize = 1_000_000;

impl Assembly<'_> {
    /// Adds the nodes and elements of line number `k`.
    pub(super) fn add_line(&mut self, k: usize) -> Result<(), InputError> {
        let (at, line) = (self.at("lines").at(k), &self.file.lines[k]);
        let from = self.nodes.find(&at.at("from"), &line.from)?;
        let to = self.nodes.find(&at.at("to"), &line.to)?;
        let section = self.sections.find(&at.at("section"), &line.section)?;
        check_counts(&at, line)?;
        let interpolation = match line.interpolation {
            file::Interpolation::Total => Interpolation::Total,
            file::Interpolation::Geodesic => Interpolation::Geodesic,
        };
        let axis = self.axis(&at, line, [from, to])?;
        let parent =
            (line.relative_to.as_ref()).map(|name| self.nodes.find(&at.at("relative_to"), name));
        let mesh = BeamLine {
            elements: line.elements,
            order: line.order,
            section,
            interpolation,
            relative_to: parent.transpose()?,
        };
        let made = (self
            .builder
            .line(&line.name, axis.as_ref(), [from, to], &mesh))
        .map_err(|error| at.refuse(error))?;
        let intervals = (made.nodes.len() - 1) as f64;
        let frames = (0..made.nodes.len())
            .map(|i| axis.at(i as f64 / intervals).1)
            .collect();
        let mut carried = Vec::new();
        if section.inertia.S != Vector3::zeros() {
            let elements = made.nodes.windows(line.order + 1).step_by(line.order);
            for (e, own) in elements.enumerate() {
                let positions: Vec<_> = own.iter().map(|&n| self.builder.position(n)).collect();
                let frame = |xi: f64| axis.at(mesh.parameter(e, xi)).1;
                let shares = beam::carried(&positions, &frame, &section);
                carried.push(shares.map_err(|source| {
                    let element = format!("{}:{}", line.name, e + 1);
                    at.refuse(ModelError::Beam { element, source })
                })?);
            }
        }
        for &node in &made.nodes[1..made.nodes.len() - 1] {
            self.nodes
                .add(self.builder.node_name(node).to_owned(), node);
        }
        self.meshed[k] = Some(LineGeometry {
            name: line.name.clone(),
            order: line.order,
            interpolation,
            nodes: made.nodes,
            frames,
            carried,
            elements: made.elements,
        });
        Ok(())
    }

    /// The axis of a line between two nodes, with the imperfections of the file.
    fn axis(
        &self,
        at: &Location<'_>,
        line: &Line,
        ends: [NodeId; 2],
    ) -> Result<Box<dyn ReferenceCurve>, InputError> {
        let positions = ends.map(|node| self.builder.position(node));
        if self.offsets.is_none() {
            return axis(at, line, positions);
        }
        let intervals = line.elements * line.order;
        let names = (1..intervals).map(|k| format!("{}/{k}", line.name));
        let names = [line.from.clone()].into_iter().chain(names);
        let names = names.chain([line.to.clone()]);
        let offsets = names.map(|name| self.offset(&at.at("name"), &name));
        let offsets: Vec<_> = offsets.collect::<Result<_, _>>()?;
        let perfect = [
            positions[0] - offsets[0][0],
            positions[1] - offsets[intervals][0],
        ];
        Ok(Box::new(Displaced {
            curve: axis(at, line, perfect)?,
            offsets,
            order: line.order,
        }))
    }
}

/// Refuses numbers of elements, and orders, that are none.
fn check_counts(at: &Location<'_>, line: &Line) -> Result<(), InputError> {
    let [elements, order] = [line.elements, line.order].map(|count| count as f64);
    let wrong = !(1..=MOST_ELEMENTS).contains(&line.elements);
    at.refuse_if(wrong, "elements", elements, "a count from 1 to 1000000")?;
    let wrong = !(1..=3).contains(&line.order);
    at.refuse_if(wrong, "order", order, "1, 2 or 3")
}

/// The axis of a line, checked so that it has a direction everywhere.
fn axis(
    at: &Location<'_>,
    line: &Line,
    ends: [Vector3<f64>; 2],
) -> Result<Box<dyn ReferenceCurve>, InputError> {
    let second = line.second_axis.map(Vector3::from);
    let (made, tangent) = match &line.arc {
        None => straight(at, line, ends, second)?,
        Some(arc) => circular(at, line, arc, ends[0], second)?,
    };
    if let Some(second) = second {
        let across = tangent.normalize().cross(&second).norm();
        if second.norm() == 0.0 || across <= 1e-6 * second.norm() {
            return Err(no_direction(at, line, "second_axis", second.into()));
        }
    }
    Ok(made)
}

/// An axis, and its tangent at the start.
type Axis = (Box<dyn ReferenceCurve>, Vector3<f64>);

fn straight(
    at: &Location<'_>,
    line: &Line,
    [from, to]: [Vector3<f64>; 2],
    second: Option<Vector3<f64>>,
) -> Result<Axis, InputError> {
    let tangent = to - from;
    let size = from.amax().max(to.amax());
    if tangent.norm() <= 1e-12 * size {
        return Err(at.refuse(InputProblem::ZeroLength {
            line: line.name.clone(),
            from: line.from.clone(),
            to: line.to.clone(),
            at: from.into(),
        }));
    }
    per_element(at, line, "twist_deg", line.twist_deg)?;
    let twist = line.twist_deg.to_radians();
    let axis = StraightLine {
        from,
        to,
        second,
        twist,
    };
    Ok((Box::new(axis), tangent))
}

fn circular(
    at: &Location<'_>,
    line: &Line,
    arc: &Arc,
    from: Vector3<f64>,
    second: Option<Vector3<f64>>,
) -> Result<Axis, InputError> {
    if line.twist_deg != 0.0 {
        let line = line.name.clone();
        return Err((at.at("twist_deg")).refuse(InputProblem::TwistedArc { line }));
    }
    let at = at.at("arc");
    let (center, direction) = (Vector3::from(arc.center), Vector3::from(arc.axis));
    let Some(axis) = Unit::try_new(direction, 0.0) else {
        return Err(no_direction(&at, line, "axis", arc.axis));
    };
    let radius = from - center;
    let tangent = axis.cross(&radius) * arc.angle_deg.signum();
    if tangent.norm() <= 1e-12 * from.amax().max(center.amax()) {
        return Err(no_direction(&at, line, "center", arc.center));
    }
    let expected = "an angle between -360 and 360 degrees, not 0";
    let wrong = arc.angle_deg == 0.0 || arc.angle_deg.abs() > 360.0;
    at.refuse_if(wrong, "angle_deg", arc.angle_deg, expected)?;
    per_element(&at, line, "angle_deg", arc.angle_deg)?;
    let axis = CircularArc {
        from,
        center,
        axis,
        angle: arc.angle_deg.to_radians(),
        second,
    };
    Ok((Box::new(axis), tangent))
}

/// Refusal of a vector that gives a line no direction.
fn no_direction(
    table: &Location<'_>,
    line: &Line,
    key: &'static str,
    vector: [f64; 3],
) -> InputError {
    let line = line.name.clone();
    (table.at(key)).refuse(InputProblem::NoDirection { line, key, vector })
}

/// Refuses angles of half a turn and more between the ends of an element, whose sense of rotation would be ambiguous.
fn per_element(
    table: &Location<'_>,
    line: &Line,
    key: &'static str,
    degrees: f64,
) -> Result<(), InputError> {
    let clear = degrees.abs() < 180.0 * line.elements as f64;
    let expected =
        "less than 180 degrees from one end of an element to the other: take more elements";
    table.refuse_if(!clear, key, degrees, expected)
}
