//! The parts of a model file, added in an order in which the nodes of each exist before it.

mod bodies;
mod lines;
mod loads;
mod sections;

pub(super) use loads::{function, prescribed_function};

use super::assemble::{Geometry, LineGeometry};
use super::file::{self, Joint, ModelFile};
use super::imperfection::{self, Offset};
use super::joints::Registry;
use super::names::{Names, check_names, usable_name};
use super::{InputError, InputProblem, Location};
use nalgebra::Vector3;
use pullback_elements::beam::Section;
use pullback_elements::constraint::PenaltyStiffness;
use pullback_elements::joint::JointNodes;
use pullback_elements::model::{Closure, ModelBuilder, NodeId};
use pullback_elements::time::Input;

/// A model under construction, with the parts that others refer to by name.
pub(super) struct Assembly<'a> {
    pub file: &'a ModelFile,
    root: Location<'a>,
    pub builder: ModelBuilder,
    pub sections: Names<Section>,
    pub nodes: Names<NodeId>,
    /// Lines by their number in the file.
    pub lines: Names<usize>,
    /// The lines that are meshed.
    pub meshed: Vec<Option<LineGeometry>>,
    /// Nodes of the joints, in the order of the file.
    pub joints: Vec<Option<JointNodes>>,
    /// Nodes of released coordinates, by the name of their joint.
    pub joint_coordinates: Names<NodeId>,
    pub geometry: Geometry,
    pub inputs: Names<Input>,
    /// The speed of the joint of a Campbell diagram.
    pub speed: Option<Input>,
    /// Displacements and rotations of the reference configuration by node, if there are imperfections.
    pub offsets: Option<Names<Offset>>,
}

/// A part whose nodes do not exist yet.
#[derive(Clone, Copy)]
enum Part {
    Line(usize),
    Joint(usize),
}

impl<'a> Assembly<'a> {
    pub fn new(root: &Location<'a>, file: &'a ModelFile) -> Self {
        Self {
            file,
            root: root.clone(),
            builder: ModelBuilder::new(),
            sections: Names::new("section"),
            nodes: Names::new("node"),
            lines: Names::of("line", file.lines.iter().map(|l| l.name.clone()).zip(0..)),
            meshed: file.lines.iter().map(|_| None).collect(),
            joints: vec![None; file.joints.len()],
            joint_coordinates: Names::new(
                "joint with a released coordinate (a node of one coordinate)",
            ),
            geometry: Geometry::default(),
            inputs: Names::new("input"),
            speed: None,
            offsets: None,
        }
    }

    /// The displacement and rotation of a node of the reference configuration by imperfections.
    pub fn offset(&self, at: &Location<'_>, node: &str) -> Result<Offset, InputError> {
        match &self.offsets {
            Some(offsets) => offsets.find(at, node),
            None => Ok(Offset::default()),
        }
    }

