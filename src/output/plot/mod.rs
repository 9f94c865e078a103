//! Figures as SVG text: curves in panels, and the shape of a structure.

mod axes;
mod curves;
mod shape;

pub use curves::{Curve, Panel, panels};
pub use shape::{Shapes, deformed};

use plotters::drawing::DrawingAreaErrorKind;
use plotters::style::{RGBColor, TextStyle};

/// Why a figure cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The drawing library refuses.
    #[error("{0}")]
    Drawing(#[from] DrawingAreaErrorKind<std::io::Error>),
}

/// Colours that stay apart for all readers and in print (Okabe & Ito 2008), the palest left out.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
];

/// Colour of the frame around a plot.
const INK: RGBColor = RGBColor(40, 40, 40);
/// Colour of grid lines.
const GRID: RGBColor = RGBColor(228, 228, 228);
/// Colour of reference shapes.
const PALE: RGBColor = RGBColor(160, 160, 160);

/// Font sizes of text and titles in pixels.
const TEXT: u32 = 15;
const TITLE: u32 = 18;

fn font(size: u32) -> TextStyle<'static> {
    use plotters::style::{FontStyle, IntoTextStyle, register_font as _};
    ("sans-serif", size).into_text_style(&(0, 0)).color(&INK)
}
