//! The shape of a structure: reference and deformed, with equal scales on all axes.

use super::axes::{self, Area, Mark, PlotArea, legend_height, legend_rows};
use super::{FINE, INK, PALE, PALETTE, PlotError, TEXT, figure, font, part};
use crate::input::Geometry;
use nalgebra::Vector3;
use plotters::chart::ChartBuilder;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor};
use pullback_elements::model::Context;
use serde::{Deserialize, Serialize};

/// Points per element of higher order.
const PIECES: usize = 8;
/// Most intermediate shapes drawn.
const BETWEEN: usize = 4;
/// Nodes are marked if there are at most so many.
const MARKED: usize = 41;
/// A structure is plane if its extent across is at most this fraction of the largest.
const FLAT: f64 = 1e-3;

/// Lines of a structure in one configuration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shapes {
    /// Points along each line.
    lines: Vec<Vec<Vector3<f64>>>,
    /// Positions of the nodes.
    nodes: Vec<Vector3<f64>>,
    /// Positions of supported nodes.
    supports: Vec<Vector3<f64>>,
    /// Centres of mass of bodies.
    bodies: Vec<Vector3<f64>>,
    /// Rigid links, also from a node to the centre of mass of its body.
    links: Vec<[Vector3<f64>; 2]>,
}

impl Shapes {
    /// The present configuration of a model, with displacements times `scale`; 0 gives the reference configuration.
    pub fn of(context: &Context, geometry: &Geometry, scale: f64) -> Self {
        let between = |reference: Vector3<f64>, position: Vector3<f64>| match scale {
            0.0 => reference,
            1.0 => position,
            _ => reference + (position - reference) * scale,
        };
        let position = |node| between(context.reference(node), context.node_state(node).position);
        let mut out = Self {
            supports: geometry.supports.iter().map(|&n| position(n)).collect(),
            ..Self::default()
        };
        for line in &geometry.lines {
            let nodes: Vec<Vector3<f64>> = line.nodes.iter().map(|&n| position(n)).collect();
            out.lines.push(interpolate(&nodes, line.order));
            out.nodes.extend(nodes);
        }
        for link in &geometry.links {
            out.links.push(link.map(position));
        }
        for body in &geometry.bodies {
            let state = context.node_state(body.node);
            let center = between(
                context.reference(body.node) + body.center,
                state.position + state.R * body.center,
            );
            out.bodies.push(center);
            out.links.push([position(body.node), center]);
        }
        out
    }

    /// The largest extent along an axis.
    pub fn extent(&self) -> f64 {
        let along = |k: usize| {
            let [low, high] = span(self.points().map(|p| p[k]));
            (high - low).max(0.0)
        };
        (0..3).map(along).fold(0.0, f64::max)
    }

    fn points(&self) -> impl Iterator<Item = &Vector3<f64>> {
        let links = self.links.iter().flatten();
        (self.lines.iter().flatten().chain(links)).chain(&self.supports)
    }
}

/// Points along a line of elements: its nodes, and between them the interpolation of the order.
fn interpolate(nodes: &[Vector3<f64>], order: usize) -> Vec<Vector3<f64>> {
    if order == 1 {
        return nodes.to_vec();
    }
    let mut out: Vec<Vector3<f64>> = nodes.first().copied().into_iter().collect();
    for start in (0..nodes.len().saturating_sub(order)).step_by(order) {
        let own = &nodes[start..=start + order];
        for piece in 1..=PIECES {
            let u = (order * piece) as f64 / PIECES as f64;
            let weight = |i: usize| -> f64 {
                let others = (0..=order).filter(|&j| j != i);
                others
                    .map(|j| (u - j as f64) / (i as f64 - j as f64))
                    .product()
            };
            out.push(own.iter().enumerate().map(|(i, x)| x * weight(i)).sum());
        }
    }
    out
}

/// A projection on a plane of the page.
#[derive(Clone, Copy)]
enum View {
    /// Coordinates a (to the right) and b (upwards).
    Plane(usize, usize),
    /// From the direction (1, −1, 1)/√3 with e3 upwards.
    Isometric,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl View {
    fn project(self, p: &Vector3<f64>) -> (f64, f64) {
        match self {
            Self::Plane(a, b) => (p[a], p[b]),
            Self::Isometric => (
                (p.x + p.y) / 2.0_f64.sqrt(),
                (2.0 * p.z - p.x + p.y) / 6.0_f64.sqrt(),
            ),
        }
    }

    fn range(self, points: &[Vector3<f64>]) -> [[f64; 2]; 2] {
        let of = |pick: fn((f64, f64)) -> f64| span(points.iter().map(|p| pick(self.project(p))));
        [of(|p| p.0), of(|p| p.1)]
    }
}

/// The least and the largest of some values.
fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}

