//! ParaView files: an unstructured grid per step and a collection of them.
//!
//! Each line has points of its own, so that lines that meet at a node keep their section axes. A
//! body is a point of its own at its centre of mass.

#![allow(non_snake_case)]

use crate::input::Geometry;
use crate::probe::Answers;
use nalgebra::Vector3;
use pullback_elements::model::Model;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A grid and its time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
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
pub fn collection(frames: &[Frame]) -> String {
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

/// The grid (`.vtu`) of a model in its present configuration: points where the nodes are now, and
/// in statics the load parameter.
pub fn grid(model: &Model, geometry: &Geometry, answers: &Answers, load: Option<f64>) -> String {
    let mut points = Vec::new();
    let mut displacement = Vec::new();
    let mut rotation = Vec::new();
    let mut rates: [Vec<Vector3<f64>>; 2] = Default::default();
    let mut axes: [Vec<Vector3<f64>>; 3] = Default::default();
    let mut connectivity = Vec::new();
    let mut offsets = Vec::new();
    let mut types = Vec::new();
    let mut line_number = Vec::new();
    let mut resultants: [Vec<Vector3<f64>>; 4] = Default::default();
    for (l, line) in geometry.lines.iter().enumerate() {
        let first = points.len();
        for (&node, R0) in line.nodes.iter().zip(&line.frames) {
            let state = model.node_state(node);
            points.push(state.place);
            displacement.push(state.d);
            rotation.push(state.psi);
            rates[0].push(state.velocity);
            rates[1].push(state.omega);
            let frame = state.R * R0;
            for (k, axis) in axes.iter_mut().enumerate() {
                axis.push(frame.column(k).into_owned());
            }
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
    for body in &geometry.bodies {
        let state = model.node_state(body.node);
        let arm = state.R * body.center;
        connectivity.push(points.len());
        points.push(state.place + arm);
        displacement.push(state.d + arm - body.center);
        rotation.push(state.psi);
        rates[0].push(state.velocity + state.omega.cross(&arm));
        rates[1].push(state.omega);
        for (k, axis) in axes.iter_mut().enumerate() {
            axis.push(state.R.column(k).into_owned());
        }
        offsets.push(connectivity.len());
        types.push(VERTEX);
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
        points.len(),
        types.len()
    );
    out += "<Points>\n";
    vectors(&mut out, "Points", &points);
    out += "</Points>\n<Cells>\n";
    integers(&mut out, "connectivity", "Int64", &connectivity);
    integers(&mut out, "offsets", "Int64", &offsets);
    integers(&mut out, "types", "UInt8", &types);
    out += "</Cells>\n<PointData Vectors=\"displacement\">\n";
    vectors(&mut out, "displacement", &displacement);
    vectors(&mut out, "rotation", &rotation);
    if answers.is_moving() {
        vectors(&mut out, "velocity", &rates[0]);
        vectors(&mut out, "angular_velocity", &rates[1]);
    }
    for (name, axis) in ["e1", "e2", "e3"].into_iter().zip(&axes) {
        vectors(&mut out, name, axis);
    }
    out += "</PointData>\n<CellData>\n";
    for (name, values) in ["N", "M", "Gamma", "K"].into_iter().zip(&resultants) {
        vectors(&mut out, name, values);
    }
    integers(&mut out, "line", "Int32", &line_number);
    out + "</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
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
