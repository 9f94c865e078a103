//! Modes over the speed of a rotation: a table, JSON, and the Campbell diagram.

use super::Recorder;
use super::modes::parts;
use crate::input::Units;
use crate::modes::ModelCampbell;
use crate::output::directory::{OutputError, drawing};
use crate::output::plot::{AxisScale, Graph, PlotCurve, graphs};
use pullback_integrators::linearization::{CampbellDiagram, Mode};
use serde_json::json;
use std::f64::consts::TAU;

/// Colours of the modes; the next one is that of the multiples of the speed.
const COLORS: usize = 6;
/// Multiples of the speed that are drawn.
const MULTIPLES: usize = 6;

impl Recorder<'_> {
    /// Writes modes over the speed.
    pub(super) fn write_campbell(&mut self, found: &ModelCampbell) -> Result<(), OutputError> {
        let diagram = &found.diagram;
        let mut csv = "speed".to_owned();
        for k in 1..=diagram.lines.len() {
            csv += &format!(",frequency_{k},damping_ratio_{k}");
        }
        for (row, speed) in diagram.speeds.iter().enumerate() {
            csv += &format!("\n{speed:?}");
            for line in &diagram.lines {
                csv += &match &line[row] {
                    Some(mode) => format!(",{:?},{:?}", mode.frequency(), mode.damping_ratio()),
                    None => ",,".to_owned(),
                };
            }
        }
        csv.push('\n');
        self.directory.write("campbell.csv", &csv)?;
        let entry = |mode: &Option<Mode>| {
            mode.as_ref().map(|mode| {
                json!({
                    "eigenvalue": [mode.eigenvalue.re, mode.eigenvalue.im],
                    "residual": mode.residual,
                    "shape": parts(&mode.shape),
                })
            })
        };
        let lines = diagram.lines.iter();
        let all = json!({
            "speeds": diagram.speeds,
            "multi_blade": diagram.multi_blade,
            "coordinates": found.last.names,
            "lines": lines.map(|line| line.iter().map(entry).collect::<Vec<_>>()).collect::<Vec<_>>(),
        });
        self.directory.write_json("campbell.json", &all)?;
        if !self.setting.file.output.figures.is_none() && diagram.speeds.len() > 1 {
            let title = self.setting.file.title.as_deref();
            let figure = graphs(title, "", &[graph(diagram, &self.setting.file.units)]);
            self.write_figure("campbell", &figure.map_err(drawing("campbell.svg"))?)?;
        }
        Ok(())
    }
}

/// Frequencies over the speed, with the lines nΩ.
fn graph(diagram: &CampbellDiagram, units: &Units) -> Graph {
    let (mut curves, mut highest) = (Vec::new(), 0.0_f64);
    for (k, line) in diagram.lines.iter().enumerate() {
        let modes = diagram.speeds.iter().zip(line);
        let points: Vec<(f64, f64)> = modes
            .filter_map(|(speed, mode)| Some((speed / TAU, mode.as_ref()?.frequency())))
            .collect();
        highest = points.iter().fold(highest, |most, point| most.max(point.1));
        let color = k % COLORS;
        curves.push(PlotCurve::new(label(color, diagram.lines.len()), points).colored(color));
    }
    let ends = [diagram.speeds.first(), diagram.speeds.last()];
    if let [Some(from), Some(to)] = ends.map(|speed| speed.map(|x| x / TAU)) {
        for n in 1..=MULTIPLES {
            // Up to the highest frequency.
            let n = n as f64;
            let limit = |x: f64| x.clamp(-highest / n, highest / n);
            let points = [limit(from), limit(to)].map(|x| (x, n * x.abs()));
            let line = PlotCurve::new("multiples of the speed", points.to_vec()).colored(COLORS);
            curves.push(line.ending_as(format!("{n}Ω")));
        }
    }
    let time = units.time.as_deref().unwrap_or("unit of time");
    let description = [
        format!("speed, turns per {time}"),
        units.label("frequency", [0, 0, -1, 0]),
    ];
    Graph::new(description, [AxisScale::Linear; 2], curves)
}

/// The numbers of the lines of a colour.
fn label(color: usize, count: usize) -> String {
    let numbers = (color..count).step_by(COLORS).map(|k| (k + 1).to_string());
    format!("mode {}", numbers.collect::<Vec<_>>().join(", "))
}