fn extent([low, high]: [f64; 2]) -> f64 {
    high - low
}

/// A figure of the reference, intermediate and last shapes, as SVG text: one view of a
/// plane structure, three views and an isometric one of any other.
///
/// # Errors
/// [`PlotError`] of the drawing library.
pub fn deformed(
    title: Option<&str>,
    reference: &Shapes,
    shapes: &[(f64, Shapes)],
) -> Result<String, PlotError> {
    let chosen = between(shapes.len()).chain(shapes.len().checked_sub(1));
    let drawn = std::iter::once(reference).chain(chosen.map(|k| &shapes[k].1));
    let points: Vec<Vector3<f64>> = drawn
        .flat_map(Shapes::points)
        .filter(|p| p.iter().all(|x| x.is_finite()))
        .copied()
        .collect();
    let extents = [0, 1, 2].map(|k| extent(View::Plane(k, k).range(&points)[0]));
    let largest = extents.iter().fold(0.0_f64, |a, &b| a.max(b));
    // The axis across the plane: the flattest.
    let across = (0..3).fold(
        0,
        |best, k| if extents[k] <= extents[best] { k } else { best },
    );
    let flat = extents[across] <= FLAT * largest;
    let entries = entries(reference, shapes);
    let head = if title.is_some() { 34 } else { 0 };
    let fit = |room: f64, a: f64, b: f64, [low, high]: [f64; 2]| {
        (room * b / a.max(1e-300)).clamp(low, high) as i32
    };
    let edge = [
        axes::LEFT + 2 * axes::MARGIN,
        axes::BOTTOM + 2 * axes::MARGIN,
    ];
    // Views with the position and size of their plots, in units.
    let mut views = Vec::new();
    let size = if flat {
        let (a, b) = ([1, 0, 0][across], [2, 2, 1][across]);
        let w = 640;
        let h = fit(
            f64::from(w - edge[0]),
            extents[a],
            extents[b],
            [140.0, 560.0],
        ) + edge[1];
        let words = legend_height(legend_rows(&entries, w - edge[0]));
        views.push((View::Plane(a, b), [0, head + words], [w, h]));
        [w, head + words + h]
    } else {
        // Front (x, z) and side (y, z) above, plan (x, y) and the isometric view below.
        let [ex, ey, ez] = extents.map(|e| e.max(0.35 * largest));
        let unit = 680.0 / (ex + ey);
        let [w1, w2] = [ex, ey].map(|e| (e * unit) as i32 + edge[0]);
        let [h1, h2] = [ez, ey].map(|e| (e * unit) as i32 + edge[1]);
        let words = legend_height(legend_rows(&entries, w1 + w2 - edge[0]));
        let top = head + words;
        views.push((View::Plane(0, 2), [0, top], [w1, h1]));
        views.push((View::Plane(1, 2), [w1, top], [w2, h1]));
        views.push((View::Plane(0, 1), [0, top + h1], [w1, h2]));
        views.push((View::Isometric, [w1, top + h1], [w2, h2]));
        [w1 + w2, top + h1 + h2]
    };
    // The plane views share one scale; the isometric one has its own.
    let scale = |view: View, [w, h]: [i32; 2]| {
        let [x, y] = view.range(&points).map(extent);
        (x / f64::from(w - edge[0])).max(y / f64::from(h - edge[1]))
    };
    let common = |v: &(View, [i32; 2], [i32; 2])| match v.0 {
        View::Plane(..) => scale(v.0, v.2),
        View::Isometric => 0.0,
    };
    let common = views.iter().map(common).fold(0.0, f64::max);
    figure(title, size, |root| {
        let corner = [axes::LEFT + axes::MARGIN, head + 2];
        axes::legend(root, corner, size[0] - edge[0], &entries)?;
        for (view, [x, y], [w, h]) in views {
            let area = part(root, [x, y], [w, h]);
            let own = match view {
                View::Plane(..) => common,
                View::Isometric => scale(view, [w, h]),
            };
            let own = if own > 0.0 && own.is_finite() {
                1.1 * own
            } else {
                1.0
            };
            let plot = [w - edge[0], h - edge[1]];
            let [x, y] = [0, 1].map(|k| centred(view.range(&points)[k], own, plot[k]));
            draw(&area, view, [x, y], own, reference, shapes)?;
        }
        Ok(())
    })
}

/// Indices of the shapes between the reference and the last, evenly over the load path.
fn between(count: usize) -> impl Iterator<Item = usize> {
    let wanted = BETWEEN.min(count.saturating_sub(2));
    (1..=wanted).map(move |k| k * (count - 1) / (wanted + 1))
}

