//! The gallery's drawings: their labels, their curves, and points on these known from elsewhere.

use pullback::output::plot::{AxisScale, Graph, PlotCurve, graphs};
use roxmltree::{Document, Node};
use std::collections::BTreeMap;

type Curve = Vec<(f64, f64)>;

/// What a drawing must have: the case, its labels, how many curves of lines and of dots, and what is
/// known of its lines.
type Drawing = (&'static str, &'static str, [usize; 2], fn(&[Curve]));

const DRAWINGS: &[Drawing] = &[
    (
        "helix",
        "load factor | tip displacement along e3 | 100 elements | 200 elements | 100 geodesic elements",
        [3, 0],
        helix,
    ),
    (
        "top",
        "time t | nutation angle (rad) | rigid body | stiff beam | flexible beam",
        [3, 0],
        top,
    ),
    (
        "hooke",
        "time t | ‖Ψ_B‖ − ‖Ψ_A‖ (rad) | two beams, two revolute joints | exact",
        [1, 1],
        hooke,
    ),
    (
        "elbow",
        "time t | displacement along e3 | tip, 20 elements | elbow, 20 elements | tip, 4 elements | \
         elbow, 4 elements",
        [2, 2],
        elbow,
    ),
    ("arm-spherical", ARM, [4, 4], |lines| {
        arm(lines, [-14.544, 7.072, 3.706])
    }),
    ("arm-revolute", ARM, [4, 4], |lines| {
        arm(lines, [-11.079, 0.049, 2.797])
    }),
];

const ARM: &str = "time t | displacement of the tip | e1, 40 elements | e2, 40 elements | e3, 40 elements | \
    norm, 40 elements | e1, 8 elements | e2, 8 elements | e3, 8 elements | norm, 8 elements";

/// Names of the cases whose drawings are known here.
pub fn cases() -> impl Iterator<Item = &'static str> {
    DRAWINGS.iter().map(|d| d.0)
}

/// Holds a case's drawing to what is known of it.
pub fn check(case: &str, text: &str) {
    let drawing = DRAWINGS.iter().find(|d| d.0 == case);
    let &(_, labels, [lines, dots], known) = drawing.unwrap();
    let document = Document::parse(text).unwrap();
    assert_labelled(&document, labels);
    let drawn = curves(&document);
    assert_eq!([drawn.len(), dotted(&document)], [lines, dots], "{case}");
    known(&drawn);
}

/// Each of these labels, with bars between them, is a text of a drawing.
#[track_caller]
pub fn assert_labelled(document: &Document<'_>, labels: &str) {
    let texts = tagged(document, "text").filter_map(|n| n.text());
    let texts: Vec<&str> = texts.map(str::trim).collect();
    for label in labels.split(" | ") {
        assert!(texts.contains(&label), "{label:?} is not among {texts:?}");
    }
}

/// The drawing of a graph without descriptions, of curves with marks or without.
pub fn graph(scale: [AxisScale; 2], curves: Vec<PlotCurve>, marked: bool) -> String {
    let graph = Graph {
        description: [String::new(), String::new()],
        scale,
        curves,
        marked,
        slopes: Vec::new(),
        level: None,
    };
    graphs(None, "", &[graph]).unwrap()
}

/// The elements of a name.
pub fn tagged<'a, 'i>(
    document: &'a Document<'i>,
    name: &'a str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    let all = document.descendants();
    all.filter(move |n| n.has_tag_name(name))
}

/// Points of each curve that is a line, one coordinate after the other; frames, ticks and legends have five
/// points at most.
pub fn polylines(document: &Document<'_>) -> impl Iterator<Item = Vec<f64>> {
    let lines = tagged(document, "polyline");
    let lines = lines.map(|n| numbers(n.attribute("points").unwrap()));
    lines.filter(|points| points.len() > 2 * 5)
}

/// Numbers of an attribute.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split([' ', ',']).filter(|w| !w.is_empty());
    words.map(|w| w.parse().unwrap()).collect()
}

/// Labels of ticks, and their positions along an axis.
pub fn ticks(
    document: &Document<'_>,
    coordinate: &str,
    is_tick: impl Fn(&Node<'_, '_>) -> bool,
) -> impl Iterator<Item = (String, f64)> {
    let labels = tagged(document, "text").filter(move |n| is_tick(n));
    labels.filter_map(move |n| {
        let label = n.text()?.trim();
        let position = numbers(n.attribute(coordinate)?)[0];
        (!label.is_empty()).then(|| (label.to_owned(), position))
    })
}

/// Whether a text is the label of a tick of the horizontal axis, or of the vertical one.
pub const TICKS: [fn(&Node<'_, '_>) -> bool; 2] = [
    |n| n.attribute("dy") == Some("0.76em") && n.attribute("transform").is_none(),
    |n| n.attribute("text-anchor") == Some("end"),
];

/// Turns positions along a drawing's axis into values, by the labels at two ticks.
fn axis(
    document: &Document<'_>,
    coordinate: &str,
    is_tick: impl Fn(&Node<'_, '_>) -> bool,
) -> impl Fn(f64) -> f64 {
    let ticks = ticks(document, coordinate, is_tick);
    let ticks = ticks.filter_map(|(label, p)| Some([p, label.replace('−', "-").parse().ok()?]));
    let mut ticks: Vec<[f64; 2]> = ticks.collect();
    ticks.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let [[p, a], .., [q, b]] = ticks[..] else {
        panic!("{} labels along {coordinate}", ticks.len());
    };
    move |position| a + (b - a) * (position - p) / (q - p)
}

