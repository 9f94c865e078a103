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

pub use case::{CaseError, CaseProblem, CaseRow};
use case::{CaseReport, Run};
pub use exact::exact;
pub use models::{MODELS, model};

use super::compare::side_by_side;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// All cases, in the order in which they run.
const CASES: &[(&str, Run)] = &[
    ("bend45", bend45::thesis),
    ("bend45-convergence", bend45::convergence),
    ("helix", helix::run),
    ("rollup", planar::rollup),
    ("elastica", planar::elastica),
    ("cantilever", planar::cantilever),
    ("twisted", spatial::twisted),
    ("princeton", spatial::princeton),
    ("shear-flexible", planar::shear_flexible),
    ("lee-frame", limit_points::lee_frame),
    ("deep-arch", limit_points::deep_arch),
    ("column", limit_points::column),
    ("rotating-blade", vibration::blade),
    ("bending-torsion", spatial::bending_torsion),
    ("follower", planar::follower),
    ("objectivity", bend45::objectivity),
    ("top", tops::top),
    ("hooke", hooke::hooke),
    ("elbow", struck::elbow),
    ("arm-spherical", arms::spherical),
    ("arm-revolute", arms::revolute),
    ("heavy-top", tops::heavy_top),
    ("free-body", tops::free_body),
    ("pendulum", swings::pendulum),
    ("universal-joint", hooke::universal),
    ("elbow-converged", struck::converged),
    ("spin-up", flights::spin_up),
    ("flying-beam", flights::flying),
    ("double-pendulum", swings::double),
    ("rubber-rod", swings::rubber),
    ("four-bar", linkages::four_bar),
    ("four-bar-flexible", bent::coupler),
    ("slider-crank", linkages::slider_crank),
    ("slider-crank-flexible", bent::connecting_rod),
    ("parallelograms", linkages::parallelograms),
    ("squeezer", squeezer::run),
    ("bricard", mechanisms::bricard),
    ("four-bar-misaligned", mechanisms::misaligned),
    ("four-bar-hardly-misaligned", mechanisms::hardly_misaligned),
];

/// The names of all cases.
pub fn case_names() -> impl Iterator<Item = &'static str> {
    CASES.iter().map(|(name, _)| *name)
}

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
    if let Some(name) = names
        .iter()
        .find(|n| case_names().all(|known| known != **n))
    {
        return Err(CaseError::Unknown {
            name: name.clone(),
            known: case_names().collect::<Vec<_>>().join(", "),
        });
    }
    let chosen = |name: &str| names.is_empty() || names.iter().any(|n| n == name);
    let cases: Vec<_> = CASES.iter().filter(|(name, _)| chosen(name)).collect();
    let progress = Mutex::new(progress);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let order: Vec<usize> = (0..cases.len()).collect();
    let ran = side_by_side(&order, threads, &|k| {
        let (name, run) = *cases[k];
        (progress.lock().unwrap_or_else(PoisonError::into_inner))(name);
        let mut report = CaseReport::new(name, out);
        let start = Instant::now();
        match run(&mut report) {
            Ok(()) => Ok(report.finish(start.elapsed().as_secs_f64())),
            Err(problem) => Err(CaseError::Case {
                case: name.to_owned(),
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
