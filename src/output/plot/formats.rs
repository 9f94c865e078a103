//! Figures as PNG and PDF, made of SVG.

use super::PlotError;
use resvg::tiny_skia::{Pixmap, Transform};
use std::sync::Arc;
use svg2pdf::usvg::{Options, Tree, fontdb::Database};

/// Pixels of a PNG for each unit of the figure.
const PIXELS: f32 = 2.0;

/// The figure of a SVG text; its font is part of the program.
fn tree(svg: &str) -> Result<Tree, PlotError> {
    let mut fonts = Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    let options = Options {
        font_family: "DejaVu Sans".to_owned(),
        fontdb: Arc::new(fonts),
        ..Options::default()
    };
    Tree::from_str(svg, &options).map_err(|error| PlotError::Convert(error.to_string()))
}

/// A figure as PNG, with two pixels for each unit.
pub(crate) fn png(svg: &str) -> Result<Vec<u8>, PlotError> {
    let tree = tree(svg)?;
    let size = tree.size();
    let [width, height] = [size.width(), size.height()].map(|x| (PIXELS * x).ceil() as u32);
    let empty = || PlotError::Convert(format!("it has {width} by {height} pixels"));
    let mut pixels = Pixmap::new(width, height).ok_or_else(empty)?;
    let scale = Transform::from_scale(PIXELS, PIXELS);
    resvg::render(&tree, scale, &mut pixels.as_mut());
    let encoded = pixels.encode_png();
    encoded.map_err(|error| PlotError::Convert(error.to_string()))
}

/// A figure as a PDF of one page, with texts as texts.
pub(crate) fn pdf(svg: &str) -> Result<Vec<u8>, PlotError> {
    let (conversion, page) = Default::default();
    svg2pdf::to_pdf(&tree(svg)?, conversion, page)
        .map_err(|error| PlotError::Convert(error.to_string()))
}
