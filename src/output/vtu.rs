//! ParaView files: an unstructured grid per step and a collection of them.
//!
//! Each line has its own points, so that lines that meet at a node keep their section axes. A body
//! is a point at its centre of mass, a rigid link or spring a line between two points. Arrays are binary.

use crate::input::Geometry;
use crate::probe::Answers;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use nalgebra::{Matrix3, Vector3};
use pullback_elements::model::{Context, NodeId, NodeState};

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
        out += &format!(
            "<DataSet timestep=\"{:?}\" part=\"0\" file=\"{}\"/>\n",
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
    out += &format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        points.len(),
        cells.len()
    );
    out += "<Points>\n";
    vectors(&mut out, "Points", points.iter().map(Point::position));
    out += "</Points>\n<Cells>\n";
    let connectivity = cells.iter().flat_map(|cell| &cell.points);
    let connectivity = connectivity.map(|point| (*point as i64).to_le_bytes());
    array(
        &mut out,
        "type=\"Int64\" Name=\"connectivity\"",
        connectivity,
    );
    let offsets = cells.iter().scan(0, |end: &mut i64, cell| {
        *end += cell.points.len() as i64;
        Some(end.to_le_bytes())
    });
    array(&mut out, "type=\"Int64\" Name=\"offsets\"", offsets);
    let types = cells.iter().map(|cell| [cell.cell_type]);
    array(&mut out, "type=\"UInt8\" Name=\"types\"", types);
    out += "</Cells>\n<PointData Vectors=\"displacement\">\n";
    point_data(&mut out, &points, answers.motion.is_some());
    out += "</PointData>\n<CellData>\n";
    for (k, name) in ["N", "M", "Gamma", "K"].into_iter().enumerate() {
        vectors(&mut out, name, cells.iter().map(|cell| cell.means[k]));
    }
    let lines = cells.iter().map(|cell| (cell.line as i32).to_le_bytes());
    array(&mut out, "type=\"Int32\" Name=\"line\"", lines);
    out + "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
}

/// The arrays of points; velocities in a motion.
fn point_data(out: &mut String, points: &[Point<'_>], moving: bool) {
    let points = || points.iter();
    vectors(out, "displacement", points().map(Point::displacement));
    vectors(out, "rotation", points().map(|p| p.node.psi));
    if moving {
        let velocity = |p: &Point<'_>| p.node.velocity + p.node.omega.cross(&p.arm);
        vectors(out, "velocity", points().map(velocity));
        vectors(out, "angular_velocity", points().map(|p| p.node.omega));
    }
    for (k, name) in ["e1", "e2", "e3"].into_iter().enumerate() {
        vectors(out, name, points().map(|p| p.axes.column(k).into()));
    }
    let reference = points().map(|p| p.position() - p.displacement());
    vectors(out, "reference", reference);
    // Each string ends with a zero.
    let bytes = points().flat_map(|p| p.name.bytes().chain([0]));
    let about = "type=\"String\" Name=\"node\"";
    array(out, about, bytes.map(|byte| [byte]));
}

/// A point that moves with a node.
struct Point<'a> {
    /// Name of the node.
    name: &'a str,
    node: NodeState,
    /// Position as seen from the node, and that in the reference configuration.
    arm: Vector3<f64>,
    center: Vector3<f64>,
    /// Section axes, as columns.
    axes: Matrix3<f64>,
}

impl Point<'_> {
    fn position(&self) -> Vector3<f64> {
        self.node.position + self.arm
    }

    fn displacement(&self) -> Vector3<f64> {
        self.node.d + self.arm - self.center
    }
}

struct Cell {
    cell_type: u8,
    points: Vec<usize>,
    /// Number of the line from 1; 0 for bodies and links.
    line: usize,
    /// N, M, Γ and K.
    means: [Vector3<f64>; 4],
}

/// The points and cells of all lines, bodies and links.
fn parts<'a>(
    context: &'a Context,
    geometry: &Geometry,
    answers: &Answers,
) -> (Vec<Point<'a>>, Vec<Cell>) {
    let (mut points, mut cells) = (Vec::new(), Vec::new());
    let point = |id: NodeId, center: Vector3<f64>, R0: &Matrix3<f64>| {
        let node = context.node_state(id);
        Point {
            name: context.node(id).name(),
            arm: node.R * center,
            center,
            axes: node.R * R0,
            node,
        }
    };
    for (l, line) in geometry.lines.iter().enumerate() {
        let first = points.len();
        let nodes = line.nodes.iter().zip(&line.frames);
        points.extend(nodes.map(|(&id, R0)| point(id, Vector3::zeros(), R0)));
        for (e, &id) in line.elements.iter().enumerate() {
            let start = first + e * line.order;
            // Both ends come first, then the inner nodes.
            let ends = [start, start + line.order];
            cells.push(Cell {
                cell_type: CELL_TYPES[(line.order - 1).min(2)],
                points: ends.into_iter().chain(start + 1..ends[1]).collect(),
                line: l + 1,
                means: [
                    answers.mean(id, |s| s.N),
                    answers.mean(id, |s| s.M),
                    answers.mean(id, |s| s.Gamma),
                    answers.mean(id, |s| s.K),
                ],
            });
        }
    }
    let bodies = geometry.bodies.iter();
    let bodies = bodies.map(|b| (VERTEX, vec![(b.node, b.center)]));
    let links = geometry.links.iter();
    let links = links.map(|ends| (CELL_TYPES[0], ends.map(|n| (n, Vector3::zeros())).to_vec()));
    for (cell_type, all) in bodies.chain(links) {
        let first = points.len();
        let all = all.into_iter();
        points.extend(all.map(|(id, center)| point(id, center, &Matrix3::identity())));
        cells.push(Cell {
            cell_type,
            points: (first..points.len()).collect(),
            line: 0,
            means: [Vector3::zeros(); 4],
        });
    }
    (points, cells)
}

fn vectors(out: &mut String, name: &str, values: impl Iterator<Item = Vector3<f64>>) {
    let about = format!("type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"3\"");
    let numbers = values.flat_map(|v| [v.x, v.y, v.z]);
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
    *out += &format!("<DataArray {about} format=\"binary\">");
    BASE64_STANDARD.encode_string(&bytes, out);
    *out += "</DataArray>\n";
}
