//! ParaView files: an unstructured grid per step and a collection of them.
//!
//! Each line has its own points, so that lines that meet at a node keep their section axes. A body
//! is a point at its centre of mass, a rigid link or spring a line between two points. Arrays are binary.

#![allow(non_snake_case)]

use crate::input::Geometry;
use crate::probe::Answers;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nalgebra::{Matrix3, Vector3};
use pullback_elements::model::{Context, NodeId};
use std::fmt::Write;

/// A grid and its time.
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
    let mut out = "<?xml version=\"1.0\"?>\n\
                   <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
                   header_type=\"UInt64\">\n<UnstructuredGrid>\n"
        .to_owned();
    if let Some(load) = load {
        out += "<FieldData>\n";
        let about = "type=\"Float64\" Name=\"load_parameter\" NumberOfTuples=\"1\"";
        array(&mut out, about, [load.to_le_bytes()]);
        out += "</FieldData>\n";
    }
    let _ = writeln!(
        out,
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">",
        points.positions.len(),
        cells.types.len()
    );
    out += "<Points>\n";
    vectors(&mut out, "Points", &points.positions);
    out += "</Points>\n<Cells>\n";
    let (connectivity, offsets) = (&cells.connectivity, &cells.offsets);
    for (name, values) in [("connectivity", connectivity), ("offsets", offsets)] {
        let about = format!("type=\"Int64\" Name=\"{name}\"");
        array(&mut out, &about, values.iter().map(|i| i.to_le_bytes()));
    }
    let types = cells.types.iter().map(|kind| [*kind]);
    array(&mut out, "type=\"UInt8\" Name=\"types\"", types);
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
    // Each string ends with a zero.
    let bytes = (points.names.iter()).flat_map(|name| name.bytes().chain([0]));
    array(
        &mut out,
        "type=\"String\" Name=\"node\"",
        bytes.map(|byte| [byte]),
    );
    out += "</PointData>\n<CellData>\n";
    for (name, values) in ["N", "M", "Gamma", "K"].into_iter().zip(&cells.resultants) {
        vectors(&mut out, name, values);
    }
    let lines = cells.lines.iter().map(|line| line.to_le_bytes());
    array(&mut out, "type=\"Int32\" Name=\"line\"", lines);
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
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    types: Vec<u8>,
    /// Numbers of lines from 1; 0 for bodies and links.
    lines: Vec<i32>,
    /// N, M, Γ and K.
    resultants: [Vec<Vector3<f64>>; 4],
}

impl Cells {
    fn push(
        &mut self,
        cell_type: u8,
        points: impl Iterator<Item = usize>,
        line: usize,
        resultants: [Vector3<f64>; 4],
    ) {
        self.connectivity.extend(points.map(|point| point as i64));
        self.offsets.push(self.connectivity.len() as i64);
        self.types.push(cell_type);
        self.lines.push(line as i32);
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
    let about = format!("type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"3\"");
    let numbers = values.iter().flat_map(|v| [v.x, v.y, v.z]);
    array(out, &about, numbers.map(f64::to_le_bytes));
}

/// An array of values by their bytes, in Base64 with their number before them.
fn array<const N: usize>(out: &mut String, about: &str, values: impl IntoIterator<Item = [u8; N]>) {
    let mut bytes = vec![0; size_of::<u64>()];
    for value in values {
        bytes.extend_from_slice(&value);
    }
    let (number, data) = bytes.split_at_mut(size_of::<u64>());
    number.copy_from_slice(&(data.len() as u64).to_le_bytes());
    let _ = write!(out, "<DataArray {about} format=\"binary\">");
    BASE64_STANDARD.encode_string(&bytes, out);
    *out += "</DataArray>\n";
}
