//! Figures as SVG text: curves in panels, and the shape of a structure.

mod axes;
mod curves;
mod formats;
mod graph;
mod scale;
mod shape;
mod viewer;

pub use curves::PlotCurve;
pub(crate) use curves::panels;
pub(crate) use formats::{pdf, png};
pub use graph::{Graph, graphs};
pub use scale::AxisScale;
pub(crate) use shape::{Shapes, deformed};
pub(crate) use viewer::{escaped, viewer};

use axes::Area;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::{IntoDrawingArea, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontDesc, FontFamily, FontStyle, RGBColor, TextStyle, WHITE};

/// Why a figure cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// An error of the drawing library.
    #[error("{0}")]
    Drawing(#[from] DrawingAreaErrorKind<std::io::Error>),
    /// Its SVG cannot be converted.
    #[error("cannot convert the SVG: {0}")]
    Convert(String),
}

/// Colours that all readers can tell apart, in print too (Okabe & Ito 2008), without the palest.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// Colour of frames and text.
const INK: RGBColor = RGBColor(40, 40, 40);
/// Colour of grid lines.
const GRID: RGBColor = RGBColor(228, 228, 228);
/// Colour of reference shapes.
const PALE: RGBColor = RGBColor(150, 150, 150);

/// Font sizes of text and titles in units of the figure.
const TEXT: i32 = 15;
const TITLE: i32 = 18;

/// The library positions everything at whole pixels; this many of them make one unit of the figure,
/// which keeps curves smooth.
const FINE: i32 = 8;

fn font(size: i32) -> TextStyle<'static> {
    let size = f64::from(size * FINE);
    FontDesc::new(FontFamily::SansSerif, size, FontStyle::Normal).color(&INK)
}

/// Estimated width of a text, in fine pixels.
fn width(text: &str, size: i32) -> i32 {
    // Font sizes of the library are 1.24 times those of the text; a letter is half as wide.
    text.chars().count() as i32 * size * FINE * 45 / 100
}

/// A figure of a size with a title, as SVG text.
fn figure(
    title: Option<&str>,
    [w, h]: [i32; 2],
    draw: impl FnOnce(&Area<'_>) -> Result<(), PlotError>,
) -> Result<String, PlotError> {
    let mut svg = String::new();
    {
        let fine = ((w * FINE) as u32, (h * FINE) as u32);
        let root = SVGBackend::with_string(&mut svg, fine).into_drawing_area();
        root.fill(&WHITE)?;
        if let Some(title) = title {
            let style = font(TITLE).pos(Pos::new(HPos::Center, VPos::Center));
            root.draw_text(title, &style, (w * FINE / 2, 20 * FINE))?;
        }
        draw(&root)?;
        root.present()?;
    }
    // What is drawn in fine pixels gets its size in units.
    let fine = format!("width=\"{}\" height=\"{}\"", w * FINE, h * FINE);
    let svg = svg.replacen(&fine, &format!("width=\"{w}\" height=\"{h}\""), 1);
    Ok(svg.replace("<polyline ", "<polyline stroke-linejoin=\"round\" "))
}

/// A part of a figure, in units.
fn part<'a>(root: &Area<'a>, [x, y]: [i32; 2], [w, h]: [i32; 2]) -> Area<'a> {
    root.clone()
        .shrink((x * FINE, y * FINE), (w * FINE, h * FINE))
}
