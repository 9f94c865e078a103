//! Comparisons of models of the gallery.

use pullback::input::{self, Analysis, ModelFile};
use pullback::studies::compare::{CompareError, Comparison, ComparisonOptions, Hooks, compare};
use std::path::Path;

pub fn model(name: &str) -> ModelFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let text = std::fs::read_to_string(path.join(name)).unwrap();
    input::parse(name, &text).unwrap()
}

pub fn until(mut file: ModelFile, to: f64) -> ModelFile {
    match &mut file.analysis {
        Analysis::Dynamic(d) => d.to = to,
        _ => panic!("no motion"),
    }
    file
}

pub fn options(words: &[&str], steps: &[f64]) -> ComparisonOptions {
    let schemes = words.iter().map(|w| w.parse().unwrap());
    ComparisonOptions::new(schemes.collect(), steps.to_vec())
}

pub fn compared(file: &ModelFile, options: &ComparisonOptions) -> Result<Comparison, CompareError> {
    let make = |formulation| input::job("model.toml", file, Some(formulation));
    compare(&make, "model.toml", options, &Hooks::NONE)
}
