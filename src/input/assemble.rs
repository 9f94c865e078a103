//! Assembles the whole model: names, references, and the order of construction.

use super::file::{Analysis, Joint, ModelFile, Output};
use super::initial::Start;
use super::names::{Names, check_names, usable_name};
use super::registry::Registry;
use super::settings::Plan;
use super::{InputError, Problem, Text, bodies, initial, loads, parts, probes, sections, settings};
use crate::probe::Probe;
use nalgebra::{Matrix3, Vector3};
use pullback_elements::beam::Interpolation;
use pullback_elements::model::{Context, ElementId, Formulation, ModelBuilder, ModelError, NodeId};
use std::collections::BTreeMap;

/// What a model file describes, ready to run.
pub struct Job {
    /// Title, if the file has one.
    pub title: Option<String>,
    /// The model at its start.
    pub context: Context,
    /// Initial state of a dynamic analysis.
    pub start: Start,
    /// What to compute.
    pub plan: Plan,
    /// What to record.
    pub probes: Vec<Probe>,
    /// Lines and supports, for figures and ParaView.
    pub geometry: Geometry,
    /// What to write.
    pub output: Output,
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
    source: &Text<'_>,
    registry: &Registry,
    mut file: ModelFile,
    formulation: Option<Formulation>,
) -> Result<Job, InputError> {
    check_contents(source, &file)?;
    let mut made = BTreeMap::new();
    for (name, described) in &file.sections {
        made.insert(name.clone(), sections::section(source, name, described)?);
    }
    let mut builder = ModelBuilder::new();
    // An unknown scheme is refused at its position in the file, when the analysis is read.
    let own = match &file.analysis {
        Analysis::Dynamic(d) => d.scheme.method().ok().map(|m| m.formulation()),
        _ => None,
    };
    let formulation = formulation.or(own).unwrap_or_default();
    builder.formulate(formulation);
    let mut nodes = add_nodes(source, &mut builder, &file)?;
    check_names(source, &file)?;
    let parts = parts::make(source, registry, &mut builder, &mut nodes, &made, &file)?;
    let mut geometry = Geometry {
        lines: parts.lines,
        ..Geometry::default()
    };
    let bodies = bodies::bodies(source, &mut builder, &nodes, &file)?;
    geometry.bodies = (bodies.iter().zip(&file.bodies))
        .map(|(made, body)| BodyGeometry {
            node: made.node,
            center: body.center.unwrap_or_default().into(),
        })
        .collect();
    geometry.links = links(&file, &nodes).collect();
    bodies::springs(source, &mut builder, &nodes, &file)?;
    geometry.supports = loads::support(source, &mut builder, &nodes, &file)?;
    let loaded = loads::Loaded {
        lines: &geometry.lines,
        bodies: &bodies,
        sections: &made,
    };
    loads::apply(source, &mut builder, &nodes, &loaded, &file)?;
    let dynamic = matches!(file.analysis, Analysis::Dynamic(_));
    let model = builder
        .build()
        .and_then(|model| {
            // A structure without supports is allowed in dynamics.
            if !dynamic {
                model.check_supports()?;
            }
            Ok(model)
        })
        .map_err(|error| locate(source, &file, error))?;
    if formulation != Formulation::Total && model.increments() == 0 {
        let message = "no rotation in this model is free as a whole, so that all formulations of \
                       rotations are the same: take the scheme without the prefix"
            .to_owned();
        return Err(source.value(
            &["analysis", "dynamic", "scheme"],
            Problem::Scheme { message },
        ));
    }
    let plan = settings::plan(source, &model, &nodes, &file.analysis)?;
    let scale = file.output.deformation_scale;
    source.positive(&["output"], "deformation_scale", scale)?;
    settings::fill_in(&plan, &mut file.analysis);
    if !dynamic {
        check_statics(source, &file)?;
    }
    let mut context = Context::new(model);
    let start = initial::start(
        source,
        &mut context,
        &nodes,
        &parts.released,
        &geometry.lines,
        &file,
    )?;
    if let Some(k) = (file.probes.iter()).position(|p| p.quantity.is_dynamic() && !dynamic) {
        let probe = &file.probes[k];
        let problem = Problem::DynamicProbe {
            probe: probe.name.clone(),
            quantity: probe.quantity.key(),
        };
        return Err(source.value(&["probes", &k.to_string(), "quantity"], problem));
    }
    let probes = probes::resolve(
        source,
        &context,
        &nodes,
        &parts.released,
        &geometry,
        &file.probes,
    )?;
    Ok(Job {
        start,
        title: file.title.clone(),
        context,
        plan,
        probes,
        geometry,
        output: file.output,
        file,
    })
}

