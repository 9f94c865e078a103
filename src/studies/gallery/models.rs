//! The model files of the gallery, for programs without the repository.

use std::path::Path;

macro_rules! models {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../../examples/models/", $name, ".toml")))),*]
    };
}

/// Names and texts of all files in examples/models.
pub const MODELS: &[(&str, &str)] = models![
    "arm_revolute",
    "arm_spherical",
    "bend45",
    "bending_torsion",
    "bricard",
    "cantilever",
    "column",
    "deep_arch",
    "double_pendulum",
    "elastica",
    "elbow",
    "flying_beam",
    "follower",
    "four_bar",
    "four_bar_flexible",
    "four_bar_misaligned",
    "free_body",
    "ground_resonance",
    "heavy_top",
    "helix",
    "hooke",
    "lee_frame",
    "parallelograms",
    "pendulum",
    "princeton",
    "rollup",
    "rotating_blade",
    "rubber_rod",
    "shear_flexible",
    "slider_crank",
    "slider_crank_flexible",
    "spin_up",
    "squeezer",
    "top",
    "top_beam",
    "twisted",
];

/// The text of a model named on a command line instead of a file.
pub fn model(name: &Path) -> Option<&'static str> {
    let name = name.to_str()?.replace('-', "_");
    let found = MODELS.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text)
}
