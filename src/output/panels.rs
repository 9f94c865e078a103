//! Panels of the figure of the history.

use super::history::HistoryRow;
use super::plot::{AxisScale, Graph, PlotCurve};
use crate::input::{Dimension, Plan, ProbeQuantity, Units};
use crate::probe::Probe;

/// Most curves in a panel.
const CURVES: usize = 6;

/// Values below this fraction of their scale in the model are round-off.
const ROUND_OFF: f64 = 1e-12;

/// Scales of the values of a model.
struct Scales {
    /// The largest extent of the structure during the run.
    length: f64,
    /// The range of time, or of the load parameter.
    time: f64,
    /// The largest sum of kinetic and strain energy.
    energy: f64,
}

impl Scales {
    fn of(length: f64, rows: &[HistoryRow]) -> Self {
        let energy =
            |row: &HistoryRow| row.strain_energy.abs() + row.motion.map_or(0.0, |m| m[0].abs());
        let times = rows.first().zip(rows.last());
        Self {
            length,
            time: times.map_or(0.0, |(first, last)| (last.t - first.t).abs()),
            energy: rows.iter().map(energy).fold(0.0, f64::max),
        }
    }

    /// The scale of values of a dimension; zero if none is known.
    fn size(&self, [force, length, time, _]: Dimension) -> f64 {
        // A force is an energy over a length, which cancels in moments and energies of a point.
        let size =
            self.energy.powi(force) * self.length.powi(length - force) * self.time.powi(time);
        if size.is_finite() { size } else { 0.0 }
    }
}

/// Draws zero if a panel has nothing but round-off, which full scale would show as a result.
fn without_noise(curves: &mut [PlotCurve], size: f64) {
    let values = curves.iter().flat_map(|c| &c.points).map(|p| p.1.abs());
    if values.fold(0.0, f64::max) < ROUND_OFF * size {
        let points = curves.iter_mut().flat_map(|c| &mut c.points);
        points.for_each(|p| p.1 = 0.0);
    }
}

/// One panel per quantity and dimension (more if there are many curves), in the order of the probes; the strain
/// energy if there are none. `length` is the largest extent of the structure during the run.
pub(super) fn panels(
    plan: &Plan,
    units: &Units,
    probes: &[Probe],
    rows: &[HistoryRow],
    length: f64,
) -> Vec<Graph> {
    let scales = Scales::of(length, rows);
    let curve = |label: String, value: &dyn Fn(&HistoryRow) -> f64| {
        PlotCurve::new(label, rows.iter().map(|row| (row.t, value(row))).collect())
    };
    let mut panels: Vec<(ProbeQuantity, Dimension, Vec<PlotCurve>)> = Vec::new();
    let mut column = 0;
    for probe in probes {
        let (quantity, dimension, labels) = (probe.quantity, probe.dimension(), probe.columns());
        let room = |(q, d, curves): &(ProbeQuantity, Dimension, Vec<PlotCurve>)| {
            (*q, *d) == (quantity, dimension) && curves.len() + labels.len() <= CURVES
        };
        let position = panels.iter().position(room).unwrap_or_else(|| {
            panels.push((quantity, dimension, Vec::new()));
            panels.len() - 1
        });
        for label in labels {
            panels[position]
                .2
                .push(curve(label, &|row| row.probes[column]));
            column += 1;
        }
    }
    if panels.is_empty() {
        let energy = curve("strain energy".to_owned(), &|row| row.strain_energy);
        let quantity = ProbeQuantity::strain_energy;
        panels.push((quantity, quantity.dimension(), vec![energy]));
    }
    let parameter = match plan {
        Plan::Dynamic(_) => units.label("time t", [0, 0, 1, 0]),
        _ => format!("{} t", plan.parameter()),
    };
    let panel = |(quantity, dimension, mut curves): (ProbeQuantity, Dimension, Vec<PlotCurve>)| {
        without_noise(&mut curves, scales.size(dimension));
        let (mut x, mut y) = (parameter.clone(), units.label(quantity.name(), dimension));
        // By custom the load of a path, which may turn back, is on the vertical axis.
        if matches!(plan, Plan::Path(..)) {
            std::mem::swap(&mut x, &mut y);
            let points = curves.iter_mut().flat_map(|c| &mut c.points);
            points.for_each(|p| *p = (p.1, p.0));
        }
        Graph::new([x, y], [AxisScale::Linear; 2], curves)
    };
    panels.into_iter().map(panel).collect()
}
