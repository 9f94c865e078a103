//! The gallery: built-in cases with published or exact results, and the program's errors.

mod arms;
mod bend45;
mod bent;
mod case;
mod exact;
mod flights;
mod helix;
mod hooke;
mod limit_points;
mod linkages;
mod mechanisms;
mod models;
mod motion;
mod planar;
mod spatial;
mod squeezer;
mod struck;
mod swings;
mod tops;

pub use case::{Case, CaseError, CaseReport, Comparison};
pub use exact::exact;
pub use models::{MODELS, model};

use super::compare::side_by_side;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// All cases, in the order in which they run.
pub const CASES: &[Case] = &[
    bend45::CASE,
    bend45::CONVERGENCE,
    helix::CASE,
    planar::ROLLUP,
    planar::ELASTICA,
    planar::CANTILEVER,
    spatial::TWISTED,
    spatial::PRINCETON,
    planar::SHEAR_FLEXIBLE,
    limit_points::LEE_FRAME,
    limit_points::DEEP_ARCH,
    spatial::BENDING_TORSION,
    planar::FOLLOWER,
    bend45::OBJECTIVITY,
    tops::TOP,
    hooke::CASE,
    struck::CASE,
    arms::SPHERICAL,
    arms::REVOLUTE,
    tops::HEAVY_TOP,
    tops::FREE_BODY,
    swings::PENDULUM,
    hooke::UNIVERSAL,
    struck::CONVERGED,
    flights::SPIN_UP,
    flights::FLYING,
    swings::DOUBLE,
    swings::RUBBER,
    linkages::FOUR_BAR,
    bent::COUPLER,
    linkages::SLIDER_CRANK,
    bent::CONNECTING_ROD,
    linkages::PARALLELOGRAMS,
    squeezer::CASE,
    mechanisms::BRICARD,
    mechanisms::MISALIGNED,
    mechanisms::HARDLY_MISALIGNED,
];

/// Runs the cases of the given names (all without names) side by side and returns one row per compared
/// quantity. Plots go to `out` if it is given; `progress` is called with the name of each case.
///
/// # Errors
/// [`CaseError`] for an unknown name, or a case that cannot be computed.
pub fn run(
    names: &[String],
    out: Option<&Path>,
    progress: &mut (dyn FnMut(&str) + Send),
) -> Result<Vec<Comparison>, CaseError> {
    // Cases are named like their model files, which have underscores.
    let names: Vec<String> = names.iter().map(|n| n.replace('_', "-")).collect();
    if let Some(name) = names.iter().find(|n| CASES.iter().all(|c| c.name != **n)) {
        return Err(CaseError::Unknown {
            name: name.clone(),
            known: CASES.iter().map(|c| c.name).collect::<Vec<_>>().join(", "),
        });
    }
    let chosen = |case: &&Case| names.is_empty() || names.iter().any(|n| n == case.name);
    let cases: Vec<&Case> = CASES.iter().filter(chosen).collect();
    let progress = Mutex::new(progress);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let ran = side_by_side(cases.len(), threads, &|k| {
        let case = cases[k];
        (progress.lock().unwrap_or_else(PoisonError::into_inner))(case.name);
        let mut report = CaseReport::new(case.name, out);
        let start = Instant::now();
        (case.run)(&mut report)?;
        Ok(report.finish(start.elapsed().as_secs_f64()))
    });
    let mut rows = Vec::new();
    for case in ran {
        rows.extend(case?);
    }
    Ok(rows)
}