    /// The location of a key of the file.
    pub fn at(&self, key: &str) -> Location<'a> {
        self.root.at(key)
    }

    /// Adds all parts of the file.
    pub fn add_parts(&mut self, registry: &Registry) -> Result<(), InputError> {
        self.add_inputs();
        self.add_sections()?;
        self.offsets = imperfection::offsets(&self.root, self.file)?;
        self.add_nodes()?;
        check_names(self)?;
        self.add_lines_and_joints(registry)?;
        self.check_offsets()?;
        self.add_bodies()?;
        self.geometry.links = links(self).collect();
        self.add_springs()?;
        self.add_supports()?;
        self.add_loads()
    }

    /// Adds the inputs in the order of their names.
    fn add_inputs(&mut self) {
        for (name, value) in &self.file.inputs {
            let input = self.builder.input(*value);
            self.inputs.add(name.clone(), input);
        }
    }

    /// Adds the nodes in the order in which the file names them.
    fn add_nodes(&mut self) -> Result<(), InputError> {
        let mut order: Vec<_> = (self.file.nodes.iter())
            .map(|(name, &position)| (self.at("nodes").at(name), name, position))
            .collect();
        order.sort_by_key(|(at, ..)| at.start());
        for (at, name, position) in order {
            if !usable_name(name) {
                let (what, name) = ("node", name.clone());
                return Err(at.refuse_key(InputProblem::Name { what, name }));
            }
            let [moved, _] = self.offset(&at, name)?;
            let position = Vector3::from(position) + moved;
            let id = self.builder.node(name.clone(), position.into());
            let id = id.map_err(|error| at.refuse(error))?;
            self.nodes.add(name.clone(), id);
        }
        Ok(())
    }

    /// Refuses shapes with nodes that the model lacks: its lines have other elements.
    fn check_offsets(&self) -> Result<(), InputError> {
        let names = self.offsets.iter().flat_map(Names::iter);
        for name in names {
            self.nodes
                .find(&self.at("imperfections").at(0).at("shapes"), name)?;
        }
        Ok(())
    }

    /// Adds all lines and joints, then closes loops and couples gears.
    fn add_lines_and_joints(&mut self, registry: &Registry) -> Result<(), InputError> {
        let file = self.file;
        let all = (0..file.lines.len()).map(Part::Line);
        let mut waiting: Vec<Part> = all.chain((0..file.joints.len()).map(Part::Joint)).collect();
        while !waiting.is_empty() {
            let before = waiting.len();
            let mut rest = Vec::new();
            for part in waiting {
                match part {
                    _ if !self.is_ready(part) => rest.push(part),
                    Part::Line(k) => self.add_line(k)?,
                    Part::Joint(k) => self.add_joint(registry, k)?,
                }
            }
            waiting = rest;
            if waiting.len() == before {
                return Err(self.unresolved(&waiting));
            }
        }
        self.geometry.lines = self.meshed.drain(..).flatten().collect();
        self.close()
    }

    /// Closes loops of joints, and couples joints by gears.
    fn close(&mut self) -> Result<(), InputError> {
        for (k, joint) in self.file.joints.iter().enumerate() {
            let at = self.at("joints").at(k);
            let by = closure(&at, joint)?;
            let Some(child) = &joint.child else { continue };
            let at = at.at("child");
            let child = self.nodes.find(&at, child)?;
            let frame = self.nodes.find(&at, &joint.name)?;
            let closed = self.builder.close_by(frame, child, by);
            closed.map_err(|error| at.refuse(error))?;
        }
        for (k, gear) in self.file.gears.iter().enumerate() {
            let at = self.at("gears").at(k);
            let joint =
                |i: usize| (self.joint_coordinates).find(&at.at("joints").at(i), &gear.joints[i]);
            let joints = [joint(0)?, joint(1)?];
            let coupled = self.builder.gear(joints, gear.ratio);
            coupled.map_err(|error| at.refuse(error))?;
        }
        Ok(())
    }

    /// Whether the nodes and lines that a part is attached to exist.
    fn is_ready(&self, part: Part) -> bool {
        match part {
            Part::Line(k) => {
                let line = &self.file.lines[k];
                let mut needed = [&line.from, &line.to].into_iter().chain(&line.relative_to);
                needed.all(|name| self.nodes.knows(name))
            }
            Part::Joint(k) => {
                let joint = &self.file.joints[k];
                let line_ready = |name: &String| {
                    // An unknown line is refused with the joint.
                    let k = self.lines.get(name);
                    k.is_none_or(|k| self.meshed[k].is_some())
                };
                joint.lines.iter().all(line_ready)
                    && (joint.parent.as_ref()).is_none_or(|p| self.nodes.knows(p))
            }
        }
    }

    /// Why no remaining part can be constructed: an unknown node, or a cycle of dependencies.
    fn unresolved(&self, waiting: &[Part]) -> InputError {
        let file = self.file;
        let mut wanted = Vec::new();
        for part in waiting {
            match *part {
                Part::Line(k) => {
                    let (at, line) = (self.at("lines").at(k), &file.lines[k]);
                    wanted.push((at.at("from"), &line.from));
                    wanted.push((at.at("to"), &line.to));
                    wanted
                        .extend((line.relative_to.iter()).map(|name| (at.at("relative_to"), name)));
                }
                Part::Joint(k) => {
                    let at = self.at("joints").at(k).at("parent");
                    wanted.extend(file.joints[k].parent.as_ref().map(|parent| (at, parent)));
                }
            }
        }
        wanted.retain(|(_, name)| !self.nodes.knows(name));
        let constructed = |name: &str| {
            file.joints.iter().any(|j| j.name == name)
                || (name.split_once('/')).is_some_and(|(line, _)| self.lines.knows(line))
        };
        let unknown = (wanted.iter().filter(|(_, name)| !constructed(name)))
            .find_map(|(at, name)| self.nodes.find(at, name).err());
        let names = wanted.iter().map(|(_, name)| (*name).clone()).collect();
        match (unknown, wanted.first()) {
            (Some(error), _) => error,
            (None, Some((at, _))) => at.refuse(InputProblem::Cycle { names }),
            (None, None) => InputError::whole(InputProblem::Cycle { names }),
        }
    }
}

/// The ends of rigid links and springs.
fn links<'a>(assembly: &'a Assembly<'_>) -> impl Iterator<Item = [NodeId; 2]> + 'a {
    let offsets = assembly.file.joints.iter().filter(|j| j.kind == "offset");
    let links = offsets.filter_map(|joint| Some([joint.parent.as_ref()?, &joint.name]));
    let springs = assembly.file.springs.iter();
    let ends = links.chain(springs.map(|spring| spring.nodes.each_ref()));
    let nodes = &assembly.nodes;
    ends.filter_map(|[a, b]| Some([nodes.get(a)?, nodes.get(b)?]))
}

/// The closure between a joint and its child; refuses inapplicable and missing keys.
fn closure(at: &Location<'_>, joint: &Joint) -> Result<Closure, InputError> {
    let useless = |key: &'static str, needs: &'static str| {
        let joint = joint.name.clone();
        (at.at(key)).refuse_key(InputProblem::ClosureKey { joint, key, needs })
    };
    if joint.closure.is_some() && joint.child.is_none() {
        return Err(useless(
            "closure",
            "child, the node that is one with the joint's",
        ));
    }
    let by = joint.closure.unwrap_or(file::Closure::Map);
    for (key, given) in [
        ("penalty", joint.penalty),
        ("penalty_damping", joint.penalty_damping),
    ] {
        if given.is_some() && by != file::Closure::Penalty {
            return Err(useless(key, "closure = \"penalty\""));
        }
    }
    match (by, joint.penalty) {
        (file::Closure::Map, _) => Ok(Closure::Map),
        (file::Closure::Multipliers, _) => Ok(Closure::Multipliers),
        (file::Closure::Penalty, None) => Err(useless(
            "closure",
            "penalty, its stiffness (force over gap)",
        )),
        (file::Closure::Penalty, Some(p)) => {
            let tau = joint.penalty_damping.unwrap_or(0.0);
            at.refuse_if(p <= 0.0, "penalty", p, "a positive stiffness")?;
            let expected = "a time that is zero or positive";
            at.refuse_if(tau < 0.0, "penalty_damping", tau, expected)?;
            Ok(Closure::Penalty(PenaltyStiffness { p, tau }))
        }
    }
}
