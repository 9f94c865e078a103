//! The helical beam: rotations far beyond π, elements astride a change of chart most of the time.

use super::case::{Case, CaseError, Context, Record, peak};
use crate::output::plot::Curve;
use pullback_integrators::statics::StaticOptions;

/// The helical beam with 100 and 200 elements.
pub const CASE: Case = Case { name: "helix", run };

/// The first maximum of the tip's displacement out of the plane: load and value, by the parabola
/// through the largest recorded point and its neighbours.
fn first_maximum(records: &[Record]) -> (f64, f64) {
    let Some(k) = (1..records.len().saturating_sub(1))
        .find(|&k| records[k].state.d.z >= records[k + 1].state.d.z)
    else {
        return (f64::NAN, f64::NAN);
    };
    let points: Vec<(f64, f64)> = records.iter().map(|r| (r.t, r.state.d.z)).collect();
    peak(&points, k)
}

fn run(context: &mut Context) -> Result<(), CaseError> {
    let file = context.file(include_str!("../../examples/models/helix.toml"))?;
    let mut drifts = Vec::new();
    let mut curves = Vec::new();
    for elements in [100, 200] {
        let mut file = file.clone();
        file.lines[0].elements = elements;
        let (records, _) = context.build(&file, "tip")?.solve(&StaticOptions {
            first_step: 0.001,
            max_step: 0.004,
            ..StaticOptions::default()
        })?;
        let (load, value) = first_maximum(&records);
        let source = "published: figure in Mäkinen 2004 4.2, as described";
        context.compare(
            format!("first maximum, {elements} elements"),
            value,
            3.28,
            0.05,
            source,
        );
        let quantity = format!("load factor of the first maximum, {elements} elements");
        context.compare(quantity, load, 0.036, 0.002, source);
        let last = records.last().map_or(f64::NAN, |r| r.t);
        let quantity = format!("load factor reached, {elements} elements");
        context.compare(quantity, last, 1.0, 0.0, "the whole path");
        drifts.push(records.last().map_or(f64::NAN, |r| r.state.d.z));
        let points = std::iter::once((0.0, 0.0))
            .chain(records.iter().map(|r| (r.t, r.state.d.z)))
            .collect();
        curves.push(Curve::new(format!("{elements} elements"), points));
    }
    context.compare(
        "drift at full load, 100 over 200 elements",
        drifts[0] / drifts[1],
        2.5,
        0.5,
        "published: about 2.5 (description of the figure)",
    );
    context.figure(
        "Helical beam",
        ["load factor", "tip displacement along e3"],
        curves,
    )
}
