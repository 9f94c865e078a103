//! The motion of a model file, step by step.

use crate::input::{DynamicPlan, Job, Plan};
use crate::probe::{Answers, Probe};
use crate::run::{first_warnings, initial_progress};
use nalgebra::Vector3;
use pullback_elements::model::Context;
use pullback_integrators::dynamics::{DynamicsError, Simulation, Snapshot, State};
use pullback_manifold::system::SystemError;
use std::collections::BTreeMap;

/// A motion of a model file, step by step, with its probes and inputs by name.
///
/// ```
/// use pullback::input::assemble_text;
/// use pullback::motion::Motion;
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let text = include_str!("../examples/models/pendulum.toml");
/// let mut motion = Motion::new(assemble_text("pendulum.toml", text)?)?;
/// while motion.step()? {
///     let angle = motion.probe("angle")?[0];
///     assert!(angle.is_finite());
/// }
/// # Ok(())
/// # }
/// ```
pub struct Motion {
    simulation: Simulation<Box<Context>>,
    probes: Vec<Probe>,
    inputs: Vec<String>,
    warnings: Vec<String>,
}

/// Why a motion cannot begin, or a name means nothing in it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// The motion cannot begin, or a step fails.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// The present state cannot be evaluated.
    #[error(transparent)]
    System(#[from] SystemError),
    /// The analysis is a static one.
    #[error("the model has no motion: give it [analysis.dynamic]")]
    Static,
    /// There is no such probe or input.
    #[error("there is no {what} named {name:?}; there are: {}", known.join(", "))]
    Unknown {
        /// Probe or input.
        what: &'static str,
        /// The name.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
}

/// The state of a motion, with all that the next step depends on.
#[derive(Clone)]
pub struct SavedMotion {
    snapshot: Snapshot<Context>,
    /// Last rotation vectors of the probes.
    memories: Vec<Vector3<f64>>,
}

impl Motion {
    /// The motion of a job at its start.
    ///
    /// # Errors
    /// [`MotionError::Static`], [`MotionError::Dynamics`].
    pub fn new(mut job: Job) -> Result<Self, MotionError> {
        let Plan::Dynamic(DynamicPlan { options, .. }) = job.plan else {
            return Err(MotionError::Static);
        };
        let start = initial_progress(&mut job, None)?;
        let warnings = first_warnings(&mut job, &start, &mut Vec::new());
        let context = Box::new(job.context);
        Ok(Self {
            simulation: Simulation::resume(context, start, &options)?,
            probes: job.probes,
            inputs: job.file.inputs.into_keys().collect(),
            warnings,
        })
    }

    /// Warnings about the model at its start.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Makes the next step; false at the end.
    ///
    /// # Errors
    /// [`MotionError::Dynamics`]; the motion is then at the last accepted step.
    pub fn step(&mut self) -> Result<bool, MotionError> {
        let stepped = self.simulation.step()?.is_some();
        for probe in &mut self.probes {
            probe.follow(self.simulation.system());
        }
        Ok(stepped)
    }

    /// Sets the size of the steps from the next one on.
    ///
    /// # Errors
    /// [`MotionError::Dynamics`] for a size that is none.
    pub fn set_step(&mut self, step: f64) -> Result<(), MotionError> {
        Ok(self.simulation.set_step(step)?)
    }

    /// The present state.
    pub fn state(&self) -> &State {
        self.simulation.state()
    }

    /// The model at the present state.
    pub fn context(&self) -> &Context {
        self.simulation.system()
    }

    /// Sets an input, from the next step on; see
    /// [`Simulation::set_input`](pullback_integrators::dynamics::Simulation::set_input).
    ///
    /// # Errors
    /// [`MotionError::Unknown`].
    pub fn set_input(&mut self, name: &str, value: f64) -> Result<(), MotionError> {
        let k = self.inputs.iter().position(|input| input == name);
        let k = k.ok_or_else(|| unknown("input", name, self.inputs.clone()))?;
        self.simulation.set_input(k, value);
        Ok(())
    }

    /// The present value of a probe: one number, or three.
    ///
    /// # Errors
    /// [`MotionError::Unknown`]; [`MotionError::System`] if the state cannot be evaluated.
    pub fn probe(&mut self, name: &str) -> Result<Vec<f64>, MotionError> {
        let k = self.probes.iter().position(|probe| probe.name() == name);
        let Some(k) = k else {
            let known = self.probes.iter().map(|probe| probe.name().to_owned());
            return Err(unknown("probe", name, known.collect()));
        };
        let answers = match self.probes[k].is_kinematic() {
            true => Answers::default(),
            false => {
                let progress = self.simulation.progress().clone();
                Answers::of_motion(self.simulation.system_mut(), &progress)?
            }
        };
        let mut values = Vec::with_capacity(3);
        self.probes[k].record(self.simulation.system(), &answers, &mut values);
        Ok(values)
    }

    /// The positions and rotation vectors of all frames at the present state, by name; global components.
    pub fn poses(&self) -> BTreeMap<&str, [[f64; 3]; 2]> {
        let context = self.context();
        let pose = |(id, name)| {
            let state = context.node_state(id);
            (name, [state.position.into(), state.psi.into()])
        };
        context.frames().map(pose).collect()
    }

    /// A copy of everything that the next step depends on.
    pub fn save(&self) -> SavedMotion {
        SavedMotion {
            snapshot: self.simulation.save(),
            memories: self.probes.iter().map(|probe| probe.continued).collect(),
        }
    }

    /// Goes back to a copy; the steps from there are the same to the last bit.
    ///
    /// # Errors
    /// [`MotionError::Dynamics`].
    pub fn restore(&mut self, saved: &SavedMotion) -> Result<(), MotionError> {
        self.simulation.restore(&saved.snapshot)?;
        for (probe, memory) in self.probes.iter_mut().zip(&saved.memories) {
            probe.continued = *memory;
        }
        Ok(())
    }
}

fn unknown(what: &'static str, name: &str, known: Vec<String>) -> MotionError {
    let name = name.to_owned();
    MotionError::Unknown { what, name, known }
}
