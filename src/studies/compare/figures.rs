//! Figures of a comparison: convergence, work and precision, drift, iterations.

mod drift;

use super::tables::listed;
use super::{Comparison, ComparisonRow, ErrorQuantity};
use crate::output::plot::{AxisScale, Graph, PlotCurve, PlotError, escaped, graphs};
use drift::{PARTS, drift};

/// Name of broken lines in the legend.
const LEVEL: &str = "error of the reference (estimate)";

/// A figure with its file name and caption.
pub struct Figure {
    /// Name of its file.
    pub name: &'static str,
    /// Caption.
    pub caption: String,
    /// What is drawn.
    pub graphs: Vec<Graph>,
    /// The drawing.
    pub svg: String,
}

/// All figures that are not empty.
///
/// # Errors
/// [`PlotError`] of the drawing library.
pub fn figures(comparison: &Comparison) -> Result<Vec<Figure>, PlotError> {
    let mut out = Vec::new();
    let left_out = left_out(comparison);
    let mut add = |name, caption: &str, drawn: Vec<Graph>| -> Result<(), PlotError> {
        let mut curves = drawn.iter().flat_map(|g| &g.curves);
        if curves.any(|c| !c.points.is_empty()) {
            let omitted = match name {
                "drift.svg" => stopping(comparison),
                _ => left_out.clone(),
            };
            out.push(Figure {
                name,
                caption: format!("{caption}{omitted}"),
                svg: graphs(comparison.title.as_deref(), LEVEL, &drawn)?,
                graphs: drawn,
            });
        }
        Ok(())
    };
    add(
        "convergence.svg",
        "Root mean square error over the step size, at all common times and frame nodes. Triangles \
         have the orders of theory. Where no broken line stands, the error of the reference is \
         smaller than a hundredth of all errors shown.",
        convergence(comparison),
    )?;
    add(
        "work.svg",
        "Error over cost: assemblies of the model (one per evaluation, three with a tangent where \
         rates are spins), and wall time.",
        work(comparison),
    )?;
    add(
        "drift.svg",
        &format!(
            "Conserved quantities of the motion: their change since the start at common times. \
             Where it does not keep its energy, the defect of the balance of energy: kinetic and stored \
             less supplied. Curves are envelopes: the largest value in each of {PARTS} parts of a run."
        ),
        drift(comparison),
    )?;
    add(
        "iterations.svg",
        "Linear solutions per step.",
        iterations(comparison),
    )?;
    Ok(out)
}

/// One curve per scheme in its colour; a point per row with a value.
fn curves(
    comparison: &Comparison,
    point: &dyn Fn(&ComparisonRow) -> Option<(f64, f64)>,
) -> Vec<PlotCurve> {
    let schemes = comparison.orders.iter().enumerate();
    let curve = schemes.filter_map(|(k, scheme)| {
        let points: Vec<_> = comparison.of(&scheme.scheme).filter_map(point).collect();
        // Empty curves have no entry in the legend.
        let label = label(comparison, &scheme.scheme);
        (!points.is_empty()).then(|| PlotCurve::new(label, points).colored(k))
    });
    curve.collect()
}

/// Name of a scheme in the legend, with the number of runs drawn if it is not that of all.
fn label(comparison: &Comparison, scheme: &str) -> String {
    let all = comparison.of(scheme).count();
    let drawn = comparison.of(scheme).filter(|row| row.is_regular()).count();
    match drawn == all {
        true => scheme.to_owned(),
        false => format!("{scheme} ({drawn} of {all} runs)"),
    }
}

/// Name of a scheme in the legend of a figure over time, with a note if its run failed and its curve ends early.
fn lasting(comparison: &Comparison, scheme: &str) -> String {
    let mut stopped = stopped(comparison);
    match stopped.any(|row| row.scheme == scheme) {
        true => format!("{scheme} (stops: failed)"),
        false => scheme.to_owned(),
    }
}

/// Incomplete runs of a figure over time.
fn stopped(comparison: &Comparison) -> impl Iterator<Item = &ComparisonRow> {
    let [coarsest, finest] = ends(comparison);
    let short = comparison.rows.iter().filter(move |row| {
        let coarse = comparison.long.is_empty() && near(row.step, coarsest);
        coarse || near(row.step, finest)
    });
    let all = short.chain(&comparison.long);
    all.filter(|row| row.failure.is_some() && row.samples.len() > 1)
}

/// The largest and the smallest step size.
fn ends(comparison: &Comparison) -> [f64; 2] {
    let steps = || comparison.rows.iter().map(|row| row.step);
    let largest = steps().fold(0.0, f64::max);
    [largest, steps().fold(f64::INFINITY, f64::min)]
}

/// Caption of the curves over time that end early.
fn stopping(comparison: &Comparison) -> String {
    let name = |row: &ComparisonRow| {
        let t = row.samples.last().map_or(0.0, |s| s.t);
        let (scheme, h) = (escaped(&row.scheme), rounded(row.step));
        format!("{scheme} with h = {h} after t = {}", rounded(t))
    };
    let before = " Curves that stop, as their runs failed: ";
    listed(before, stopped(comparison).map(name))
}

