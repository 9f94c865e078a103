//! ParaView files: an unstructured grid per step and a collection of them.
//!
//! Each line has its own points, so that lines that meet at a node keep their section axes. A body
//! is a point at its centre of mass, a rigid link or spring a line between two points.

#![allow(non_snake_case)]

use crate::input::Geometry;
use crate::probe::Answers;
use nalgebra::{Matrix3, Vector3};
use pullback_elements::model::{Context, NodeState};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A grid and its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VtuFrame {
    /// Load parameter or time, and along a path the number of the row.
    pub t: f64,
    /// File name.
    pub file: String,
}

/// Cell types: line, quadratic edge, cubic line.
const CELL_TYPES: [u8; 3] = [3, 21, 35];
/// Cell type of a point.
const VERTEX: u8 = 1;

/// The collection (`.pvd`) of grids.
pub fn collection(frames: &[VtuFrame]) -> String {
    let mut out = "<?xml version=\"1.0\"?>\n\
                   <VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
                   <Collection>\n"
        .to_owned();
    for frame in frames {
        let _ = writeln!(
            out,
            "<DataSet timestep=\"{:?}\" part=\"0\" file=\"{}\"/>",
            frame.t, frame.file
        );
    }
    out + "</Collection>\n</VTKFile>\n"
}

/// The grid (`.vtu`) of a model in its present configuration, in statics with the load parameter.
pub fn grid(
    context: &Context,
    geometry: &Geometry,
    answers: &Answers,
    load: Option<f64>,
) -> String {
    let mut points = Points::default();
    let mut connectivity = Vec::new();
    let mut offsets = Vec::new();
    let mut types = Vec::new();
    let mut line_number = Vec::new();
    let mut resultants: [Vec<Vector3<f64>>; 4] = Default::default();
    for (l, line) in geometry.lines.iter().enumerate() {
        let first = points.positions.len();
        for (&node, R0) in line.nodes.iter().zip(&line.frames) {
            points.push(&context.node_state(node), Vector3::zeros(), R0);
        }
        for (e, &id) in line.elements.iter().enumerate() {
            let start = first + e * line.order;
            // Both ends come first, then the inner nodes.
            connectivity.extend([start, start + line.order]);
            connectivity.extend(start + 1..start + line.order);
            offsets.push(connectivity.len());
            types.push(CELL_TYPES[(line.order - 1).min(2)]);
            line_number.push(l + 1);
            resultants[0].push(answers.mean(id, |s| s.N));
            resultants[1].push(answers.mean(id, |s| s.M));
            resultants[2].push(answers.mean(id, |s| s.Gamma));
            resultants[3].push(answers.mean(id, |s| s.K));
        }
    }
    let bodies = geometry.bodies.iter();
    let bodies = bodies.map(|b| (VERTEX, vec![(b.node, b.center)]));
    let links = geometry.links.iter();
    let links = links.map(|ends| (CELL_TYPES[0], ends.map(|n| (n, Vector3::zeros())).to_vec()));
    for (cell_type, all) in bodies.chain(links) {
        for (node, center) in all {
            connectivity.push(points.positions.len());
            points.push(&context.node_state(node), center, &Matrix3::identity());
        }
        offsets.push(connectivity.len());
        types.push(cell_type);
        line_number.push(0);
        for part in &mut resultants {
            part.push(Vector3::zeros());
        }
    }
    let mut out = format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n\
         <UnstructuredGrid>\n\
         {}\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        load.map_or_else(String::new, |load| format!(
            "<FieldData>\n<DataArray type=\"Float64\" Name=\"load_parameter\" \
             NumberOfTuples=\"1\" format=\"ascii\">\n{load:?}\n</DataArray>\n</FieldData>\n"
        )),
        points.positions.len(),
        types.len()
    );
    out += "<Points>\n";
    vectors(&mut out, "Points", &points.positions);
    out += "</Points>\n<Cells>\n";
    integers(&mut out, "connectivity", "Int64", &connectivity);
    integers(&mut out, "offsets", "Int64", &offsets);
    integers(&mut out, "types", "UInt8", &types);
    out += "</Cells>\n<PointData Vectors=\"displacement\">\n";
    vectors(&mut out, "displacement", &points.displacement);
    vectors(&mut out, "rotation", &points.rotation);
    if answers.is_moving() {
        vectors(&mut out, "velocity", &points.velocity);
        vectors(&mut out, "angular_velocity", &points.omega);
    }
    for (name, axis) in ["e1", "e2", "e3"].into_iter().zip(&points.axes) {
        vectors(&mut out, name, axis);
    }
    out += "</PointData>\n<CellData>\n";
    for (name, values) in ["N", "M", "Gamma", "K"].into_iter().zip(&resultants) {
        vectors(&mut out, name, values);
    }
    integers(&mut out, "line", "Int32", &line_number);
    out + "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
}

/// Points and their data.
#[derive(Default)]
struct Points {
    positions: Vec<Vector3<f64>>,
    displacement: Vec<Vector3<f64>>,
    rotation: Vec<Vector3<f64>>,
    velocity: Vec<Vector3<f64>>,
    omega: Vec<Vector3<f64>>,
    axes: [Vec<Vector3<f64>>; 3],
}

impl Points {
    /// A point that is at `center` as seen from a node in the reference configuration, with axes that
    /// are the columns of `R0` there.
    fn push(&mut self, node: &NodeState, center: Vector3<f64>, R0: &Matrix3<f64>) {
        let arm = node.R * center;
        self.positions.push(node.position + arm);
        self.displacement.push(node.d + arm - center);
        self.rotation.push(node.psi);
        self.velocity.push(node.velocity + node.omega.cross(&arm));
        self.omega.push(node.omega);
        let frame = node.R * R0;
        for (k, axis) in self.axes.iter_mut().enumerate() {
            axis.push(frame.column(k).into_owned());
        }
    }
}

fn vectors(out: &mut String, name: &str, values: &[Vector3<f64>]) {
    let _ = writeln!(
        out,
        "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"3\" format=\"ascii\">"
    );
    for v in values {
        let _ = writeln!(out, "{:e} {:e} {:e}", v.x, v.y, v.z);
    }
    *out += "</DataArray>\n";
}

fn integers<T: std::fmt::Display>(out: &mut String, name: &str, kind: &str, values: &[T]) {
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">"
    );
    for row in values.chunks(20) {
        let words: Vec<String> = row.iter().map(T::to_string).collect();
        let _ = writeln!(out, "{}", words.join(" "));
    }
    *out += "</DataArray>\n";
}
