//! Sections and the reference file, shared by the tests.

#![allow(non_snake_case, dead_code)]

use nalgebra::{DMatrix, DVector, Matrix6};
use pullback_elements::beam::Section;
use serde_json::Value;

/// A diagonal section of which no two stiffnesses are equal.
pub fn section() -> Section {
    Section::diagonal(100.0, [40.0, 50.0], 3.0, [5.0, 7.0]).unwrap()
}

/// A section in which everything couples: an axis away from centroid and shear centre, and more.
pub fn coupled() -> Section {
    let mut C = Matrix6::from_diagonal(&[100.0, 40.0, 50.0, 30.0, 50.0, 70.0].into());
    for i in 0..6 {
        for j in 0..i {
            let c = ((3 * i + 7 * j) as f64).sin() * 8.0;
            C[(i, j)] = c;
            C[(j, i)] = c;
        }
    }
    Section::new(C).unwrap()
}

pub fn reference(section: &str) -> Vec<Value> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/reference/tensors.json"
    );
    let text = std::fs::read_to_string(path).expect("reference file");
    let data: Value = serde_json::from_str(&text).expect("valid JSON");
    data[section].as_array().expect("rows").clone()
}

pub fn numbers(v: &Value) -> Vec<f64> {
    let list = v.as_array().expect("list");
    list.iter().map(|x| x.as_f64().expect("number")).collect()
}

pub fn vector(v: &Value) -> DVector<f64> {
    DVector::from_vec(numbers(v))
}

pub fn matrix(v: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = v.as_array().expect("rows").iter().map(numbers).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}
