//! Axes, tick labels and legends of all figures.

use super::{FINE, GRID, INK, PALETTE, PlotError, TEXT, font, width};
use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::prelude::{DrawingArea, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor};

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type PlotArea<'a, 'b> =
    ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Margins for tick labels and descriptions at the left and at the bottom, and around a plot.
pub(super) const LEFT: i32 = 80;
pub(super) const BOTTOM: i32 = 44;
pub(super) const MARGIN: i32 = 14;

/// A number as a tick label.
pub(super) fn tick(value: f64, range: f64) -> String {
    if value.abs() < 1e-9 * range {
        return "0".to_owned();
    }
    let size = value.abs().max(range);
    let text = if (1e-3..1e5).contains(&size) {
        // Four digits of the range suffice for ticks.
        let digits = (3.0 - range.log10().floor()).clamp(0.0, 9.0) as usize;
        let fixed = format!("{value:.digits$}");
        match fixed.contains('.') {
            true => fixed.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => fixed,
        }
    } else {
        let short = format!("{value:.3e}");
        let (number, exponent) = short.split_once('e').unwrap_or((&short, "0"));
        let number = number.trim_end_matches('0').trim_end_matches('.');
        format!("{number}e{exponent}")
    };
    text.replace('-', "−")
}

/// Draws axes with ticks, light grid lines and descriptions.
pub(super) fn axes<'a, 'b>(
    area: &'a Area<'b>,
    x: [f64; 2],
    y: [f64; 2],
    description: [&str; 2],
) -> Result<PlotArea<'a, 'b>, PlotError> {
    let mut chart = ChartBuilder::on(area)
        .margin(MARGIN * FINE)
        .x_label_area_size(BOTTOM * FINE)
        .y_label_area_size(LEFT * FINE)
        .build_cartesian_2d(x[0]..x[1], y[0]..y[1])?;
    let (pixels_x, pixels_y) = chart.plotting_area().dim_in_pixel();
    let count = |pixels: u32, room: i32| (pixels as i32 / (room * FINE)).clamp(2, 7) as usize;
    let line = INK.stroke_width(FINE as u32);
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(count(pixels_x, 75))
        .y_labels(count(pixels_y, 48))
        .x_label_formatter(&|v| tick(*v, x[1] - x[0]))
        .y_label_formatter(&|v| tick(*v, y[1] - y[0]))
        .x_desc(description[0])
        .y_desc(description[1])
        .axis_style(line)
        .bold_line_style(GRID.stroke_width(FINE as u32))
        .label_style(font(TEXT))
        .axis_desc_style(font(TEXT))
        .set_all_tick_mark_size(5 * FINE)
        .draw()?;
    // Closes the frame: the library draws two sides of it.
    let [(x0, y0), (x1, y1)] = [(x[0], y[0]), (x[1], y[1])];
    chart.draw_series(std::iter::once(PathElement::new(
        vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)],
        line,
    )))?;
    Ok(chart)
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

/// Number of rows of a legend with these entries in a width (in units).
pub(super) fn legend_rows(entries: &[(String, Mark)], room: i32) -> i32 {
    position(entries, room).last().map_or(0, |(_, row)| row + 1)
}

/// Height of a number of legend rows, in units.
pub(super) fn legend_height(rows: i32) -> i32 {
    if rows == 0 { 0 } else { rows * ROW + 6 }
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

/// Draws a legend with its upper left corner at a point (in units).
pub(super) fn legend(
    area: &Area<'_>,
    [left, top]: [i32; 2],
    room: i32,
    entries: &[(String, Mark)],
) -> Result<(), PlotError> {
    let style = font(TEXT).pos(Pos::new(HPos::Left, VPos::Center));
    for ((text, mark), (x, row)) in entries.iter().zip(position(entries, room)) {
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
        area.draw_text(text, &style, (x + (SAMPLE + 6) * FINE, y))?;
    }
    Ok(())
}

/// A range of all values with a margin, never empty.
pub(super) fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let finite = values.filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
        (a.min(v), b.max(v))
    });
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
