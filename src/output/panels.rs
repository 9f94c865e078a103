//! What the figure of the history shows.

use super::history::Row;
use super::plot::{Curve, Panel};
use crate::input::{Plan, Quantity};
use crate::probe::Probe;

/// Curves in a panel that a reader can tell apart.
const CURVES: usize = 6;

/// One panel per quantity (more where there are many curves), in the order of the probes; the strain energy where there are none.
pub(super) fn panels(plan: &Plan, probes: &[Probe], rows: &[Row]) -> Vec<Panel> {
    // A path turns back in the load: its custom is to have the load upright.
    let upright = matches!(plan, Plan::Path(..));
    let mut panels: Vec<(Quantity, Vec<Curve>)> = Vec::new();
    let mut column = 0;
    for probe in probes {
        let (quantity, labels) = (probe.quantity(), probe.columns());
        let room = |(q, curves): &(Quantity, Vec<Curve>)| {
            *q == quantity && curves.len() + labels.len() <= CURVES
        };
        let place = panels.iter().position(room).unwrap_or_else(|| {
            panels.push((quantity, Vec::new()));
            panels.len() - 1
        });
        for label in labels {
            let points = rows.iter().map(|row| {
                let value = row.probes[column];
                if upright {
                    (value, row.t)
                } else {
                    (row.t, value)
                }
            });
            panels[place].1.push(Curve::new(label, points.collect()));
            column += 1;
        }
    }
    if panels.is_empty() {
        let points = rows.iter().map(|row| {
            if upright {
                (row.strain_energy, row.t)
            } else {
                (row.t, row.strain_energy)
            }
        });
        let curve = Curve::new("strain energy", points.collect());
        panels.push((Quantity::strain_energy, vec![curve]));
    }
    panels
        .into_iter()
        .map(|(quantity, curves)| {
            let parameter = format!("{} t", plan.parameter());
            let (load, value) = (parameter, quantity.axis().to_owned());
            let (x, y) = if upright {
                (value, load)
            } else {
                (load, value)
            };
            Panel { x, y, curves }
        })
        .collect()
}
