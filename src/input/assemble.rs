//! Assembles the whole model: names, references, and the order of construction.

use super::eigenvalues::{self, EigenvaluePlan};
use super::file::{Analysis, Joint, ModelFile};
use super::initial::Start;
use super::joints::Registry;
use super::parts::Assembly;
use super::settings::Plan;
use super::{InputError, InputProblem, Location, initial, probes, settings};
use crate::probe::Probe;
use nalgebra::{Matrix3, Vector3};
use pullback_elements::beam::Interpolation;
use pullback_elements::joint::JointNodes;
use pullback_elements::model::{Context, ElementId, Formulation, ModelError, NodeId};

/// A model and its analysis as a model file describes them, ready to run.
pub struct Job {
    /// The model at its start.
    pub context: Context,
    /// Initial state of a dynamic analysis.
    pub start: Start,
    /// The analysis.
    pub plan: Plan,
    /// What to find at its end.
    pub eigenvalues: Option<EigenvaluePlan>,
    /// The quantities to record.
    pub probes: Vec<Probe>,
    /// Nodes of the joints, in the order of the file.
    pub joints: Vec<JointNodes>,
    /// Lines and supports, for figures and ParaView.
    pub geometry: Geometry,
    /// The file, with all defaults filled in.
    pub file: ModelFile,
}

/// Geometry of lines, supports, bodies and links.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    /// Lines in the order of the file.
    pub lines: Vec<LineGeometry>,
    /// Nodes with a support.
    pub supports: Vec<NodeId>,
    /// Bodies in the order of the file.
    pub bodies: Vec<BodyGeometry>,
    /// Rigid links and springs, from node to node.
    pub links: Vec<[NodeId; 2]>,
}

/// A rigid body or point mass.
#[derive(Clone, Copy, Debug)]
pub struct BodyGeometry {
    /// Node that moves with it.
    pub node: NodeId,
    /// Position of its centre of mass as seen from the node, in the reference configuration.
    pub center: Vector3<f64>,
}

/// A line of elements.
#[derive(Clone, Debug)]
pub struct LineGeometry {
    /// Name.
    pub name: String,
    /// Order of the elements.
    pub order: usize,
    /// Interpolation of their rotations.
    pub interpolation: Interpolation,
    /// Nodes from start to end.
    pub nodes: Vec<NodeId>,
    /// Reference orientation (columns E₁, E₂, E₃) at each node.
    pub frames: Vec<Matrix3<f64>>,
    /// Mass and first moment at each node of each element, where the mass centre is off the axis.
    pub carried: Vec<Vec<(f64, Vector3<f64>)>>,
    /// Elements from start to end.
    pub elements: Vec<ElementId>,
}

/// Assembles a file, in a formulation of rotations other than its own if one is given.
pub(super) fn assemble(
    at: &Location<'_>,
    registry: &Registry,
    mut file: ModelFile,
    formulation: Option<Formulation>,
) -> Result<Job, InputError> {
    check_contents(at, &file)?;
    let mut assembly = Assembly::new(at, &file);
    // An unknown scheme is refused at its position in the file, when the analysis is read.
    let own = match file.analysis.stepwise() {
        Some(Analysis::Dynamic(d)) => d.scheme.method().ok().map(|m| m.formulation()),
        _ => None,
    };
    let formulation = formulation.or(own).unwrap_or_default();
    assembly.builder.formulate(formulation);
    assembly.add_parts(registry)?;
    let model = std::mem::take(&mut assembly.builder).build();
    let model = model.map_err(|error| assembly.locate(error))?;
    let dynamic = file.analysis.is_dynamic();
    if formulation != Formulation::Total && model.increments() == 0 {
        let message = "no rotation in this model is free as a whole, so that all formulations of \
                       rotations are the same: take the scheme without the prefix"
            .to_owned();
        let scheme = settings::location(at.at("analysis"), &file.analysis)
            .at("dynamic")
            .at("scheme");
        return Err(scheme.refuse(InputProblem::Scheme { message }));
    }
    let plan = settings::plan(&assembly, &model)?;
    let eigenvalues = eigenvalues::plan(&assembly)?;
    let scale = file.output.deformation_scale;
    at.at("output").positive("deformation_scale", scale)?;
    if !dynamic {
        check_statics(at, &file)?;
    }
    let mut context = Context::new(model);
    let start = initial::start(&assembly, &mut context)?;
    // Velocities and accelerations are outputs of linear equations about an equilibrium.
    let moves = dynamic || matches!(file.analysis, Analysis::Modes(_) | Analysis::Campbell(_));
    let probes = probes::resolve(&assembly, &context, moves)?;
    let (joints, geometry) = (assembly.joints, assembly.geometry);
    settings::fill_in(&plan, &mut file.analysis);
    Ok(Job {
        start,
        context,
        plan,
        eigenvalues,
        probes,
        joints: joints.into_iter().flatten().collect(),
        geometry,
        file,
    })
}

