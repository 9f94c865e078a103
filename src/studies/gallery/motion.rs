//! Runs in time: the states of watched nodes at all steps.

use super::case::{CaseProblem, CaseReport, find, largest};
use crate::input::{self, ModelFile, Plan};
use crate::probe::continue_rotation;
use nalgebra::Vector3;
use pullback_elements::model::{Context, EnergiesAndMomentum, NodeId, NodeState};
use pullback_integrators::dynamics::{DynamicsError, Simulation, Summary};

/// A motion at its steps, the start included.
pub(super) struct History {
    /// Times.
    pub t: Vec<f64>,
    /// States of the watched nodes: those of one node at all times together.
    pub nodes: Vec<Vec<NodeState>>,
    /// Energies and momenta.
    pub balances: Vec<EnergiesAndMomentum>,
    /// Statistics of the integrator.
    pub summary: Summary,
}

impl History {
    /// A quantity of a watched node over time.
    pub fn curve(&self, node: usize, of: impl Fn(&NodeState) -> f64) -> Vec<(f64, f64)> {
        let values = self.nodes[node].iter().map(of);
        self.t.iter().copied().zip(values).collect()
    }

    /// The path of a watched node, by two of its coordinates.
    pub fn path(&self, node: usize, [x, y]: [usize; 2]) -> Vec<(f64, f64)> {
        let positions = self.nodes[node].iter().map(|s| s.position);
        positions.map(|p| (p[x], p[y])).collect()
    }

    /// State of a watched node at the step nearest to a time.
    pub fn at(&self, node: usize, t: f64) -> &NodeState {
        let nearest = |k: &usize| (self.t[*k] - t).abs();
        let k = (0..self.t.len()).min_by(|a, b| nearest(a).total_cmp(&nearest(b)));
        &self.nodes[node][k.unwrap_or(0)]
    }

    /// The largest kinetic energy.
    pub fn largest_kinetic(&self) -> f64 {
        largest(self.balances.iter().map(|a| a.energies.kinetic))
    }

    /// Largest change of the total energy over the largest kinetic energy.
    pub fn energy_error(&self) -> f64 {
        let energy = self.total_energy();
        largest(energy.iter().map(|e| e.1 - energy[0].1)) / self.largest_kinetic()
    }

    /// Kinetic and strain energy and the potential of the loads.
    pub fn total_energy(&self) -> Vec<(f64, f64)> {
        let total =
            |a: &EnergiesAndMomentum| a.energies.kinetic + a.energies.stored + a.load_potential;
        let values = self.balances.iter().map(total);
        self.t.iter().copied().zip(values).collect()
    }
}

impl CaseReport {
    /// Integrates a model file and records the named nodes.
    pub(super) fn motion(&self, file: &ModelFile, nodes: &[&str]) -> Result<History, CaseProblem> {
        let (mut run, nodes) = self.begin(file, nodes)?;
        let mut history = History {
            t: Vec::new(),
            nodes: vec![Vec::new(); nodes.len()],
            balances: Vec::new(),
            summary: Summary::default(),
        };
        loop {
            let state = run.state().clone();
            let balance = run.system_mut().energies_and_momentum(state.point());
            let failed = |source| DynamicsError::System { t: state.t, source };
            history.t.push(state.t);
            history.balances.push(balance.map_err(failed)?);
            for (states, &node) in history.nodes.iter_mut().zip(&nodes) {
                states.push(run.system().node_state(node));
            }
            if run.step()?.is_none() {
                break;
            }
        }
        history.summary = run.progress().summary;
        Ok(history)
    }

    /// Integrates each of some model files.
    pub(super) fn motions<const N: usize>(
        &self,
        files: [ModelFile; N],
        nodes: &[&str],
    ) -> Result<[History; N], CaseProblem> {
        let runs = files.iter().map(|file| self.motion(file, nodes));
        let runs: Vec<History> = runs.collect::<Result<_, _>>()?;
        (runs.try_into()).map_err(|_| CaseProblem::Setup("it has another number of runs"))
    }

    /// Builds a model file, finds the named nodes, and starts its motion.
    pub(super) fn begin(
        &self,
        file: &ModelFile,
        nodes: &[&str],
    ) -> Result<(Simulation<Box<Context>>, Vec<NodeId>), CaseProblem> {
        let job = input::job(self.case, file, None).map_err(Box::new)?;
        let Plan::Dynamic(plan) = job.plan else {
            return Err(CaseProblem::Setup("its analysis is not dynamic"));
        };
        let nodes = nodes.iter().map(|&node| find(&job.context, node));
        let nodes = nodes.collect::<Result<_, _>>()?;
        let start = job.start.motion(&job.context)?;
        let run = Simulation::resume(Box::new(job.context), start, &plan.options)?;
        Ok((run, nodes))
    }
}

/// The rotation vectors of a node from step to step, any number of turns.
pub(super) fn continued(states: &[NodeState]) -> Vec<Vector3<f64>> {
    let turns = states.iter().scan(Vector3::zeros(), |before, state| {
        *before = continue_rotation(before, &state.psi);
        Some(*before)
    });
    turns.collect()
}

/// Value of order two in the step from those with steps h and h/2.
pub(super) fn richardson<const N: usize>(coarse: [f64; N], fine: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| fine[k] + (fine[k] - coarse[k]) / 3.0)
}

/// Observed order from values with steps h, h/2 and h/4.
pub(super) fn observed_order(values: &[Vector3<f64>; 3]) -> f64 {
    let [a, b, c] = values;
    ((a - b).norm() / (b - c).norm()).log2()
}
