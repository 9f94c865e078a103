//! Probes of the file, resolved.

use super::file::{self, Dimension, ProbeQuantity};
use super::names::{Names, distinct};
use super::parts::Assembly;
use super::{InputError, InputProblem, Location};
use crate::output::{COLUMNS, DYNAMIC_COLUMNS, STATIC_COLUMNS};
use crate::probe::{Probe, ProbeComponent, Target};
use pullback_elements::model::{Context, ElementId};
use std::collections::HashSet;

/// The probes of a file; `moves` says whether they may record velocities and accelerations.
pub(super) fn resolve(
    assembly: &Assembly<'_>,
    context: &Context,
    moves: bool,
) -> Result<Vec<Probe>, InputError> {
    let probes = &assembly.file.probes;
    let at = |(k, probe)| (assembly.at("probes").at(k), probe);
    let all = || probes.iter().enumerate().map(at);
    let unusable = |(_, p): &(_, &file::Probe)| p.quantity.is_dynamic() && !moves;
    if let Some((at, probe)) = all().find(unusable) {
        return Err(at.at("quantity").refuse(InputProblem::DynamicProbe {
            probe: probe.name.clone(),
            quantity: probe.quantity.key(),
        }));
    }
    distinct(assembly, "probes", "probe", probes.iter().map(|p| &p.name))?;
    let elements = assembly.geometry.lines.iter().flat_map(|line| {
        let named = |(id, e): (&ElementId, usize)| (format!("{}:{e}", line.name), *id);
        line.elements.iter().zip(1..).map(named)
    });
    let elements = Names::of("element", elements);
    let columns = COLUMNS
        .iter()
        .chain(&DYNAMIC_COLUMNS)
        .chain(&STATIC_COLUMNS);
    let mut columns: HashSet<String> = columns.map(|&column| column.to_owned()).collect();
    let mut out = Vec::with_capacity(probes.len());
    for (at, probe) in all() {
        let target = target(&at, context, assembly, &elements, probe)?;
        let component = component(&at, &target, probe)?;
        let made = Probe::new(&probe.name, probe.quantity, target, component);
        let mut own = made.columns();
        if own.len() > 1 {
            // Programs find the three of a vector by its name.
            own.push(probe.name.clone());
        }
        for column in own {
            if !columns.insert(column.clone()) {
                return Err(at.at("name").refuse(InputProblem::Column { column }));
            }
        }
        out.push(made);
    }
    Ok(out)
}

/// The object of a probe.
fn target(
    at: &Location<'_>,
    context: &Context,
    assembly: &Assembly<'_>,
    elements: &Names<ElementId>,
    probe: &file::Probe,
) -> Result<Target, InputError> {
    use ProbeQuantity::{joint_force, joint_moment, reaction_force, reaction_moment};
    let quantity = probe.quantity;
    let needs = quantity.needs();
    let joint = matches!(quantity, joint_force | joint_moment);
    // The frame of a joint has the joint's name.
    let (key, node, released) = match (&probe.node, &probe.joint) {
        (None, frame) if joint => ("joint", frame, &None),
        (node, released) => ("node", node, released),
    };
    Ok(match (needs, node, &probe.element, released) {
        (ProbeQuantity::NODE | ProbeQuantity::FRAME, Some(name), None, None) => {
            let at = at.at(key);
            let node = assembly.nodes.find(&at, name)?;
            let reaction = matches!(quantity, reaction_force | reaction_moment);
            if reaction && !assembly.geometry.supports.contains(&node) {
                let node = name.clone();
                return Err(at.refuse(InputProblem::NoReaction { node }));
            }
            if joint && context.is_own(node) {
                let node = name.clone();
                return Err(at.refuse(InputProblem::NoJoint { node }));
            }
            Target::Node(node)
        }
        (ProbeQuantity::ELEMENT, None, Some(name), None) => {
            Target::Element(elements.find(&at.at("element"), name)?)
        }
        (ProbeQuantity::JOINT, None, None, Some(name)) => {
            let node = assembly.joint_coordinates.find(&at.at("joint"), name)?;
            let quantity = context.node(node).quantities()[0];
            Target::Joint(node, quantity)
        }
        (ProbeQuantity::NOTHING | ProbeQuantity::SPACE, None, None, None) => Target::Whole,
        _ => {
            return Err(at.at("quantity").refuse(InputProblem::ProbeTarget {
                probe: probe.name.clone(),
                quantity: quantity.key(),
                needs,
            }));
        }
    })
}

