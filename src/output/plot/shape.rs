//! The shape of a structure: reference and deformed, with equal scales on all axes.

use super::axes::{self, Area, Axes, Mark, legend_height, span};
use super::scale::tick;
use super::{AxisScale, FINE, INK, PALE, PALETTE, PlotError, TEXT, figure, font, part};
use crate::input::{Geometry, Units, lagrange};
use nalgebra::{Matrix3, Vector3};
use plotters::element::{PathElement, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor};
use pullback_elements::model::Context;
use serde::{Deserialize, Serialize};

/// Colour of intermediate shapes.
const PALE_BLUE: RGBColor = RGBColor(158, 202, 225);
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
pub(crate) struct Shapes {
    /// Points along each line.
    pub(super) lines: Vec<Vec<Vector3<f64>>>,
    /// Positions of the nodes.
    nodes: Vec<Vector3<f64>>,
    /// Positions of supported nodes.
    pub(super) supports: Vec<Vector3<f64>>,
    /// Centres of mass of bodies.
    pub(super) bodies: Vec<Vector3<f64>>,
    /// Axes of bodies, as columns.
    pub(super) axes: Vec<Matrix3<f64>>,
    /// Rigid links, also from a node to the centre of mass of its body.
    pub(super) links: Vec<[Vector3<f64>; 2]>,
}

