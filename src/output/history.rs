//! `history.csv`: one row per converged step and located event.

use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// Columns before those of the probes.
pub const COLUMNS: [&str; 13] = [
    "row",
    "step",
    "event",
    "t",
    "step_size",
    "iterations",
    "residual_force",
    "residual_moment",
    "residual_over_tolerance",
    "last_correction",
    "chart_changes",
    "largest_rotation",
    "strain_energy",
];

/// Columns after those in statics.
pub const STATIC_COLUMNS: [&str; 1] = ["unstable"];

/// Columns after those in dynamics.
pub const DYNAMIC_COLUMNS: [&str; 2] = ["kinetic_energy", "energy_defect"];

/// A converged step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct HistoryRow {
    /// Number of the step; 0 is the start.
    pub step: usize,
    /// The located event, if any.
    pub event: Option<String>,
    /// Load parameter or time.
    pub t: f64,
    /// Step in it, or along the path.
    pub step_size: f64,
    /// Linear solutions since the row before.
    pub iterations: usize,
    /// Largest residual force and moment.
    pub residual: [f64; 2],
    /// The larger of the two relative to its tolerance.
    pub ratio: f64,
    /// Last correction, relative to the scale of its coordinate.
    pub correction: f64,
    /// Charts changed since the row before.
    pub chart_changes: usize,
    /// Largest rotation angle ψ of any node in its chart, in radians.
    pub largest_rotation: f64,
    /// Strain energy.
    pub strain_energy: f64,
    /// Number of unstable directions of an equilibrium, where known; in statics.
    #[serde(default)]
    pub unstable: Option<usize>,
    /// Kinetic energy, and the defect of the energy balance; in dynamics.
    pub motion: Option<[f64; 2]>,
    /// Values of the probes.
    pub probes: Vec<f64>,
}

/// The whole file.
pub(super) fn csv(probes: &[String], rows: &[HistoryRow]) -> String {
    let mut out = COLUMNS.join(",");
    let moving = rows.iter().any(|row| row.motion.is_some());
    let more: &[&str] = if moving {
        &DYNAMIC_COLUMNS
    } else {
        &STATIC_COLUMNS
    };
    out += ",";
    out += &more.join(",");
    for probe in probes {
        out += ",";
        out += probe;
    }
    out += "\n";
    for (k, row) in rows.iter().enumerate() {
        let event = row.event.as_deref().unwrap_or_default();
        let [force, moment] = row.residual;
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "{k},{},{event},{:?},{:?},{},{force:?},{moment:?},{:?},{:?},{},{:?},{:?}",
            row.step,
            row.t,
            row.step_size,
            row.iterations,
            row.ratio,
            row.correction,
            row.chart_changes,
            row.largest_rotation,
            row.strain_energy,
        );
        if !moving {
            out += ",";
            out += &row.unstable.map_or_else(String::new, |n| n.to_string());
        }
        for value in row.motion.iter().flatten().chain(&row.probes) {
            // Zero has no sign.
            let _ = write!(out, ",{:?}", value + 0.0);
        }
        out += "\n";
    }
    out
}
