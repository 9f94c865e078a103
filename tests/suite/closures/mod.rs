//! Loops closed by multipliers and penalties.

mod alike;
mod allocation;
mod forces;
mod gallery;
mod program;
mod runs;
mod start;
mod units;
mod velocities;

use crate::support::closures::{GROUND, RUN, four_bar};
use crate::support::prelude::*;

/// The four-bar linkage as a model, with words for crank, coupler and rocker, and how its loop is closed.
fn linkage_of(words: [&str; 3], closure: &str) -> String {
    [GROUND, RUN, &four_bar(words, closure)].concat()
}

/// Coordinates and velocities of a model at its start that has rates of some coordinates, whether they are unknowns or
/// follow from others.
fn started_with(context: &mut Context, rates: &[(NodeId, usize, f64)]) -> [Vec<f64>; 2] {
    let mut q = context.initial().to_vec();
    let mut v = vec![0.0; q.len()];
    let unknowns = rates
        .iter()
        .map(|&(node, k, _)| context.unknown_at(node, k));
    let left = match unknowns.collect::<Option<Vec<usize>>>() {
        Some(kept) => {
            let rates = kept.iter().zip(rates);
            rates.for_each(|(&u, &(.., rate))| v[u] = rate);
            context.project_state(0.0, &mut q, &mut v, &kept).unwrap()
        }
        None => {
            let (missing, _) = context
                .fit_coordinate_rates(&q, &mut v, rates, &[])
                .unwrap();
            missing.iter().fold(0.0_f64, |m, x| m.max(x.abs()))
        }
    };
    assert!(left < 1e-12, "{left:e}");
    [q, v]
}