impl Shapes {
    /// The present configuration of a model, with displacements times `scale`; 0 gives the reference configuration.
    pub fn of(context: &Context, geometry: &Geometry, scale: f64) -> Self {
        let between = |reference: Vector3<f64>, position: Vector3<f64>| match scale {
            0.0 => reference,
            1.0 => position,
            _ => reference + (position - reference) * scale,
        };
        let position = |node| {
            between(
                context.node(node).position(),
                context.node_state(node).position,
            )
        };
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
                context.node(body.node).position() + body.center,
                state.position + state.R * body.center,
            );
            out.bodies.push(center);
            out.axes.push(match scale {
                0.0 => Matrix3::identity(),
                _ => state.R,
            });
            out.links.push([position(body.node), center]);
        }
        out
    }

    /// The largest displacement of a point from another configuration of the same model.
    pub fn distance(&self, other: &Self) -> f64 {
        let pairs = self.points().zip(other.points());
        pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
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
            let weighted = own.iter().zip(lagrange(order, u));
            out.push(weighted.map(|(x, weight)| x * weight).sum());
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

fn extent([low, high]: [f64; 2]) -> f64 {
    high - low
}

/// A view with the corner and the size of its plot in the figure, in units.
type Plot = (View, [i32; 2], [i32; 2]);

/// Width and height of the margins of a plot, with tick labels and descriptions.
const EDGE: [i32; 2] = [
    axes::LEFT + 2 * axes::MARGIN,
    axes::BOTTOM + 2 * axes::MARGIN,
];

/// The plots of a structure with these extents: one of a plane structure; of any other the front (x, z) and the
/// side (y, z), with the plan (x, y) and an isometric view below.
fn plots(extents: [f64; 3]) -> Vec<Plot> {
    let largest = extents.iter().fold(0.0_f64, |a, &b| a.max(b));
    // The axis across the plane: the flattest.
    let flatter = |best, k| if extents[k] <= extents[best] { k } else { best };
    let across = (0..3).fold(0, flatter);
    if extents[across] <= FLAT * largest {
        let (a, b) = ([1, 0, 0][across], [2, 2, 1][across]);
        let width = f64::from(640 - EDGE[0]);
        let height = width * extents[b] / extents[a].max(1e-300);
        let height = height.clamp(140.0, 560.0) as i32;
        return vec![(View::Plane(a, b), [0, 0], [640, height + EDGE[1]])];
    }
    let [ex, ey, ez] = extents.map(|e| e.max(0.35 * largest));
    let unit = 680.0 / (ex + ey);
    let [w1, w2] = [ex, ey].map(|e| (e * unit) as i32 + EDGE[0]);
    let [h1, h2] = [ez, ey].map(|e| (e * unit) as i32 + EDGE[1]);
    vec![
        (View::Plane(0, 2), [0, 0], [w1, h1]),
        (View::Plane(1, 2), [w1, 0], [w2, h1]),
        (View::Plane(0, 1), [0, h1], [w1, h2]),
        (View::Isometric, [w1, h1], [w2, h2]),
    ]
}

/// A figure of the reference, intermediate and last shapes, as SVG text; `names` are those of the first and the
/// last one in the legend.
pub(crate) fn deformed(
    title: Option<&str>,
    units: &Units,
    reference: &Shapes,
    shapes: &[(f64, Shapes)],
    names: Option<[&str; 2]>,
) -> Result<String, PlotError> {
    let chosen = between(shapes.len()).chain(shapes.len().checked_sub(1));
    let drawn = std::iter::once(reference).chain(chosen.map(|k| &shapes[k].1));
    let points: Vec<Vector3<f64>> = drawn
        .flat_map(Shapes::points)
        .filter(|p| p.iter().all(|x| x.is_finite()))
        .copied()
        .collect();
    let entries = entries(reference, shapes, names);
    let names = AXES.map(|name| units.label(name, [0, 1, 0, 0]));
    let plots = plots([0, 1, 2].map(|k| extent(View::Plane(k, k).range(&points)[0])));
    let [width, height] = [0, 1].map(|k| {
        let ends = plots.iter().map(|(_, corner, size)| corner[k] + size[k]);
        ends.max().unwrap_or(0)
    });
    let head = if title.is_some() { 34 } else { 0 };
    let top = head + legend_height(&entries, width - EDGE[0]);
    // The plane views share one scale; the isometric one has its own.
    let scale = |&(view, _, [w, h]): &Plot| {
        let [x, y] = view.range(&points).map(extent);
        (x / f64::from(w - EDGE[0])).max(y / f64::from(h - EDGE[1]))
    };
    let plane = |plot: &&Plot| matches!(plot.0, View::Plane(..));
    let common = plots.iter().filter(plane).map(scale).fold(0.0, f64::max);
    figure(title, [width, top + height], |root| {
        let corner = [axes::LEFT + axes::MARGIN, head + 2];
        axes::legend(root, corner, width - EDGE[0], &entries)?;
        for plot in &plots {
            let &(view, [x, y], [w, h]) = plot;
            let scale = if plane(&plot) { common } else { scale(plot) };
            let scale = match scale > 0.0 && scale.is_finite() {
                true => 1.1 * scale,
                false => 1.0,
            };
            let (range, room) = (view.range(&points), [w - EDGE[0], h - EDGE[1]]);
            let range = [0, 1].map(|k| centred(range[k], scale, room[k]));
            let area = part(root, [x, top + y], [w, h]);
            draw(
                (&area, view, &Axes::new(range, [w, h])),
                &names,
                reference,
                shapes,
            )?;
        }
        Ok(())
    })
}

/// Indices of the shapes between the reference and the last, evenly over the load path.
fn between(count: usize) -> impl Iterator<Item = usize> {
    let wanted = BETWEEN.min(count.saturating_sub(2));
    (1..=wanted).map(move |k| k * (count - 1) / (wanted + 1))
}

fn entries(
    reference: &Shapes,
    shapes: &[(f64, Shapes)],
    names: Option<[&str; 2]>,
) -> Vec<(String, Mark)> {
    let first = names.map_or("reference", |names| names[0]);
    let mut out = vec![(first.to_owned(), Mark::Line(PALE, 3))];
    if between(shapes.len()).next().is_some() {
        out.push(("intermediate states".to_owned(), Mark::Line(PALE_BLUE, 2)));
    }
    if let Some((t, _)) = shapes.last() {
        let deformed = || format!("deformed, t = {}", tick(*t, 0.1));
        let label = names.map_or_else(deformed, |names| names[1].to_owned());
        out.push((label, Mark::Line(PALETTE[0], 5)));
    }
    if !reference.bodies.is_empty() {
        out.push(("centre of mass".to_owned(), Mark::Dot(PALETTE[1])));
    }
    if !reference.supports.is_empty() {
        out.push(("support".to_owned(), Mark::Square(INK)));
    }
    out
}

/// The range of a plot of a size and scale around the middle of another range.
fn centred([low, high]: [f64; 2], scale: f64, size: i32) -> [f64; 2] {
    let (middle, half) = (0.5 * (low + high), 0.5 * scale * f64::from(size));
    let middle = if middle.is_finite() { middle } else { 0.0 };
    [middle - half, middle + half]
}

/// One view.
fn draw(
    (area, view, axes): (&Area<'_>, View, &Axes),
    names: &[String; 3],
    reference: &Shapes,
    shapes: &[(f64, Shapes)],
) -> Result<(), PlotError> {
    match view {
        View::Plane(a, b) => axes.draw(area, [AxisScale::Linear; 2], [&names[a], &names[b]])?,
        View::Isometric => triad(area, view)?,
    }
    let outline = |shapes: &Shapes, color: RGBColor, stroke: i32| {
        let style = color.stroke_width((stroke * FINE / 2) as u32);
        for line in &shapes.lines {
            area.draw(&axes.line(line.iter().map(|p| view.project(p)), style))?;
        }
        let thin = color.stroke_width((stroke * FINE / 4).max(1) as u32);
        for link in &shapes.links {
            area.draw(&axes.line(link.iter().map(|p| view.project(p)), thin))?;
        }
        Ok::<_, PlotError>(())
    };
    outline(reference, PALE, 3)?;
    for k in between(shapes.len()) {
        outline(&shapes[k].1, PALE_BLUE, 2)?;
    }
    if let Some((_, last)) = shapes.last() {
        outline(last, PALETTE[0], 5)?;
        for node in last.nodes.iter().filter(|_| last.nodes.len() <= MARKED) {
            area.draw(&axes.dot(view.project(node), 5 * FINE / 2, PALETTE[0]))?;
        }
        for body in &last.bodies {
            area.draw(&axes.dot(view.project(body), 4 * FINE, PALETTE[1]))?;
        }
    }
    for support in &reference.supports {
        let (x, y) = axes.at(view.project(support));
        let half = 4 * FINE;
        let corners = [(x - half, y - half), (x + half, y + half)];
        area.draw(&Rectangle::new(corners, INK.filled()))?;
    }
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
