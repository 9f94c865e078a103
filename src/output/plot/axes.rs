//! Axes, tick labels and legends of all figures.

use super::scale::AxisScale;
use super::{FINE, GRID, INK, PALETTE, PlotError, TEXT, font, width};
use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::prelude::{DrawingArea, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, RGBColor, ShapeStyle};

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Margins for tick labels and descriptions at the left and at the bottom, and around a plot.
pub(super) const LEFT: i32 = 80;
pub(super) const BOTTOM: i32 = 44;
pub(super) const MARGIN: i32 = 14;

/// Axes of a plot: a map from positions to the fine pixels of an area.
pub(super) struct Axes {
    /// Ranges of positions.
    range: [[f64; 2]; 2],
    /// Pixels of their ends.
    pixels: [[i32; 2]; 2],
}

impl Axes {
    /// Axes for an area of a size (in units), with room for tick labels and descriptions.
    pub fn new(range: [[f64; 2]; 2], [w, h]: [i32; 2]) -> Self {
        let across = [LEFT + MARGIN, w - MARGIN];
        let up = [h - BOTTOM - MARGIN, MARGIN];
        let pixels = [across, up].map(|ends| ends.map(|end| end * FINE));
        Self { range, pixels }
    }

    /// The pixel at a position.
    pub fn at(&self, (x, y): (f64, f64)) -> (i32, i32) {
        let along = |k: usize, v: f64| {
            let ([a, b], [from, to]) = (self.range[k], self.pixels[k]);
            from + ((v - a) / (b - a) * f64::from(to - from)).round() as i32
        };
        (along(0, x), along(1, y))
    }

    /// A line through positions.
    pub fn line(
        &self,
        points: impl IntoIterator<Item = (f64, f64)>,
        style: ShapeStyle,
    ) -> PathElement<(i32, i32)> {
        PathElement::new(
            points.into_iter().map(|p| self.at(p)).collect::<Vec<_>>(),
            style,
        )
    }

    /// A dot at a position, with a radius in fine pixels.
    pub fn dot(&self, point: (f64, f64), radius: i32, color: RGBColor) -> Circle<(i32, i32), i32> {
        Circle::new(self.at(point), radius, color.filled())
    }

    /// Draws a frame with ticks, light grid lines and descriptions.
    pub fn draw(
        &self,
        area: &Area<'_>,
        scale: [AxisScale; 2],
        [across, up]: [&str; 2],
    ) -> Result<(), PlotError> {
        let [[left, right], [bottom, top]] = self.pixels;
        let line = |from, to, color: RGBColor| {
            let style = color.stroke_width(FINE as u32);
            area.draw(&PathElement::new(vec![from, to], style))
        };
        // Numbers of labels for which there is room.
        let most = |length: i32, room: i32| (length / (room * FINE)).clamp(2, 7) as usize;
        let ticks = [
            scale[0].ticks(self.range[0], most(right - left, 68)),
            scale[1].ticks(self.range[1], most(bottom - top, 41)),
        ];
        let mark = |label: &Option<String>| FINE * if label.is_some() { 5 } else { 3 };
        let below = font(TEXT).pos(Pos::new(HPos::Center, VPos::Top));
        let beside = font(TEXT).pos(Pos::new(HPos::Right, VPos::Center));
        let origin = (self.range[0][0], self.range[1][0]);
        for (position, label) in &ticks[0] {
            let (x, _) = self.at((*position, origin.1));
            let end = bottom + mark(label);
            if let Some(label) = label {
                line((x, bottom), (x, top), GRID)?;
                area.draw_text(label, &below, (x, end + 2 * FINE))?;
            }
            line((x, bottom), (x, end), INK)?;
        }
        for (position, label) in &ticks[1] {
            let (_, y) = self.at((origin.0, *position));
            let end = left - mark(label);
            if let Some(label) = label {
                line((left, y), (right, y), GRID)?;
                area.draw_text(label, &beside, (end - 2 * FINE, y))?;
            }
            line((end, y), (left, y), INK)?;
        }
        let frame = [
            (left, bottom),
            (right, bottom),
            (right, top),
            (left, top),
            (left, bottom),
        ];
        let ink = INK.stroke_width(FINE as u32);
        area.draw(&PathElement::new(frame.to_vec(), ink))?;
        let under = bottom + 30 * FINE;
        area.draw_text(across, &below, ((left + right) / 2, under))?;
        let upward = font(TEXT)
            .transform(FontTransform::Rotate270)
            .pos(Pos::new(HPos::Center, VPos::Top));
        area.draw_text(up, &upward, (14 * FINE, (top + bottom) / 2))?;
        Ok(())
    }
}

/// The symbol of a legend entry.
#[derive(Clone, Copy)]
pub(super) enum Mark {
    Line(RGBColor, i32),
    Square(RGBColor),
    Dot(RGBColor),
    /// A line with the marker of a number.
    Marked(RGBColor, usize),
    /// A broken line.
    Broken(RGBColor),
}

/// Half the size of a marker, in units.
const HALF: i32 = 4;