/// Checks that a file has nodes and elements, and a title of one line if any.
fn check_contents(at: &Location<'_>, file: &ModelFile) -> Result<(), InputError> {
    let acting = |joint: &Joint| joint.acts_any(|a| a.spring.is_some());
    let elements = file.lines.is_empty() && file.bodies.is_empty() && file.springs.is_empty();
    let elements = elements && !file.joints.iter().any(acting);
    for (what, missing) in [
        ("nodes", file.nodes.is_empty()),
        ("lines, bodies or springs", elements),
    ] {
        if missing {
            return Err(InputError::whole(InputProblem::Missing { what }));
        }
    }
    if let Some(title) = file.title.as_ref().filter(|t| t.contains(char::is_control)) {
        let (what, name) = ("title", title.clone());
        return Err(at.at("title").refuse(InputProblem::Name { what, name }));
    }
    Ok(())
}

/// Refuses initial conditions in statics.
fn check_statics(at: &Location<'_>, file: &ModelFile) -> Result<(), InputError> {
    if !file.initial.is_empty() {
        return Err(at.at("initial").at(0).refuse(InputProblem::InitialStatics));
    }
    let moving = |j: &Joint| j.acts_any(|a| a.rate.is_some() || a.value.is_some());
    if let Some(k) = file.joints.iter().position(moving) {
        let name = at.at("joints").at(k).at("name");
        return Err(name.refuse(InputProblem::InitialStatics));
    }
    Ok(())
}

impl Assembly<'_> {
    /// Refuses a model as a whole: at the node, line or joint that the error is about.
    pub(super) fn locate(&self, error: ModelError) -> InputError {
        let Some(node) = error.node() else {
            return self.at("nodes").refuse_key(error);
        };
        let file = self.file;
        let has = |joint: &JointNodes| joint.frame == node || joint.coordinates.contains(&node);
        let mut joints = self.joints.iter();
        let joint = joints.position(|joint| joint.as_ref().is_some_and(has));
        if let ModelError::PrescribedDependent { .. } | ModelError::PrescribedSolved { .. } = error
        {
            // The cause: prescribed motion of the joint, or a support of the node.
            if let Some(k) = joint.filter(|&k| file.joints[k].prescribed.is_some()) {
                return self.at("joints").at(k).at("prescribed").refuse(error);
            }
            let mut supports = file.supports.iter();
            if let Some(k) = supports.position(|s| self.nodes.get(&s.node) == Some(node)) {
                return self.at("supports").at(k).at("node").refuse(error);
            }
        }
        if let Some(k) = joint {
            return self.at("joints").at(k).at("name").refuse(error);
        }
        let inner = |line: &LineGeometry| line.nodes[1..line.nodes.len() - 1].contains(&node);
        if let Some(k) = self.geometry.lines.iter().position(inner) {
            return self.at("lines").at(k).at("name").refuse(error);
        }
        let name = self
            .nodes
            .iter()
            .find(|name| self.nodes.get(name) == Some(node));
        let at = self.at("nodes").at(name.map_or("", String::as_str));
        at.refuse_key(error)
    }
}
