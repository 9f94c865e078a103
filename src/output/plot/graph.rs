//! Graphs side by side on linear or logarithmic axes, with a common legend, and triangles that show orders
//! of convergence.

use super::axes::{self, Area, Axes, LEFT, MARGIN, Mark, legend_height};
use super::scale::AxisScale;
use super::{FINE, INK, PALE, PALETTE, PlotCurve, PlotError, TEXT, figure, font, part};
use plotters::element::PathElement;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, TextStyle};
use std::collections::BTreeMap;

/// Curves over the same axes, marked at their points, or at some of them if there are more curves than colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    /// Descriptions of the horizontal and the vertical axis.
    pub description: [String; 2],
    /// Scales of the axes.
    pub scale: [AxisScale; 2],
    /// The curves. Those of one colour have one entry in the legend and one kind of mark.
    pub curves: Vec<PlotCurve>,
    /// Whether points of all curves are marked; scattered ones always are.
    pub marked: bool,
    /// Slopes shown by triangles under the curves; for logarithmic axes.
    pub slopes: Vec<f64>,
    /// Height of a horizontal dashed line, if there is one.
    pub level: Option<f64>,
}

/// Width and height of a graph.
const SIZE: [i32; 2] = [520, 360];

/// A figure of graphs, two in a row, as SVG text; `level` names the dashed lines in the legend.
///
/// # Errors
/// [`PlotError`] of the drawing library.
pub fn graphs(title: Option<&str>, level: &str, graphs: &[Graph]) -> Result<String, PlotError> {
    let [w, h] = SIZE;
    let columns = graphs.len().clamp(1, 2) as i32;
    let rows = (graphs.len() as i32 + 1) / 2;
    let entries = entries(level, graphs);
    let room = columns * w - LEFT - 2 * MARGIN;
    let words = legend_height(&entries, room);
    let head = if title.is_some() { 34 } else { 6 };
    let size = [columns * w, head + words + rows.max(1) * h];
    figure(title, size, |root| {
        axes::legend(root, [LEFT + MARGIN, head], room, &entries)?;
        for (k, graph) in graphs.iter().enumerate() {
            let k = k as i32;
            let corner = [k % 2 * w, head + words + k / 2 * h];
            draw(&part(root, corner, [w, h]), graph)?;
        }
        Ok(())
    })
}

fn entries(level: &str, graphs: &[Graph]) -> Vec<(String, Mark)> {
    let mut by_color = BTreeMap::new();
    for graph in graphs {
        for (position, curve) in graph.curves.iter().enumerate() {
            let color = curve.color.unwrap_or(position);
            by_color.entry(color).or_insert_with(|| {
                let alike = |c: &PlotCurve| c.scattered && c.color == Some(color);
                let marked = graph.marked || graph.is_crowded() || graph.curves.iter().any(alike);
                let rgb = PALETTE[color % PALETTE.len()];
                let mark = match marked {
                    true => Mark::Marked(rgb, color),
                    false => Mark::Line(rgb, 4),
                };
                (curve.label.clone(), mark)
            });
        }
    }
    let mut out: Vec<_> = by_color.into_values().collect();
    if graphs.iter().any(|g| g.level.is_some()) {
        out.push((level.to_owned(), Mark::Broken(PALE)));
    }
    out
}

impl Graph {
    /// Curves without marks, slopes and level.
    pub fn new(description: [String; 2], scale: [AxisScale; 2], curves: Vec<PlotCurve>) -> Self {
        Self {
            description,
            scale,
            curves,
            marked: false,
            slopes: Vec::new(),
            level: None,
        }
    }

    /// Whether colours repeat, so that lines need marks.
    fn is_crowded(&self) -> bool {
        let mut curves = self.curves.iter().enumerate();
        let again =
            curves.any(|(position, curve)| curve.color.unwrap_or(position) >= PALETTE.len());
        again && self.curves.iter().all(|curve| !curve.scattered)
    }
}

/// Number of marks on a curve with too many points to mark each.
const MARKS: usize = 9;

/// A triangle of a slope: the positions of its three corners, the right angle in the middle.
type Triangle = (f64, [(f64, f64); 3]);

