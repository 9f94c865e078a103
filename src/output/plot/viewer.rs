//! A page that plays the motion of a structure.

use super::Shapes;
use crate::input::Units;
use serde_json::{Value, json};
use std::ops::Range;

/// Most points of all states in a page: some ten megabytes.
const POINTS: usize = 400_000;

/// A page in one file that shows these shapes in turn, in three dimensions; `parameter` is what they are at.
pub(crate) fn viewer(
    title: Option<&str>,
    units: &Units,
    parameter: &str,
    reference: &Shapes,
    shapes: &[(f64, Shapes)],
) -> String {
    let mut first = 0;
    let mut next = |count: usize| -> Range<usize> {
        first += count;
        first - count..first
    };
    let lines: Vec<[usize; 2]> = (reference.lines.iter())
        .map(|line| next(line.len()))
        .map(|points| [points.start, points.end])
        .collect();
    let links: Vec<[usize; 2]> = (reference.links.iter())
        .map(|_| next(2))
        .map(|ends| [ends.start, ends.start + 1])
        .collect();
    let bodies: Vec<usize> = next(reference.bodies.len()).collect();
    let supports: Vec<usize> = next(reference.supports.len()).collect();
    // The last one is among them.
    let every = (first * shapes.len()).div_ceil(POINTS).max(1);
    let skipped = shapes.len().saturating_sub(1) % every;
    let shapes = shapes.iter().skip(skipped).step_by(every);
    let frames: Vec<Value> = shapes.map(|(t, shapes)| frame(*t, shapes)).collect();
    let parameter = match parameter {
        "time" => units.label("time", [0, 0, 1, 0]),
        other => other.to_owned(),
    };
    let data = json!({
        "parameter": parameter,
        "lines": lines,
        "links": links,
        "bodies": bodies,
        "supports": supports,
        "reference": frame(f64::NAN, reference),
        "frames": frames,
    });
    // Text of a model must not end the element that it is in.
    let data = data.to_string().replace('<', "\\u003c");
    let title = escaped(title.unwrap_or("pullback"));
    let parameter = escaped(&parameter);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
         <style>\n{}</style>\n</head>\n<body>\n<header>{title}</header>\n\
         <footer>\n<button id=\"play\">Pause</button>\n\
         <input id=\"slider\" type=\"range\" min=\"0\" max=\"1\" step=\"any\" value=\"0\" aria-label=\"{parameter}\">\n\
         <output id=\"time\"></output>\n</footer>\n\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n{}</script>\n<script>\n{}</script>\n</body>\n</html>\n",
        include_str!("viewer/viewer.css"),
        include_str!("viewer/three.min.js"),
        include_str!("viewer/viewer.js"),
    )
}

/// A text in HTML.
pub(crate) fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}

/// Points and axes of bodies at a load parameter or time.
fn frame(t: f64, shapes: &Shapes) -> Value {
    let lines = shapes.lines.iter().flatten();
    let points = lines.chain(shapes.links.iter().flatten());
    let points = points.chain(&shapes.bodies).chain(&shapes.supports);
    // A screen has no more digits than these numbers.
    let points: Vec<f32> = points.flatten().map(|x| *x as f32).collect();
    let axes: Vec<f32> = shapes.axes.iter().flatten().map(|x| *x as f32).collect();
    json!({ "t": t, "points": points, "axes": axes })
}
