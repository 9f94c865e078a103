//! Probes of the file, resolved.

use super::assemble::Geometry;
use super::file::{Probe as Described, ProbeQuantity};
use super::names::{Names, distinct};
use super::{InputError, Problem, Text};
use crate::output::{COLUMNS, DYNAMIC_COLUMNS, STATIC_COLUMNS};
use crate::probe::{Component, Probe, Target};
use pullback_elements::model::{Context, ElementId, NodeId};
use std::collections::HashSet;

pub(super) fn resolve(
    source: &Text<'_>,
    context: &Context,
    nodes: &Names<NodeId>,
    released: &Names<NodeId>,
    geometry: &Geometry,
    described: &[Described],
) -> Result<Vec<Probe>, InputError> {
    distinct(
        source,
        "probes",
        "probe",
        described.iter().map(|p| p.name.as_str()),
    )?;
    let mut elements = Names::new("element");
    for line in &geometry.lines {
        for (e, &id) in line.elements.iter().enumerate() {
            elements.add(format!("{}:{}", line.name, e + 1), id);
        }
    }
    let names = Known {
        nodes,
        released,
        elements: &elements,
        supports: &geometry.supports.iter().copied().collect(),
    };
    let mut columns: HashSet<String> = (COLUMNS
        .iter()
        .chain(&DYNAMIC_COLUMNS)
        .chain(&STATIC_COLUMNS))
    .map(|&column| column.to_owned())
    .collect();
    let mut out = Vec::with_capacity(described.len());
    for (k, probe) in described.iter().enumerate() {
        let made = one(source, context, &names, k, probe)?;
        for column in made.columns() {
            if !columns.insert(column.clone()) {
                let path = ["probes", &k.to_string(), "name"];
                return Err(source.value(&path, Problem::Column { column }));
            }
        }
        out.push(made);
    }
    Ok(out)
}

/// The objects that probes refer to.
struct Known<'a> {
    nodes: &'a Names<NodeId>,
    released: &'a Names<NodeId>,
    elements: &'a Names<ElementId>,
    supports: &'a HashSet<NodeId>,
}

fn one(
    source: &Text<'_>,
    context: &Context,
    names: &Known<'_>,
    k: usize,
    probe: &Described,
) -> Result<Probe, InputError> {
    let index = k.to_string();
    let path = |key: &'static str| ["probes", index.as_str(), key];
    let quantity = probe.quantity;
    let needs = quantity.needs();
    let wrong_target = || {
        let problem = Problem::ProbeTarget {
            probe: probe.name.clone(),
            quantity: quantity.key(),
            needs,
        };
        source.value(&path("quantity"), problem)
    };
    let joint = matches!(
        quantity,
        ProbeQuantity::joint_force | ProbeQuantity::joint_moment
    );
    // The frame of a joint has the joint's name.
    let (key, node, released) = match (&probe.node, &probe.joint) {
        (None, frame) if joint => ("joint", frame, &None),
        (node, released) => ("node", node, released),
    };
    let target = match (needs, node, &probe.element, released) {
        (ProbeQuantity::NODE | ProbeQuantity::FRAME, Some(name), None, None) => {
            let node = names.nodes.find(source, &path(key), name)?;
            let reaction = matches!(
                quantity,
                ProbeQuantity::reaction_force | ProbeQuantity::reaction_moment
            );
            if reaction && !names.supports.contains(&node) {
                let node = name.clone();
                return Err(source.value(&path("node"), Problem::NoReaction { node }));
            }
            if joint && context.is_own(node) {
                let node = name.clone();
                return Err(source.value(&path(key), Problem::NoJoint { node }));
            }
            Target::Node(node, name.clone())
        }
        (ProbeQuantity::ELEMENT, None, Some(name), None) => {
            Target::Element(names.elements.find(source, &path("element"), name)?)
        }
        (ProbeQuantity::JOINT, None, None, Some(name)) => {
            Target::Joint(names.released.find(source, &path("joint"), name)?)
        }
        (ProbeQuantity::NOTHING | ProbeQuantity::SPACE, None, None, None) => Target::Whole,
        _ => return Err(wrong_target()),
    };
    let (names, expected): ([&str; 3], _) = match target {
        Target::Whole if needs == ProbeQuantity::SPACE => {
            (["x", "y", "z"], "\"x\", \"y\", \"z\" or \"norm\"")
        }
        Target::Whole | Target::Joint(_) => ([""; 3], "no component"),
        Target::Node(..) => (["x", "y", "z"], "\"x\", \"y\", \"z\" or \"norm\""),
        Target::Element(_) => (["1", "2", "3"], "\"1\", \"2\", \"3\" or \"norm\""),
    };
    let component = match probe.component.as_deref() {
        None if names[0].is_empty() => Some(Component::Whole),
        None => Some(Component::All(names)),
        Some(_) if names[0].is_empty() => None,
        Some("norm") => Some(Component::Norm),
        Some(given) => (0..3).find(|&i| names[i] == given).map(Component::One),
    };
    let component = component.ok_or_else(|| {
        let problem = Problem::ProbeComponent {
            component: probe.component.clone().unwrap_or_default(),
            quantity: quantity.key(),
            expected,
        };
        source.value(&path("component"), problem)
    })?;
    Ok(Probe::new(&probe.name, quantity, target, component))
}

