//! Comparisons of models of the gallery, and the exact motion of its pendulum.

use pullback::input::{self, Analysis, ModelFile};
use pullback::studies::compare::{
    CompareError, Comparison, ComparisonOptions, Hooks, Sample, compare,
};
use pullback::studies::gallery::exact;
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

/// Position and velocity alone of the bob of the pendulum of the gallery, by Jacobi's elliptic functions.
pub fn bob(sample: &mut Sample) {
    let mut exactly = Sample::unknown(sample.t, 2);
    let nodes = ["pivot", "rod"].map(str::to_owned);
    exact("pendulum", &nodes).unwrap().fill(&mut exactly);
    let known = exactly.nodes[1];
    // The node of the joint comes first, then that of the rod.
    let rod = sample.nodes.len() - 1;
    sample.nodes[rod].position = known.position;
    sample.nodes[rod].velocity = known.velocity;
    sample.energy = 0.0;
    sample.gross_energy = 1.0;
}