/// Caption of the runs that are not drawn.
fn left_out(comparison: &Comparison) -> String {
    let mut names: Vec<String> = Vec::new();
    for scheme in &comparison.orders {
        let word = escaped(&scheme.scheme);
        let rows: Vec<&ComparisonRow> = comparison.of(&scheme.scheme).collect();
        if rows.len() > 1 && rows.iter().all(|row| row.failure.is_some()) {
            names.push(format!("{word} (no run came to its end)"));
            continue;
        }
        for row in rows.iter().filter(|row| !row.is_regular()) {
            let why = match row.failure {
                Some(_) => "it came to no end",
                None => "its steps were halved",
            };
            names.push(format!("{word} with h = {} ({why})", rounded(row.step)));
        }
    }
    listed(" Left out: ", names.into_iter())
}

/// The quantities with more than round-off.
fn shown(comparison: &Comparison) -> Vec<ErrorQuantity> {
    let visible = |q: &ErrorQuantity| {
        let level = comparison.reference_error(*q);
        let errors = comparison.rows.iter().filter_map(|row| row.error);
        errors.map(|e| e.of(*q)).any(|e| e > level && e.is_finite())
    };
    ErrorQuantity::ALL.into_iter().filter(visible).collect()
}

/// Largest factor below all errors at which the error of the reference is drawn.
const FAR: f64 = 1e-2;

/// The error of the reference, if it is close to the errors drawn.
fn level(comparison: &Comparison, quantity: ErrorQuantity) -> Option<f64> {
    let level = comparison.reference.as_ref()?.error.of(quantity);
    let errors = comparison
        .rows
        .iter()
        .filter_map(|row| row.regular_error(quantity));
    let least = errors.filter(|e| *e > 0.0).fold(f64::INFINITY, f64::min);
    (level > FAR * least).then_some(level)
}

fn slopes(comparison: &Comparison, quantity: ErrorQuantity) -> Vec<f64> {
    let orders = comparison.orders.iter().filter_map(|o| o.theory);
    let mut slopes: Vec<usize> = orders.map(|o| o.of(quantity)).collect();
    slopes.sort_unstable();
    slopes.dedup();
    slopes.into_iter().rev().map(|p| p as f64).collect()
}

/// A value of a run, where known.
type Value<'a> = dyn Fn(&ComparisonRow) -> Option<f64> + 'a;

/// Errors in a quantity over the step size or the cost of a run.
fn errors(comparison: &Comparison, quantity: ErrorQuantity, x: &str, of: &Value<'_>) -> Graph {
    let description = [x.to_owned(), format!("error of {}", quantity.name())];
    let point = |row: &ComparisonRow| Some((of(row)?, row.regular_error(quantity)?));
    let curves = curves(comparison, &point);
    Graph {
        marked: true,
        level: level(comparison, quantity),
        ..Graph::new(description, [AxisScale::Logarithmic; 2], curves)
    }
}

fn convergence(comparison: &Comparison) -> Vec<Graph> {
    let graph = |quantity| Graph {
        slopes: slopes(comparison, quantity),
        ..errors(comparison, quantity, "step size h", &|row| Some(row.step))
    };
    shown(comparison).into_iter().map(graph).collect()
}

fn work(comparison: &Comparison) -> Vec<Graph> {
    let alone = comparison
        .rows
        .iter()
        .any(|row| row.seconds_alone.is_some());
    let time = match (alone, comparison.threads) {
        (true, _) => "time / s".to_owned(),
        (false, 1) => "wall time / s".to_owned(),
        (false, n) => format!("wall time, {n} runs in parallel / s"),
    };
    let seconds = |row: &ComparisonRow| match alone {
        true => row.seconds_alone,
        false => Some(row.seconds),
    };
    let assemblies = |row: &ComparisonRow| Some(row.assemblies as f64);
    let graphs = shown(comparison).into_iter().take(2).flat_map(|quantity| {
        [
            errors(comparison, quantity, "assemblies of the model", &assemblies),
            errors(comparison, quantity, &time, &seconds),
        ]
    });
    graphs.collect()
}

/// Whether two step sizes are equal up to rounding.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b
}

/// A step size to three digits.
fn rounded(h: f64) -> String {
    let text = format!("{h:.2e}");
    let number: f64 = text.parse().unwrap_or(h);
    match (1e-4..1e4).contains(&number) {
        true => number.to_string(),
        false => text.replace('-', "−"),
    }
}

fn iterations(comparison: &Comparison) -> Vec<Graph> {
    let regular = |row: &ComparisonRow| row.is_regular() && row.counts.steps > 0;
    let point = |row: &ComparisonRow| regular(row).then(|| (row.step, row.iterations_per_step()));
    let description = ["step size h", "linear solutions per step"].map(str::to_owned);
    let scale = [AxisScale::Logarithmic, AxisScale::Linear];
    vec![Graph {
        marked: true,
        ..Graph::new(description, scale, curves(comparison, &point))
    }]
}