/// Checks that a file has nodes and elements, and a title of one line if any.
fn check_contents(source: &Text<'_>, file: &ModelFile) -> Result<(), InputError> {
    let elements = file.lines.is_empty() && file.bodies.is_empty() && file.springs.is_empty();
    for (what, missing) in [
        ("nodes", file.nodes.is_empty()),
        ("lines, bodies or springs", elements),
    ] {
        if missing {
            return Err(InputError::whole(Problem::Missing { what }));
        }
    }
    if let Some(title) = file.title.as_ref().filter(|t| t.contains(char::is_control)) {
        let (what, name) = ("title", title.clone());
        return Err(source.value(&["title"], Problem::Name { what, name }));
    }
    Ok(())
}

/// Refuses initial conditions in statics.
fn check_statics(source: &Text<'_>, file: &ModelFile) -> Result<(), InputError> {
    if !file.initial.is_empty() {
        return Err(source.value(&["initial", "0"], Problem::InitialStatics));
    }
    let moving = |j: &Joint| {
        let mut acts = j.all_acts();
        acts.any(|(_, a)| a.rate.is_some() || a.value.is_some())
    };
    if let Some(k) = file.joints.iter().position(moving) {
        let path = ["joints", &k.to_string(), "name"];
        return Err(source.value(&path, Problem::InitialStatics));
    }
    Ok(())
}

/// The ends of rigid links and springs.
fn links<'a>(
    file: &'a ModelFile,
    nodes: &'a Names<NodeId>,
) -> impl Iterator<Item = [NodeId; 2]> + 'a {
    let links = file.joints.iter().filter_map(|joint| {
        joint.keys.get("position")?;
        Some([joint.parent.as_ref()?, &joint.name])
    });
    let springs = file.springs.iter().map(|spring| spring.nodes.each_ref());
    let ends = links.chain(springs);
    ends.filter_map(|[a, b]| Some([nodes.get(a)?, nodes.get(b)?]))
}

/// Adds the nodes in the order in which the file names them.
fn add_nodes(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    file: &ModelFile,
) -> Result<Names<NodeId>, InputError> {
    let mut order: Vec<(&String, &[f64; 3])> = file.nodes.iter().collect();
    order.sort_by_key(|(name, _)| source.positions.key(&["nodes", name]).map(|s| s.start));
    let mut nodes = Names::new("node");
    for (name, &position) in order {
        let path = ["nodes", name.as_str()];
        if !usable_name(name) {
            let (what, name) = ("node", name.clone());
            return Err(source.key(&path, Problem::Name { what, name }));
        }
        let id = builder
            .node(name.clone(), position)
            .map_err(|error| source.value(&path, Problem::Model(error)))?;
        nodes.add(name.clone(), id);
    }
    Ok(nodes)
}

/// Position of a problem of the whole model: the node, or the line it lies in.
pub(super) fn locate(source: &Text<'_>, file: &ModelFile, error: ModelError) -> InputError {
    let node = match &error {
        ModelError::Unconnected { node } | ModelError::Unsupported { node, .. } => node.clone(),
        ModelError::Apart { joint, .. }
        | ModelError::LooseLoop { joint, .. }
        | ModelError::OwnParent { joint, .. }
        | ModelError::Rigid { joint, .. }
        | ModelError::Unclosed { joint, .. } => joint.clone(),
        ModelError::FarStart { coordinate, .. } => coordinate.clone(),
        ModelError::Loop { joints, .. }
        | ModelError::AllPrescribed { joints, .. }
        | ModelError::LockedLoop { joints } => {
            let first = joints.split(", ").next();
            first.unwrap_or_default().to_owned()
        }
        ModelError::PrescribedSlave { coordinate, .. }
        | ModelError::PrescribedSolved { coordinate, .. } => {
            // The cause: prescribed motion of the joint, or a support of the node.
            let name = coordinate.strip_prefix("node ").unwrap_or(coordinate);
            let name = name.split(", ").next().unwrap_or_default().to_owned();
            let prescribed = |j: &Joint| j.names(&name) && j.prescribed.is_some();
            let path = match file.joints.iter().position(prescribed) {
                Some(k) => Some(["joints".to_owned(), k.to_string(), "prescribed".to_owned()]),
                None => (file.supports.iter().position(|s| s.node == name))
                    .map(|k| ["supports".to_owned(), k.to_string(), "node".to_owned()]),
            };
            if let Some(path) = path {
                let path = path.each_ref().map(String::as_str);
                return source.value(&path, Problem::Model(error));
            }
            name
        }
        _ => String::new(),
    };
    let line = node.split('/').next().and_then(|name| {
        let k = file.lines.iter().position(|l| l.name == name)?;
        node.contains('/').then(|| k.to_string())
    });
    let problem = Problem::Model(error);
    if let Some(k) = file.joints.iter().position(|j| j.names(&node)) {
        return source.value(&["joints", &k.to_string(), "name"], problem);
    }
    match line {
        Some(k) => source.value(&["lines", &k, "name"], problem),
        None => source.key(&["nodes", &node], problem),
    }
}
