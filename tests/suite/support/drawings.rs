//! The gallery's drawings: their labels, their curves, and points on these known from elsewhere.
#![allow(dead_code, clippy::unwrap_used)]

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
    let words: Vec<&str> = document
        .descendants()
        .filter_map(|n| n.text())
        .map(str::trim)
        .collect();
    for label in labels.split(" | ") {
        assert!(words.contains(&label), "{label:?} is not among {words:?}");
    }
    let drawn = curves(&document);
    assert_eq!([drawn.len(), dotted(&document)], [lines, dots], "{case}");
    known(&drawn);
}

/// Numbers of an attribute.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split([' ', ',']).filter(|w| !w.is_empty());
    words.map(|w| w.parse().unwrap()).collect()
}

/// Turns positions along a drawing's axis into values, by the labels at two ticks.
fn axis(
    document: &Document<'_>,
    coordinate: &str,
    is_tick: impl Fn(&Node<'_, '_>) -> bool,
) -> impl Fn(f64) -> f64 {
    let labels = document
        .descendants()
        .filter(|n| n.has_tag_name("text") && is_tick(n));
    let mut ticks: Vec<[f64; 2]> = labels
        .filter_map(|n| {
            let value = n.text()?.trim().replace('−', "-").parse().ok()?;
            Some([numbers(n.attribute(coordinate)?)[0], value])
        })
        .collect();
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
        n.attribute("text-anchor") == Some("end") && inside(at("x"), at("y"))
    });
    let lines = document
        .descendants()
        .filter(|n| n.has_tag_name("polyline"));
    let lines = lines.map(|n| numbers(n.attribute("points").unwrap()));
    let curves = lines.filter(|points| points.len() > 2 * 50 && inside(points[0], points[1]));
    let heights = curves.map(|points| points.chunks(2).map(|p| up(p[1])).collect::<Vec<_>>());
    heights
        .map(|y| [f64::min, f64::max].map(|end| y.iter().copied().fold(y[0], end)))
        .collect()
}

/// The curves that are lines; the frame has five points, ticks and the legend two.
fn curves(document: &Document<'_>) -> Vec<Curve> {
    let across = axis(document, "x", |n| {
        n.attribute("dy") == Some("0.76em") && n.attribute("transform").is_none()
    });
    let up = axis(document, "y", |n| n.attribute("text-anchor") == Some("end"));
    let lines = document
        .descendants()
        .filter(|n| n.has_tag_name("polyline"));
    lines
        .map(|n| numbers(n.attribute("points").unwrap()))
        .filter(|points| points.len() > 2 * 50)
        .map(|points| points.chunks(2).map(|p| (across(p[0]), up(p[1]))).collect())
        .collect()
}

/// How many curves are dots: each has its colour, and one dot in the legend.
fn dotted(document: &Document<'_>) -> usize {
    let mut dots = BTreeMap::new();
    for dot in document.descendants().filter(|n| n.has_tag_name("circle")) {
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
    let off = (found.0 - known.0, found.1 - known.1);
    assert!(
        off.0.abs() < across && off.1.abs() < up,
        "{found:?} for {known:?}"
    );
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
        near(
            highest(&first),
            (0.5 * period, 0.326733714644854),
            [0.02, 1e-4],
        );
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
