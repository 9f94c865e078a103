//! Lines of the file as beam elements of the model.

use super::assemble::LineGeometry;
use super::file::{Interpolation as Chosen, Line as Described};
use super::names::Names;
use super::{InputError, Problem, Text};
use nalgebra::{Unit, Vector3};
use pullback_elements::beam::{self, Interpolation, Section};
use pullback_elements::model::{
    BeamLine, CircularArc, ModelBuilder, ModelError, NodeId, ReferenceCurve, StraightLine,
};
use std::collections::BTreeMap;

/// Most elements of a line; more are taken for a typing error.
const MOST_ELEMENTS: usize = 1_000_000;

/// Adds the elements of line number `k` of the file.
pub(super) fn lay(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    nodes: &Names<NodeId>,
    sections: &BTreeMap<String, Section>,
    k: usize,
    line: &Described,
) -> Result<LineGeometry, InputError> {
    let index = k.to_string();
    let whole = ["lines", index.as_str()];
    let path = |key: &'static str| ["lines", index.as_str(), key];
    let from = nodes.find(source, &path("from"), &line.from)?;
    let to = nodes.find(source, &path("to"), &line.to)?;
    let section = *sections.get(&line.section).ok_or_else(|| {
        let problem = Problem::UnknownName {
            what: "section",
            name: line.section.clone(),
            known: sections.keys().cloned().collect(),
        };
        source.value(&path("section"), problem)
    })?;
    let counts = [
        (
            "elements",
            line.elements,
            MOST_ELEMENTS,
            "a count from 1 to 1000000",
        ),
        ("order", line.order, 3, "1, 2 or 3"),
    ];
    for (key, value, most, expected) in counts {
        if value == 0 || value > most {
            return Err(source.range(&whole, key, value as f64, expected));
        }
    }
    let interpolation = match line.interpolation {
        Chosen::Total => Interpolation::Total,
        Chosen::Geodesic => Interpolation::Geodesic,
    };
    let positions = [builder.position(from), builder.position(to)];
    let axis = axis(source, &index, line, positions)?;
    let stands = BeamLine {
        elements: line.elements,
        order: line.order,
        section,
    };
    let made = builder
        .line_with(
            &line.name,
            axis.as_ref(),
            [from, to],
            &stands,
            interpolation,
        )
        .map_err(|error| source.value(&whole, Problem::Model(error)))?;
    let intervals = (made.nodes.len() - 1) as f64;
    let frames = (0..made.nodes.len())
        .map(|i| axis.at(i as f64 / intervals).1)
        .collect();
    let mut carried = Vec::new();
    if section.inertia.S != Vector3::zeros() {
        let elements = made.nodes.windows(line.order + 1).step_by(line.order);
        for (e, own) in elements.enumerate() {
            let positions: Vec<_> = own.iter().map(|&n| builder.position(n)).collect();
            let frame = |xi: f64| axis.at(stands.parameter(e, xi)).1;
            let shares = beam::carried(&positions, &frame, &section).map_err(|error| {
                let element = format!("{}:{}", line.name, e + 1);
                let source_error = ModelError::Beam {
                    element,
                    source: error,
                };
                source.value(&whole, Problem::Model(source_error))
            })?;
            carried.push(shares);
        }
    }
    Ok(LineGeometry {
        name: line.name.clone(),
        order: line.order,
        interpolation,
        nodes: made.nodes,
        frames,
        carried,
        elements: made.elements,
    })
}

/// The axis of a line, checked so that it has a direction everywhere.
fn axis(
    source: &Text<'_>,
    index: &str,
    line: &Described,
    [from, to]: [Vector3<f64>; 2],
) -> Result<Box<dyn ReferenceCurve>, InputError> {
    let (whole, arc_table) = (["lines", index], ["lines", index, "arc"]);
    let path = |key: &'static str| ["lines", index, key];
    let no_direction = |at: &[&str], key: &'static str, vector: [f64; 3]| {
        let line = line.name.clone();
        source.value(at, Problem::NoDirection { line, key, vector })
    };
    let second = line.second_axis.map(Vector3::from);
    let tangent;
    let made: Box<dyn ReferenceCurve> = match line.arc {
        None => {
            tangent = to - from;
            let size = from.amax().max(to.amax());
            if tangent.norm() <= 1e-12 * size {
                let problem = Problem::ZeroLength {
                    line: line.name.clone(),
                    from: line.from.clone(),
                    to: line.to.clone(),
                    at: from.into(),
                };
                return Err(source.value(&whole, problem));
            }
            per_element(source, &whole, line, "twist_deg", line.twist_deg)?;
            Box::new(StraightLine {
                from,
                to,
                second,
                twist: line.twist_deg.to_radians(),
            })
        }
        Some(arc) => {
            let at = |key: &'static str| ["lines", index, "arc", key];
            if line.twist_deg != 0.0 {
                let line = line.name.clone();
                return Err(source.value(&path("twist_deg"), Problem::TwistedArc { line }));
            }
            let (center, direction) = (Vector3::from(arc.center), Vector3::from(arc.axis));
            let Some(axis) = Unit::try_new(direction, 0.0) else {
                return Err(no_direction(&at("axis"), "axis", arc.axis));
            };
            let radius = from - center;
            tangent = axis.cross(&radius) * arc.angle_deg.signum();
            if tangent.norm() <= 1e-12 * from.amax().max(center.amax()) {
                return Err(no_direction(&at("center"), "center", arc.center));
            }
            if arc.angle_deg == 0.0 || arc.angle_deg.abs() > 360.0 {
                let expected = "an angle between -360 and 360 degrees, not 0";
                return Err(source.range(&arc_table, "angle_deg", arc.angle_deg, expected));
            }
            per_element(source, &arc_table, line, "angle_deg", arc.angle_deg)?;
            Box::new(CircularArc {
                from,
                center,
                axis,
                angle: arc.angle_deg.to_radians(),
                second,
            })
        }
    };
    if let (Some(given), Some(second)) = (line.second_axis, second) {
        let across = tangent.normalize().cross(&second).norm();
        if second.norm() == 0.0 || across <= 1e-6 * second.norm() {
            return Err(no_direction(&path("second_axis"), "second_axis", given));
        }
    }
    Ok(made)
}

/// Refuses angles of half a turn and more between the ends of an element, whose sense of rotation would be ambiguous.
fn per_element(
    source: &Text<'_>,
    table: &[&str],
    line: &Described,
    key: &'static str,
    degrees: f64,
) -> Result<(), InputError> {
    if degrees.abs() < 180.0 * line.elements as f64 {
        return Ok(());
    }
    let expected =
        "less than 180 degrees from one end of an element to the other: take more elements";
    Err(source.range(table, key, degrees, expected))
}
