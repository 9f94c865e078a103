//! The gallery: built-in cases whose results are compared with published or exact ones.

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
mod vibration;

use case::CaseReport;
pub use case::{Case, CaseError, CaseProblem, CaseRow};
pub use exact::exact;
pub use models::{MODELS, model};

use super::compare::side_by_side;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// All cases, in the order in which they run.
pub const CASES: &[Case] = &[
    Case::new("bend45", bend45::thesis),
    Case::new("bend45-convergence", bend45::convergence),
    Case::new("helix", helix::run),
    Case::new("rollup", planar::rollup),
    Case::new("elastica", planar::elastica),
    Case::new("cantilever", planar::cantilever),
    Case::new("twisted", spatial::twisted),
    Case::new("princeton", spatial::princeton),
    Case::new("shear-flexible", planar::shear_flexible),
    Case::new("lee-frame", limit_points::lee_frame),
    Case::new("deep-arch", limit_points::deep_arch),
    Case::new("column", limit_points::column),
    Case::new("rotating-blade", vibration::blade),
    Case::new("bending-torsion", spatial::bending_torsion),
    Case::new("follower", planar::follower),
    Case::new("objectivity", bend45::objectivity),
    Case::new("top", tops::top),
    Case::new("hooke", hooke::hooke),
    Case::new("elbow", struck::elbow),
    Case::new("arm-spherical", arms::spherical),
    Case::new("arm-revolute", arms::revolute),
    Case::new("heavy-top", tops::heavy_top),
    Case::new("free-body", tops::free_body),
    Case::new("pendulum", swings::pendulum),
    Case::new("universal-joint", hooke::universal),
    Case::new("elbow-converged", struck::converged),
    Case::new("spin-up", flights::spin_up),
    Case::new("flying-beam", flights::flying),
    Case::new("double-pendulum", swings::double),
    Case::new("rubber-rod", swings::rubber),
    Case::new("four-bar", linkages::four_bar),
    Case::new("four-bar-flexible", bent::coupler),
    Case::new("slider-crank", linkages::slider_crank),
    Case::new("slider-crank-flexible", bent::connecting_rod),
    Case::new("parallelograms", linkages::parallelograms),
    Case::new("squeezer", squeezer::run),
    Case::new("bricard", mechanisms::bricard),
    Case::new("four-bar-misaligned", mechanisms::misaligned),
    Case::new("four-bar-hardly-misaligned", mechanisms::hardly_misaligned),
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
) -> Result<Vec<CaseRow>, CaseError> {
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
    let order: Vec<usize> = (0..cases.len()).collect();
    let ran = side_by_side(&order, threads, &|k| {
        let case = cases[k];
        (progress.lock().unwrap_or_else(PoisonError::into_inner))(case.name);
        let mut report = CaseReport::new(case.name, out);
        let start = Instant::now();
        match (case.run)(&mut report) {
            Ok(()) => Ok(report.finish(start.elapsed().as_secs_f64())),
            Err(problem) => Err(CaseError::Case {
                case: case.name.to_owned(),
                problem,
            }),
        }
    });
    let mut rows = Vec::new();
    for case in ran {
        rows.extend(case?);
    }
    Ok(rows)
}
