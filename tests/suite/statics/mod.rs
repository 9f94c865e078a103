//! Equilibria and their stability.

mod convergence;
mod corrections;
mod critical;
mod energies;
mod equilibrium;
mod imperfections;
mod pieces;
mod program;
mod stability;
mod units;

use crate::support::prelude::*;

/// The model of a text at the end of its loads; each step is seen.
fn solved(text: &str, see: &mut dyn FnMut(&Step<'_>)) -> Result<Context, StaticsError> {
    let mut job = assemble_text("model.toml", text).expect("a model");
    let (context, mut q) = (&mut job.context, vec![]);
    let mut observe = |_: &mut Context, step: &Step<'_>| {
        see(step);
        ControlFlow::Continue(())
    };
    let done = match &job.plan {
        Plan::Static(options) => solve_statics(context, &mut q, options, &mut observe)?,
        Plan::Path(options, _) => trace_path(context, &mut q, options, &mut observe)?,
        _ => unreachable!("a motion"),
    };
    assert!(done.finished);
    Ok(job.context)
}
