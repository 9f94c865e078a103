//! The linear equations of motion of a model.

use crate::input::{Job, ModelFile, Time};
use crate::modes::ModelModesError;
use pullback_elements::model::Context;
use pullback_integrators::linearization::{Linearized, linearize};
use pullback_integrators::significant;
use pullback_manifold::system::{Evaluation, Point, System, SystemError};

/// The linear equations of motion of a model about a state.
///
/// # Errors
/// [`ModelModesError::Immobile`], [`ModelModesError::Linearization`].
pub fn equations(context: &mut Context, at: Point<'_>) -> Result<Linearized, ModelModesError> {
    check_mobility(context)?;
    Ok(linearize(context, at)?)
}

/// What a user should know of the linear equations of a model about a state.
///
/// # Errors
/// [`SystemError`] if the state cannot be evaluated.
pub fn warnings(job: &mut Job, at: Point<'_>) -> Result<Vec<String>, SystemError> {
    let mut warnings = Vec::from_iter(warning_of_motion(&mut job.context, at)?);
    warnings.extend(prescribing(&job.file).map(|name| {
        format!(
            "input {name} prescribes a motion, as a value that changes from sample to sample: rates and accelerations of that \
             motion are in no matrix"
        )
    }));
    Ok(warnings)
}

pub(crate) fn check_mobility(context: &Context) -> Result<(), ModelModesError> {
    match context.mobility().coordinates {
        0 => Err(ModelModesError::Immobile),
        _ => Ok(()),
    }
}

/// Forces of a motion relative to those on the model below which it is at rest.
const AT_REST: f64 = 1e-9;

/// What a user should know of a linearisation about a state that moves.
pub(crate) fn warning_of_motion(
    context: &mut Context,
    at: Point<'_>,
) -> Result<Option<String>, SystemError> {
    let still = vec![0.0; at.q.len()];
    let (mut r, mut resting) = (still.clone(), still.clone());
    let (v, a) = (&still[..at.v.len()], &still[..at.a.len()]);
    context.evaluate(Point { v, a, ..at }, Evaluation::residual(&mut resting))?;
    context.evaluate(at, Evaluation::residual(&mut r))?;
    let measures = context.scales().measures();
    let coordinates = context.pattern().coordinates().iter();
    let moves = coordinates
        .zip(r.iter().zip(&resting))
        .any(|(info, (r, resting))| {
            (r - resting).abs() > AT_REST * measures[info.quantity.index()]
        });
    Ok(moves.then(|| {
        format!(
            "the state moves: its equations are frozen at time {}, and growth or decay of a mode does not \
             describe the motion; only a steady motion, at rest in its coordinates, has modes of its own",
            significant(at.t)
        )
    }))
}

/// An input that prescribes a motion, if there is one.
fn prescribing(file: &ModelFile) -> Option<&String> {
    let supports = file.supports.iter().filter_map(|s| s.prescribed.as_ref());
    let supports = supports.flat_map(|prescribed| prescribed.given().map(|(_, time)| time));
    let joints = file.joints.iter().filter_map(|j| j.prescribed.as_ref());
    let coordinates = file.joints.iter().flat_map(|j| j.coordinates.values());
    let coordinates = coordinates.filter_map(|acts| acts.prescribed.as_ref());
    let mut times = supports.chain(joints).chain(coordinates);
    times.find_map(|time| match time {
        Time::Input(name) => Some(name),
        _ => None,
    })
}
