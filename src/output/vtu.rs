//! ParaView files: an unstructured grid per step and a collection of them.
//!
//! Each line has its own points, so that lines that meet at a node keep their section axes. A body
//! is a point at its centre of mass, a rigid link or spring a line between two points.

#![allow(non_snake_case)]

use crate::input::Geometry;
use crate::probe::Answers;
use nalgebra::{Matrix3, Vector3};
use pullback_elements::model::{Context, NodeId};
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A grid and its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct VtuFrame {
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
pub(super) fn collection(frames: &[VtuFrame]) -> String {
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
pub(super) fn grid(
    context: &Context,
    geometry: &Geometry,
    answers: &Answers,
    load: Option<f64>,
) -> String {
    let (points, cells) = parts(context, geometry, answers);
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
        cells.types.len()
    );
    out += "<Points>\n";
    vectors(&mut out, "Points", &points.positions);
    out += "</Points>\n<Cells>\n";
    integers(&mut out, "connectivity", "Int64", &cells.connectivity);
    integers(&mut out, "offsets", "Int64", &cells.offsets);
    integers(&mut out, "types", "UInt8", &cells.types);
    out += "</Cells>\n<PointData Vectors=\"displacement\">\n";
    vectors(&mut out, "displacement", &points.displacement);
    vectors(&mut out, "rotation", &points.rotation);
    if answers.motion.is_some() {
        vectors(&mut out, "velocity", &points.velocity);
        vectors(&mut out, "angular_velocity", &points.omega);
    }
    for (name, axis) in ["e1", "e2", "e3"].into_iter().zip(&points.axes) {
        vectors(&mut out, name, axis);
    }
    vectors(&mut out, "reference", &points.reference());
    names(&mut out, &points.names);
    out += "</PointData>\n<CellData>\n";
    for (name, values) in ["N", "M", "Gamma", "K"].into_iter().zip(&cells.resultants) {
        vectors(&mut out, name, values);
    }
    integers(&mut out, "line", "Int32", &cells.line_number);
    out + "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
}

/// The points and cells of all lines, bodies and links.
fn parts<'a>(context: &'a Context, geometry: &Geometry, answers: &Answers) -> (Points<'a>, Cells) {
    let (mut points, mut cells) = (Points::default(), Cells::default());
    for (l, line) in geometry.lines.iter().enumerate() {
        let first = points.positions.len();
        for (&node, R0) in line.nodes.iter().zip(&line.frames) {
            points.push(context, node, Vector3::zeros(), R0);
        }
        for (e, &id) in line.elements.iter().enumerate() {
            let start = first + e * line.order;
            // Both ends come first, then the inner nodes.
            let ends = [start, start + line.order];
            let own = ends.into_iter().chain(start + 1..start + line.order);
            let means = [
                answers.mean(id, |s| s.N),
                answers.mean(id, |s| s.M),
                answers.mean(id, |s| s.Gamma),
                answers.mean(id, |s| s.K),
            ];
            cells.push(CELL_TYPES[(line.order - 1).min(2)], own, l + 1, means);
        }
    }
    let bodies = geometry.bodies.iter();
    let bodies = bodies.map(|b| (VERTEX, vec![(b.node, b.center)]));
    let links = geometry.links.iter();
    let links = links.map(|ends| (CELL_TYPES[0], ends.map(|n| (n, Vector3::zeros())).to_vec()));
    for (cell_type, all) in bodies.chain(links) {
        let first = points.positions.len();
        for (node, center) in all {
            points.push(context, node, center, &Matrix3::identity());
        }
        let own = first..points.positions.len();
        cells.push(cell_type, own, 0, [Vector3::zeros(); 4]);
    }
    (points, cells)
}

/// Cells and their data.
#[derive(Default)]
struct Cells {
    connectivity: Vec<usize>,
    offsets: Vec<usize>,
    types: Vec<u8>,
    /// Numbers of lines from 1; 0 for bodies and links.
    line_number: Vec<usize>,
    /// N, M, Γ and K.
    resultants: [Vec<Vector3<f64>>; 4],
}

impl Cells {
    fn push(
        &mut self,
        cell_type: u8,
        points: impl Iterator<Item = usize>,
        line_number: usize,
        resultants: [Vector3<f64>; 4],
    ) {
        self.connectivity.extend(points);
        self.offsets.push(self.connectivity.len());
        self.types.push(cell_type);
        self.line_number.push(line_number);
        for (all, own) in self.resultants.iter_mut().zip(resultants) {
            all.push(own);
        }
    }
}

/// Points and their data.
#[derive(Default)]
struct Points<'a> {
    /// Names of the nodes.
    names: Vec<&'a str>,
    positions: Vec<Vector3<f64>>,
    displacement: Vec<Vector3<f64>>,
    rotation: Vec<Vector3<f64>>,
    velocity: Vec<Vector3<f64>>,
    omega: Vec<Vector3<f64>>,
    axes: [Vec<Vector3<f64>>; 3],
}

impl<'a> Points<'a> {
    /// A point that is at `center` as seen from a node in the reference configuration, with axes that
    /// are the columns of `R0` there.
    fn push(
        &mut self,
        context: &'a Context,
        node: NodeId,
        center: Vector3<f64>,
        R0: &Matrix3<f64>,
    ) {
        self.names.push(context.node(node).name());
        let node = context.node_state(node);
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

    fn reference(&self) -> Vec<Vector3<f64>> {
        let pairs = self.positions.iter().zip(&self.displacement);
        pairs.map(|(x, d)| x - d).collect()
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

/// Strings are the codes of their bytes, each string with a zero at its end.
fn names(out: &mut String, names: &[&str]) {
    *out += "<DataArray type=\"String\" Name=\"node\" format=\"ascii\">\n";
    for name in names {
        name.bytes().for_each(|byte| {
            let _ = write!(out, "{byte} ");
        });
        *out += "0\n";
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