impl ProbeQuantity {
    const NODE: &'static str = "a node (and no element)";
    const FRAME: &'static str = "a joint, or the node that is attached to one (and no element)";
    const ELEMENT: &'static str = "an element such as \"line:1\" (and no node)";
    const JOINT: &'static str = "a joint (and neither node nor element)";
    const NOTHING: &'static str = "neither node nor element";
    const SPACE: &'static str = "neither node nor element nor joint";

    /// The object that a probe of it refers to.
    fn needs(self) -> &'static str {
        match self {
            Self::displacement
            | Self::position
            | Self::rotation
            | Self::chart_rotation
            | Self::velocity
            | Self::angular_velocity
            | Self::acceleration
            | Self::angular_acceleration
            | Self::reaction_force
            | Self::reaction_moment => Self::NODE,
            Self::joint_force | Self::joint_moment => Self::FRAME,
            Self::N | Self::M | Self::Gamma | Self::K => Self::ELEMENT,
            Self::joint_coordinate | Self::joint_rate | Self::joint_acceleration => Self::JOINT,
            Self::momentum | Self::angular_momentum => Self::SPACE,
            Self::strain_energy
            | Self::kinetic_energy
            | Self::total_energy
            | Self::energy_defect => Self::NOTHING,
        }
    }

    /// Its name in the file.
    pub fn key(self) -> &'static str {
        self.words()[0]
    }

    /// Label of an axis of a figure.
    pub fn axis(self) -> &'static str {
        self.words()[1]
    }

    fn words(self) -> [&'static str; 2] {
        match self {
            Self::displacement => ["displacement", "displacement d"],
            Self::position => ["position", "position"],
            Self::rotation => ["rotation", "rotation vector Ψ [rad]"],
            Self::chart_rotation => ["chart_rotation", "rotation vector Ψ in its chart [rad]"],
            Self::velocity => ["velocity", "velocity"],
            Self::angular_velocity => ["angular_velocity", "angular velocity ω"],
            Self::acceleration => ["acceleration", "acceleration"],
            Self::angular_acceleration => ["angular_acceleration", "angular acceleration ω̇"],
            Self::joint_coordinate => ["joint_coordinate", "joint coordinate"],
            Self::joint_rate => ["joint_rate", "rate of joint coordinate"],
            Self::joint_acceleration => ["joint_acceleration", "acceleration of joint coordinate"],
            Self::joint_force => ["joint_force", "force in joint"],
            Self::joint_moment => ["joint_moment", "moment in joint"],
            Self::reaction_force => ["reaction_force", "reaction force"],
            Self::reaction_moment => ["reaction_moment", "reaction moment"],
            Self::N => ["N", "forces N"],
            Self::M => ["M", "moments M"],
            Self::Gamma => ["Gamma", "strains Γ"],
            Self::K => ["K", "curvatures K"],
            Self::strain_energy => ["strain_energy", "strain energy"],
            Self::kinetic_energy => ["kinetic_energy", "kinetic energy"],
            Self::total_energy => ["total_energy", "total energy"],
            Self::energy_defect => ["energy_defect", "energy defect"],
            Self::momentum => ["momentum", "linear momentum"],
            Self::angular_momentum => ["angular_momentum", "angular momentum"],
        }
    }

    /// Whether it is defined in dynamics only.
    pub fn is_dynamic(self) -> bool {
        matches!(
            self,
            Self::velocity
                | Self::angular_velocity
                | Self::acceleration
                | Self::angular_acceleration
                | Self::joint_rate
                | Self::joint_acceleration
                | Self::kinetic_energy
                | Self::total_energy
                | Self::energy_defect
                | Self::momentum
                | Self::angular_momentum
        )
    }
}