/// Least and largest value of each line in a panel of the first row of a run's drawing.
pub fn extremes(text: &str, panel: usize) -> Vec<[f64; 2]> {
    let document = Document::parse(text).unwrap();
    let width = document.root_element().attribute("viewBox").unwrap();
    // Panels stand two in a row.
    assert!(numbers(width)[2] == 8320.0);
    let inside = |x: f64, y: f64| (x / 4160.0) as usize == panel && y < 3104.0;
    let up = axis(&document, "y", |n| {
        let at = |name| numbers(n.attribute(name).unwrap())[0];
        TICKS[1](n) && inside(at("x"), at("y"))
    });
    let lines = polylines(&document);
    let curves = lines.filter(|points| points.len() > 2 * 50 && inside(points[0], points[1]));
    let heights = curves.map(|points| points.chunks(2).map(|p| up(p[1])).collect::<Vec<_>>());
    heights
        .map(|y| [f64::min, f64::max].map(|end| y.iter().copied().fold(y[0], end)))
        .collect()
}

/// The curves that are lines.
fn curves(document: &Document<'_>) -> Vec<Curve> {
    let [across, up] = [0, 1].map(|k| axis(document, ["x", "y"][k], TICKS[k]));
    polylines(document)
        .filter(|points| points.len() > 2 * 50)
        .map(|points| points.chunks(2).map(|p| (across(p[0]), up(p[1]))).collect())
        .collect()
}

/// How many curves are dots: each has its colour, and one dot in the legend.
fn dotted(document: &Document<'_>) -> usize {
    let mut dots = BTreeMap::new();
    for dot in tagged(document, "circle") {
        *dots.entry(dot.attribute("fill").unwrap()).or_insert(0) += 1;
    }
    dots.values().filter(|count| **count > 20).count()
}

/// The highest point of a curve.
fn highest(curve: &Curve) -> (f64, f64) {
    let best = curve.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
    best.unwrap()
}

#[track_caller]
fn near(found: (f64, f64), known: (f64, f64), [across, up]: [f64; 2]) {
    let off = ((found.0 - known.0).abs(), (found.1 - known.1).abs());
    let close = off.0 < across && off.1 < up;
    assert!(close, "{found:?} for {known:?}");
}

fn helix(lines: &[Curve]) {
    for curve in lines {
        // Within the lines' width: from nothing to the whole load, over the first maximum that
        // the thesis shows.
        near(curve[0], (0.0, 0.0), [2e-3, 0.02]);
        assert!((curve[curve.len() - 1].0 - 1.0).abs() < 2e-3);
        near(highest(curve), (0.036, 3.28), [3e-3, 0.05]);
    }
}

/// The rigid body and the stiff beam: from the least nutation to the largest and back in its period (R02),
/// within the lines' width.
fn top(lines: &[Curve]) {
    let period = 0.6822560158311819;
    for curve in &lines[..2] {
        near(curve[0], (0.0, 0.3), [2e-3, 1e-4]);
        let first: Curve = (curve.iter().copied()).filter(|p| p.0 < period).collect();
        let top = (0.5 * period, 0.326733714644854);
        near(highest(&first), top, [0.02, 1e-4]);
        let back = curve.iter().find(|p| p.0 >= period).unwrap();
        near(*back, (period, 0.3), [5e-3, 2e-4]);
    }
}

/// The largest lead, sin δ = (1 − c)/(1 + c) with c = cos 45°.
fn hooke(lines: &[Curve]) {
    let c = 0.5_f64.sqrt();
    let most = ((1.0 - c) / (1.0 + c)).asin();
    assert!((highest(&lines[0]).1 - most).abs() < 2e-3);
    let last = lines[0][lines[0].len() - 1];
    assert!((last.0 - 30.0).abs() < 0.03, "{last:?}");
}

/// D01 to 0.1, as meshes as coarse as the published ones are to be trusted; the highest step is up to half a
/// step, 0.1, from where the curve turns.
fn elbow(lines: &[Curve]) {
    near(highest(&lines[0]), (7.438, 8.2521), [0.2, 0.1]);
    let first: Curve = lines[1].iter().copied().filter(|p| p.0 < 5.0).collect();
    near(highest(&first), (3.1, 5.5129), [0.2, 0.1]);
}

/// The tip at t = 1 of the independent solution (tests/studies/arms.rs), to a tenth of the length.
fn arm(lines: &[Curve], tip: [f64; 3]) {
    let norm = tip.iter().map(|x| x * x).sum::<f64>().sqrt();
    for (curve, known) in lines.iter().zip([tip[0], tip[1], tip[2], norm]) {
        near(curve[0], (0.0, 0.0), [0.01, 0.05]);
        let at = curve.iter().find(|p| p.0 > 0.995).unwrap();
        near(*at, (1.0, known), [0.01, 1.0]);
        assert!((curve[curve.len() - 1].0 - 3.0).abs() < 0.01);
    }
}
