//! Curves in panels.

use super::axes::{self, Area, Axes, Mark, legend_height};
use super::{AxisScale, FINE, Graph, PALETTE, PlotError, figure, part};
use plotters::style::{Color, RGBColor};

/// A curve with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotCurve {
    /// Name in the legend.
    pub label: String,
    /// Points, in order.
    pub points: Vec<(f64, f64)>,
    /// Whether only the points are drawn, without lines between them (published values, say).
    pub scattered: bool,
    /// Number of its colour, if curves of a kind share one; its index otherwise.
    pub color: Option<usize>,
    /// Name at its last point.
    pub end: Option<String>,
}

impl PlotCurve {
    /// A line through points.
    pub fn new(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self {
            label: label.into(),
            points,
            scattered: false,
            color: None,
            end: None,
        }
    }

    /// Points without a line.
    pub fn points(label: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self {
            scattered: true,
            ..Self::new(label, points)
        }
    }

    /// The same with a given colour.
    #[must_use]
    pub fn colored(self, color: usize) -> Self {
        Self {
            color: Some(color),
            ..self
        }
    }

    /// The same with a name at its last point.
    #[must_use]
    pub fn ending_as(self, name: String) -> Self {
        Self {
            end: Some(name),
            ..self
        }
    }

    fn drawn_in(&self, position: usize) -> RGBColor {
        PALETTE[self.color.unwrap_or(position) % PALETTE.len()]
    }
}

/// Size of a plot without its legend, alone or beside another.
const ALONE: [i32; 2] = [640, 420];
const BESIDE: [i32; 2] = [520, 360];

/// A figure of graphs with linear axes, two in a row, each with a legend, as SVG text.
pub(crate) fn panels(title: Option<&str>, panels: &[Graph]) -> Result<String, PlotError> {
    let [w, h] = if panels.len() > 1 { BESIDE } else { ALONE };
    let columns = panels.len().clamp(1, 2) as i32;
    let rows = (panels.len() as i32 + 1) / 2;
    let entries: Vec<_> = panels.iter().map(entries).collect();
    let room = w - axes::LEFT - 2 * axes::MARGIN;
    let words = entries.iter().map(|e| legend_height(e, room)).max();
    let words = words.unwrap_or(0);
    let head = if title.is_some() { 34 } else { 0 };
    let size = [columns * w, head + rows.max(1) * (h + words)];
    figure(title, size, |root| {
        for (k, (panel, entries)) in panels.iter().zip(&entries).enumerate() {
            let k = k as i32;
            let [x, y] = [k % 2 * w, head + k / 2 * (h + words)];
            let corner = [x + axes::LEFT + axes::MARGIN, y + 4];
            axes::legend(root, corner, room, entries)?;
            draw(&part(root, [x, y + words], [w, h]), [w, h], panel)?;
        }
        Ok(())
    })
}

fn entries(panel: &Graph) -> Vec<(String, Mark)> {
    let curves = panel.curves.iter().enumerate();
    curves
        .map(|(position, curve)| {
            let color = curve.drawn_in(position);
            let mark = if curve.scattered {
                Mark::Dot(color)
            } else {
                Mark::Line(color, 4)
            };
            (curve.label.clone(), mark)
        })
        .collect()
}

/// Most points of a curve in a figure of this size; more are thinned out.
const POINTS: usize = 4000;

/// The first, the last, the highest and the lowest point of each group of neighbours: the envelope of a curve
/// with many points.
fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if points.len() <= POINTS {
        return points;
    }
    let group = 4 * points.len().div_ceil(POINTS);
    let mut out = Vec::with_capacity(POINTS + 4);
    for part in points.chunks(group) {
        let extreme = |sign: f64| {
            let best = part.iter().enumerate();
            best.max_by(|a, b| (sign * a.1.1).total_cmp(&(sign * b.1.1)))
                .map_or(0, |(i, _)| i)
        };
        let mut kept = vec![0, extreme(1.0), extreme(-1.0), part.len() - 1];
        kept.sort_unstable();
        kept.dedup();
        out.extend(kept.into_iter().map(|i| part[i]));
    }
    out
}

fn draw(area: &Area<'_>, size: [i32; 2], panel: &Graph) -> Result<(), PlotError> {
    let all = || panel.curves.iter().flat_map(|c| &c.points);
    let x = axes::range(all().map(|p| p.0));
    let y = axes::range(all().map(|p| p.1));
    let axes = Axes::new([x, y], size);
    let [across, up] = &panel.description;
    axes.draw(area, [AxisScale::Linear; 2], [across, up])?;
    for (position, curve) in panel.curves.iter().enumerate() {
        let color = curve.drawn_in(position);
        let finite = |p: &&(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let points: Vec<(f64, f64)> = curve.points.iter().filter(finite).copied().collect();
        let points = match curve.scattered {
            true => points,
            false => thinned(points),
        };
        // Converged steps are marked if there are few.
        if curve.scattered || points.len() <= 40 {
            for &point in &points {
                area.draw(&axes.dot(point, 3 * FINE, color))?;
            }
        }
        if !curve.scattered {
            area.draw(&axes.line(points, color.stroke_width(2 * FINE as u32)))?;
        }
    }
    Ok(())
}