/// The component of a probe.
fn component(
    at: &Location<'_>,
    target: &Target,
    probe: &file::Probe,
) -> Result<ProbeComponent, InputError> {
    let space = probe.quantity.needs() == ProbeQuantity::SPACE;
    let (names, expected) = match target {
        Target::Element(_) => (["1", "2", "3"], "\"1\", \"2\", \"3\" or \"norm\""),
        Target::Joint(..) => ([""; 3], "no component"),
        Target::Whole if !space => ([""; 3], "no component"),
        Target::Node(..) | Target::Whole => (["x", "y", "z"], "\"x\", \"y\", \"z\" or \"norm\""),
    };
    let component = match probe.component.as_deref() {
        None if names[0].is_empty() => Some(ProbeComponent::One(0)),
        None => Some(ProbeComponent::All(names)),
        Some(_) if names[0].is_empty() => None,
        Some("norm") => Some(ProbeComponent::Norm),
        Some(given) => (0..3).find(|&i| names[i] == given).map(ProbeComponent::One),
    };
    component.ok_or_else(|| {
        at.at("component").refuse(InputProblem::ProbeComponent {
            component: probe.component.clone().unwrap_or_default(),
            quantity: probe.quantity.key(),
            expected,
        })
    })
}

impl ProbeQuantity {
    const NODE: &'static str = "a node (and no element)";
    const FRAME: &'static str = "a joint, or the node that is attached to one (and no element)";
    const ELEMENT: &'static str = "an element such as \"line:1\" (and no node)";
    const JOINT: &'static str = "a joint (and neither node nor element)";
    const NOTHING: &'static str = "neither node nor element";
    const SPACE: &'static str = "neither node nor element nor joint";

    /// Its name in the file.
    pub fn key(self) -> &'static str {
        self.row().0
    }

    /// Its name on an axis of a figure.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// The object that a probe of it refers to.
    fn needs(self) -> &'static str {
        self.row().2
    }

    /// Whether it is defined in dynamics only.
    pub fn is_dynamic(self) -> bool {
        self.row().3
    }

    /// Its dimension; that of a coordinate of a joint is multiplied by the coordinate's.
    pub fn dimension(self) -> Dimension {
        self.row().4
    }

    /// Key, name, object of the probe, whether it is defined in dynamics only, and dimension.
    #[rustfmt::skip]
    fn row(self) -> (&'static str, &'static str, &'static str, bool, Dimension) {
        use ProbeQuantity::*;
        let (statics, dynamics) = (false, true);
        match self {
            displacement => ("displacement", "displacement d", Self::NODE, statics, [0, 1, 0, 0]),
            position => ("position", "position", Self::NODE, statics, [0, 1, 0, 0]),
            rotation => ("rotation", "rotation vector Ψ", Self::NODE, statics, [0, 0, 0, 1]),
            chart_rotation => ("chart_rotation", "rotation vector Ψ in its chart", Self::NODE, statics, [0, 0, 0, 1]),
            velocity => ("velocity", "velocity", Self::NODE, dynamics, [0, 1, -1, 0]),
            angular_velocity => ("angular_velocity", "angular velocity ω", Self::NODE, dynamics, [0, 0, -1, 1]),
            acceleration => ("acceleration", "acceleration", Self::NODE, dynamics, [0, 1, -2, 0]),
            angular_acceleration => ("angular_acceleration", "angular acceleration ω̇", Self::NODE, dynamics, [0, 0, -2, 1]),
            joint_coordinate => ("joint_coordinate", "joint coordinate", Self::JOINT, statics, [0, 0, 0, 0]),
            joint_rate => ("joint_rate", "rate of joint coordinate", Self::JOINT, dynamics, [0, 0, -1, 0]),
            joint_acceleration => ("joint_acceleration", "acceleration of joint coordinate", Self::JOINT, dynamics, [0, 0, -2, 0]),
            joint_effort => ("joint_effort", "effort of joint", Self::JOINT, statics, [1, 1, 0, 0]),
            joint_force => ("joint_force", "force in joint", Self::FRAME, statics, [1, 0, 0, 0]),
            joint_moment => ("joint_moment", "moment in joint", Self::FRAME, statics, [1, 1, 0, 0]),
            reaction_force => ("reaction_force", "reaction force", Self::NODE, statics, [1, 0, 0, 0]),
            reaction_moment => ("reaction_moment", "reaction moment", Self::NODE, statics, [1, 1, 0, 0]),
            N => ("N", "forces N", Self::ELEMENT, statics, [1, 0, 0, 0]),
            M => ("M", "moments M", Self::ELEMENT, statics, [1, 1, 0, 0]),
            Gamma => ("Gamma", "strains Γ", Self::ELEMENT, statics, [0, 0, 0, 0]),
            K => ("K", "curvatures K", Self::ELEMENT, statics, [0, -1, 0, 1]),
            strain_energy => ("strain_energy", "strain energy", Self::NOTHING, statics, [1, 1, 0, 0]),
            kinetic_energy => ("kinetic_energy", "kinetic energy", Self::NOTHING, dynamics, [1, 1, 0, 0]),
            total_energy => ("total_energy", "total energy", Self::NOTHING, dynamics, [1, 1, 0, 0]),
            energy_defect => ("energy_defect", "energy defect", Self::NOTHING, dynamics, [1, 1, 0, 0]),
            momentum => ("momentum", "linear momentum", Self::SPACE, dynamics, [1, 0, 1, 0]),
            angular_momentum => ("angular_momentum", "angular momentum", Self::SPACE, dynamics, [1, 1, 1, 0]),
        }
    }
}
