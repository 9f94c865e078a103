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
    /// Whether its grid has been written.
    pub grid: bool,
}

/// The numbers of a history.
#[derive(Clone, Debug)]
pub struct History {
    /// Names of the columns: those of `history.csv` but for `row` and `event`, which are no numbers.
    pub columns: Vec<String>,
    /// Number of columns before those of the probes.
    general: usize,
    /// Located events by row.
    pub events: Vec<Option<String>>,
    /// Row by row.
    values: Vec<f64>,
}

impl History {
    pub(super) fn new(probes: Vec<String>, rows: &[HistoryRow]) -> Self {
        let names = COLUMNS
            .iter()
            .filter(|name| !["row", "event"].contains(name));
        let moving = rows.iter().any(|row| row.motion.is_some());
        let more: &[&str] = match moving {
            true => &DYNAMIC_COLUMNS,
            false => &STATIC_COLUMNS,
        };
        let mut columns: Vec<String> = names.chain(more).map(|name| (*name).to_owned()).collect();
        let general = columns.len();
        columns.extend(probes);
        let mut values = Vec::new();
        for row in rows {
            let [force, moment] = row.residual;
            values.extend([
                row.step as f64,
                row.t,
                row.step_size,
                row.iterations as f64,
                force,
                moment,
                row.ratio,
                row.correction,
                row.chart_changes as f64,
                row.largest_rotation,
                row.strain_energy,
            ]);
            if !moving {
                values.push(row.unstable.map_or(f64::NAN, |n| n as f64));
            }
            values.extend(row.motion.iter().flatten().chain(&row.probes));
        }
        Self {
            columns,
            general,
            events: rows.iter().map(|row| row.event.clone()).collect(),
            values,
        }
    }

    /// The columns of the probes.
    pub fn probes(&self) -> std::ops::Range<usize> {
        self.general..self.columns.len()
    }

    /// The values of a column, in the order of the rows.
    pub fn column(&self, k: usize) -> impl DoubleEndedIterator<Item = f64> {
        let rows = self.values.chunks_exact(self.columns.len().max(1));
        rows.filter_map(move |row| row.get(k).copied())
    }

    /// The number of a column.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}

/// The whole file: the history, with the number and the event of each row.
pub(super) fn csv(history: &History) -> String {
    let mut out = format!("row,step,event,{}\n", history.columns[1..].join(","));
    let rows = history.values.chunks_exact(history.columns.len());
    for (k, (row, event)) in rows.zip(&history.events).enumerate() {
        let event = event.as_deref().unwrap_or_default();
        // Writing to a string cannot fail.
        let _ = write!(out, "{k},{},{event}", row[0]);
        for (name, x) in history.columns.iter().zip(row).skip(1) {
            let _ = match name.as_str() {
                "unstable" if x.is_nan() => write!(out, ","),
                "iterations" | "chart_changes" | "unstable" => write!(out, ",{x}"),
                // Zero has no sign.
                _ => write!(out, ",{:?}", x + 0.0),
            };
        }
        out += "\n";
    }
    out
}