/// Draws the marker of a number: shapes that differ without their colours.
pub(super) fn marker(
    area: &Area<'_>,
    (x, y): (i32, i32),
    color: RGBColor,
    number: usize,
) -> Result<(), PlotError> {
    let r = HALF * FINE;
    let fill = color.filled();
    let stroke = color.stroke_width((2 * FINE) as u32);
    let line = |from: (i32, i32), to: (i32, i32)| {
        let (from, to) = ((x + from.0, y + from.1), (x + to.0, y + to.1));
        area.draw(&PathElement::new(vec![from, to], stroke))
    };
    let corners = |corners: &[(i32, i32)]| {
        let corners = corners.iter().map(|c| (x + c.0, y + c.1));
        area.draw(&Polygon::new(corners.collect::<Vec<_>>(), fill))
    };
    // Where colours repeat, shapes are shifted against them.
    match (number + number / PALETTE.len()) % 7 {
        0 => area.draw(&Circle::new((x, y), r, fill))?,
        1 => area.draw(&Rectangle::new([(x - r, y - r), (x + r, y + r)], fill))?,
        2 => corners(&[(0, -r * 5 / 4), (r * 5 / 4, r), (-r * 5 / 4, r)])?,
        3 => corners(&[
            (0, -r * 3 / 2),
            (r * 3 / 2, 0),
            (0, r * 3 / 2),
            (-r * 3 / 2, 0),
        ])?,
        4 => corners(&[(0, r * 5 / 4), (r * 5 / 4, -r), (-r * 5 / 4, -r)])?,
        5 => {
            line((-r, -r), (r, r))?;
            line((-r, r), (r, -r))?;
        }
        _ => {
            line((-r * 5 / 4, 0), (r * 5 / 4, 0))?;
            line((0, -r * 5 / 4), (0, r * 5 / 4))?;
        }
    }
    Ok(())
}

const SAMPLE: i32 = 26;
const GAP: i32 = 18;
const ROW: i32 = 22;

/// Height of a legend with these entries in a width, in units.
pub(super) fn legend_height(entries: &[(String, Mark)], room: i32) -> i32 {
    let last = position(entries, room).last().copied();
    last.map_or(0, |(_, row)| (row + 1) * ROW + 6)
}

/// Start (in fine pixels) and row of each entry.
fn position(entries: &[(String, Mark)], room: i32) -> Vec<(i32, i32)> {
    let (mut x, mut row) = (0, 0);
    let mut out = Vec::with_capacity(entries.len());
    for (text, _) in entries {
        let needed = (SAMPLE + 6 + GAP) * FINE + width(text, TEXT);
        if x > 0 && x + needed - GAP * FINE > room * FINE {
            (x, row) = (0, row + 1);
        }
        out.push((x, row));
        x += needed;
    }
    out
}

/// Draws a legend with its upper left corner at a point (in units); what is longer than the room ends with an ellipsis.
pub(super) fn legend(
    area: &Area<'_>,
    [left, top]: [i32; 2],
    room: i32,
    entries: &[(String, Mark)],
) -> Result<(), PlotError> {
    let style = font(TEXT).pos(Pos::new(HPos::Left, VPos::Center));
    let letters = (room - SAMPLE - 6) * FINE / width("n", TEXT) - 1;
    for ((text, mark), (x, row)) in entries.iter().zip(position(entries, room)) {
        let end = text.char_indices().nth(letters.max(0) as usize);
        let text = end.map_or_else(|| text.clone(), |(end, _)| format!("{}…", &text[..end]));
        let x = left * FINE + x;
        let y = (top + row * ROW + ROW / 2) * FINE;
        let middle = (x + SAMPLE * FINE / 2, y);
        let r = 4 * FINE;
        let line = |from: i32, length: i32, color: RGBColor, stroke: i32| {
            let style = color.stroke_width((stroke * FINE / 2) as u32);
            area.draw(&PathElement::new(
                vec![(from, y), (from + length * FINE, y)],
                style,
            ))
        };
        match *mark {
            Mark::Line(color, stroke) => line(x, SAMPLE, color, stroke)?,
            Mark::Square(color) => area.draw(&Rectangle::new(
                [(middle.0 - r, y - r), (middle.0 + r, y + r)],
                color.filled(),
            ))?,
            Mark::Dot(color) => area.draw(&Circle::new(middle, r * 3 / 4, color.filled()))?,
            Mark::Marked(color, number) => {
                line(x, SAMPLE, color, 3)?;
                marker(area, middle, color, number)?;
            }
            Mark::Broken(color) => {
                line(x, 9, color, 3)?;
                line(x + 15 * FINE, 9, color, 3)?;
            }
        }
        area.draw_text(&text, &style, (x + (SAMPLE + 6) * FINE, y))?;
    }
    Ok(())
}

/// The least and the largest of some values.
pub(super) fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
        [low.min(v), high.max(v)]
    })
}

/// A range of all values with a margin, never empty.
pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = span(values.filter(|v| v.is_finite()));
    if low > high {
        return [0.0, 1.0];
    }
    let size = high - low;
    let tiny = 1e-9 * low.abs().max(high.abs());
    if size <= tiny {
        let room = if tiny > 0.0 { 0.1 * high.abs() } else { 1.0 };
        return [low - room, high + room];
    }
    [low - 0.04 * size, high + 0.04 * size]
}