fn draw(area: &Area<'_>, graph: &Graph) -> Result<(), PlotError> {
    let [scale_x, scale_y] = graph.scale;
    let position = |&(x, y): &(f64, f64)| Some((scale_x.position(x)?, scale_y.position(y)?));
    let curves: Vec<Vec<(f64, f64)>> = (graph.curves.iter())
        .map(|c| c.points.iter().filter_map(position).collect())
        .collect();
    let level = graph.level.and_then(|y| scale_y.position(y));
    let mut x = axes::range(curves.iter().flatten().map(|p| p.0));
    if graph.curves.iter().any(|curve| curve.end.is_some()) {
        x[1] += 0.04 * (x[1] - x[0]);
    }
    let mut y = axes::range(curves.iter().flatten().map(|p| p.1).chain(level));
    let triangles = triangles(&graph.slopes, &curves, x, y);
    for (_, corners) in &triangles {
        y[0] = y[0].min(corners[1].1 - 0.09 * (y[1] - y[0]));
    }
    let axes = Axes::new([x, y], SIZE);
    let [across, up] = &graph.description;
    axes.draw(area, graph.scale, [across, up])?;
    if let Some(level) = level {
        let [(from, y), (to, _)] = x.map(|x| axes.at((x, level)));
        broken(area, [from, to], y)?;
    }
    let crowded = graph.is_crowded();
    for (position, (curve, points)) in graph.curves.iter().zip(&curves).enumerate() {
        let color = curve.color.unwrap_or(position);
        let rgb = PALETTE[color % PALETTE.len()];
        let points: Vec<(i32, i32)> = points.iter().map(|&p| axes.at(p)).collect();
        // Marks of neighbouring curves are shifted.
        let apart = match graph.marked || curve.scattered {
            true => 1,
            false => points.len().div_ceil(MARKS).max(1),
        };
        if graph.marked || curve.scattered || crowded {
            let first = color * apart / (MARKS - 2) % apart;
            for &p in points.iter().skip(first).step_by(apart) {
                axes::marker(area, p, rgb, color)?;
            }
        }
        if let (Some(name), Some(&(x, y))) = (&curve.end, points.last()) {
            area.draw_text(name, &beside(), (x + 4 * FINE, y))?;
        }
        if curve.scattered {
            continue;
        }
        let width = if graph.marked { 3 * FINE / 2 } else { 2 * FINE };
        area.draw(&PathElement::new(points, rgb.stroke_width(width as u32)))?;
    }
    for (slope, corners) in triangles {
        triangle(area, slope, corners.map(|corner| axes.at(corner)))?;
    }
    Ok(())
}

/// Text to the right of a point.
fn beside() -> TextStyle<'static> {
    font(TEXT).pos(Pos::new(HPos::Left, VPos::Center))
}

/// A dashed line across the graph.
fn broken(area: &Area<'_>, [from, to]: [i32; 2], y: i32) -> Result<(), PlotError> {
    let style = PALE.stroke_width((3 * FINE / 2) as u32);
    let mut x = from;
    while x < to {
        let end = (x + 7 * FINE).min(to);
        area.draw(&PathElement::new(vec![(x, y), (end, y)], style))?;
        x += 12 * FINE;
    }
    Ok(())
}

/// Triangles under all curves, at the right end, the first slope outermost.
fn triangles(
    slopes: &[f64],
    curves: &[Vec<(f64, f64)>],
    x: [f64; 2],
    y: [f64; 2],
) -> Vec<Triangle> {
    let span = x[1] - x[0];
    // Wide enough to be visible, and not much higher than half of the graph.
    let steepest = slopes.iter().fold(1.0_f64, |m, s| m.max(*s));
    let width = (0.18 * span).min(0.4 * (y[1] - y[0]) / steepest);
    if curves.iter().all(|c| c.len() < 2) || width <= 0.0 {
        return Vec::new();
    }
    let mut right = x[1] - 0.12 * span;
    let mut out = Vec::new();
    for &slope in slopes {
        let left = right - width;
        // The hypotenuse keeps its distance to the lowest point of all curves beside it.
        let heights = |at: f64| curves.iter().filter_map(move |c| height(c, at));
        let lowest = [0.0, 0.25, 0.5, 0.75, 1.0].map(|part| {
            let above = heights(left + part * width).fold(f64::INFINITY, f64::min);
            above - slope * part * width
        });
        let bottom = lowest.into_iter().fold(f64::INFINITY, f64::min) - 0.06 * (y[1] - y[0]);
        if bottom.is_finite() {
            let corners = [
                (left, bottom),
                (right, bottom),
                (right, bottom + slope * width),
            ];
            out.push((slope, corners));
        }
        right = left - 0.1 * span;
    }
    out
}

/// Height of a curve at a position between its ends.
fn height(curve: &[(f64, f64)], x: f64) -> Option<f64> {
    let mut pairs = curve.windows(2);
    pairs.find_map(|p| {
        let [(a, ya), (b, yb)] = [p[0], p[1]];
        let inside = (a.min(b)..=a.max(b)).contains(&x) && a != b;
        inside.then(|| ya + (x - a) / (b - a) * (yb - ya))
    })
}

fn triangle(area: &Area<'_>, slope: f64, corners: [(i32, i32); 3]) -> Result<(), PlotError> {
    let [a, b, c] = corners;
    let style = INK.stroke_width(FINE as u32);
    area.draw(&PathElement::new(vec![a, b, c, a], style))?;
    let below = font(TEXT).pos(Pos::new(HPos::Center, VPos::Top));
    area.draw_text(
        &format!("{slope}"),
        &beside(),
        (b.0 + 4 * FINE, (b.1 + c.1) / 2),
    )?;
    area.draw_text("1", &below, ((a.0 + b.0) / 2, b.1 + 2 * FINE))?;
    Ok(())
}