fn entries(reference: &Shapes, shapes: &[(f64, Shapes)]) -> Vec<(String, Mark)> {
    let mut out = vec![("reference".to_owned(), Mark::Line(PALE, 3))];
    if between(shapes.len()).next().is_some() {
        out.push(("intermediate states".to_owned(), Mark::Line(pale_blue(), 2)));
    }
    if let Some((t, _)) = shapes.last() {
        let t = axes::tick(*t, 0.1);
        out.push((format!("deformed, t = {t}"), Mark::Line(PALETTE[0], 5)));
    }
    if !reference.bodies.is_empty() {
        out.push(("centre of mass".to_owned(), Mark::Dot(PALETTE[1])));
    }
    if !reference.supports.is_empty() {
        out.push(("support".to_owned(), Mark::Square(INK)));
    }
    out
}

fn pale_blue() -> RGBColor {
    RGBColor(158, 202, 225)
}

/// The range of a plot of a size and scale around the middle of another range.
fn centred([low, high]: [f64; 2], scale: f64, size: i32) -> [f64; 2] {
    let (middle, half) = (0.5 * (low + high), 0.5 * scale * f64::from(size));
    let middle = if middle.is_finite() { middle } else { 0.0 };
    [middle - half, middle + half]
}

/// One view, with the same scale (units of the model per unit of the figure) along both axes.
fn draw(
    area: &Area<'_>,
    view: View,
    [x, y]: [[f64; 2]; 2],
    scale: f64,
    reference: &Shapes,
    shapes: &[(f64, Shapes)],
) -> Result<(), PlotError> {
    let mut chart = match view {
        View::Plane(a, b) => axes::axes(area, x, y, [AXES[a], AXES[b]])?,
        View::Isometric => {
            let chart = ChartBuilder::on(area)
                .margin(axes::MARGIN * FINE)
                .x_label_area_size(axes::BOTTOM * FINE)
                .y_label_area_size(axes::LEFT * FINE)
                .build_cartesian_2d(x[0]..x[1], y[0]..y[1])?;
            triad(area, view)?;
            chart
        }
    };
    outline(&mut chart, view, reference, PALE, 3)?;
    for k in between(shapes.len()) {
        outline(&mut chart, view, &shapes[k].1, pale_blue(), 2)?;
    }
    if let Some((_, last)) = shapes.last() {
        outline(&mut chart, view, last, PALETTE[0], 5)?;
        if last.nodes.len() <= MARKED {
            let positions = last.nodes.iter().map(|p| view.project(p));
            let dots = positions.map(|p| Circle::new(p, 5 * FINE / 2, PALETTE[0].filled()));
            chart.draw_series(dots)?;
        }
        let positions = last.bodies.iter().map(|p| view.project(p));
        let dots = positions.map(|p| Circle::new(p, 4 * FINE, PALETTE[1].filled()));
        chart.draw_series(dots)?;
    }
    let half = 4.0 * scale;
    let squares = reference.supports.iter().map(|p| {
        let (x, y) = view.project(p);
        Rectangle::new([(x - half, y - half), (x + half, y + half)], INK.filled())
    });
    chart.draw_series(squares)?;
    Ok(())
}

fn outline(
    chart: &mut PlotArea<'_, '_>,
    view: View,
    shapes: &Shapes,
    color: RGBColor,
    stroke: i32,
) -> Result<(), PlotError> {
    let style = color.stroke_width((stroke * FINE / 2) as u32);
    let lines = shapes.lines.iter().map(|line| {
        let positions = line.iter().map(|p| view.project(p));
        PathElement::new(positions.collect::<Vec<_>>(), style)
    });
    chart.draw_series(lines)?;
    let thin = color.stroke_width((stroke * FINE / 4).max(1) as u32);
    let links = shapes.links.iter().map(|link| {
        let positions = link.iter().map(|p| view.project(p));
        PathElement::new(positions.collect::<Vec<_>>(), thin)
    });
    chart.draw_series(links)?;
    Ok(())
}

/// The three axes' directions at the lower left of a view without axes of its own.
fn triad(area: &Area<'_>, view: View) -> Result<(), PlotError> {
    let (_, height) = area.dim_in_pixel();
    let origin = (26 * FINE, height as i32 - 60 * FINE);
    let style = font(TEXT).pos(Pos::new(HPos::Center, VPos::Center));
    let length = f64::from(44 * FINE);
    for (k, name) in AXES.into_iter().enumerate() {
        let (x, y) = view.project(&Vector3::ith(k, length));
        let at = |part: f64| (origin.0 + (part * x) as i32, origin.1 - (part * y) as i32);
        let arrow = vec![origin, at(1.0)];
        area.draw(&PathElement::new(arrow, INK.stroke_width(FINE as u32)))?;
        area.draw_text(name, &style, at(1.25))?;
    }
    Ok(())
}
