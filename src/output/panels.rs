//! What the figure of the history shows.

use super::history::Row;
use super::plot::{Curve, Panel};
use crate::input::{Plan, Quantity};
use crate::probe::Probe;

/// One panel per quantity, in the order of the probes; the strain energy where there are none.
pub(super) fn panels(plan: &Plan, probes: &[Probe], rows: &[Row]) -> Vec<Panel> {
    // A path turns back in the load: its custom is to have the load upright.
    let upright = matches!(plan, Plan::Path(..));
    let mut panels: Vec<(Quantity, Vec<Curve>)> = Vec::new();
    let mut column = 0;
    for probe in probes {
        for label in probe.columns() {
            let points = rows.iter().map(|row| {
                let value = row.probes[column];
                if upright {
                    (value, row.t)
                } else {
                    (row.t, value)
                }
            });
            let curve = Curve::new(label, points.collect());
            let quantity = probe.quantity();
            match panels.iter_mut().find(|(q, _)| *q == quantity) {
                Some((_, curves)) => curves.push(curve),
                None => panels.push((quantity, vec![curve])),
            }
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
