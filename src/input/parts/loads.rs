//! Supports and loads of the file.

use super::Assembly;
use crate::input::assemble::LineGeometry;
use crate::input::file::{Analysis, Body, DofName, Initial, Load, ModelFile, Time};
use crate::input::names::Names;
use crate::input::{InputError, InputProblem, Location};
use nalgebra::Vector3;
use pullback_elements::element::Element;
use pullback_elements::load::{EccentricForce, LineLoad, LoadKind, NodalLoad};
use pullback_elements::model::{ModelBuilder, ModelError, NodeId};
use pullback_elements::time::{Constant, Input, TimeFunction};
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

impl Assembly<'_> {
    /// Adds the supports: prescribes coordinates.
    pub(super) fn add_supports(&mut self) -> Result<(), InputError> {
        let file = self.file;
        let mut taken = HashSet::new();
        let mut known = HashSet::new();
        for (k, support) in file.supports.iter().enumerate() {
            let at = self.at("supports").at(k);
            let node = self.nodes.find(&at.at("node"), &support.node)?;
            let fixed = support.fix.as_ref().map_or(&[][..], |fix| fix.dofs());
            let prescribed = support.prescribed.clone().unwrap_or_default();
            let fixed = (fixed.iter()).map(|&dof| (dof, at.at("fix"), Time::Constant(0.0)));
            let prescribed = (prescribed.given())
                .map(|(dof, time)| (dof, at.at("prescribed").at(dof.key()), time.clone()));
            let before = taken.len();
            for (dof, at, time) in fixed.chain(prescribed) {
                if !taken.insert((node, dof)) {
                    let (node, dof) = (support.node.clone(), dof.key());
                    return Err(at.refuse(InputProblem::PrescribedTwice { node, dof }));
                }
                let function = prescribed_function(&at, &self.inputs, &time)?;
                self.builder.prescribe(node, dof.dof(), function);
            }
            if taken.len() == before {
                let node = support.node.clone();
                return Err(at.at("node").refuse(InputProblem::UselessSupport { node }));
            }
            (self.geometry.supports).extend(known.insert(node).then_some(node));
        }
        let turning = turning(file);
        for name in file.nodes.keys().filter(|name| !turning.contains(name)) {
            let Some(node) = self.nodes.get(name) else {
                continue;
            };
            for dof in [DofName::RX, DofName::RY, DofName::RZ] {
                if taken.insert((node, dof)) {
                    self.builder.prescribe(node, dof.dof(), Constant(0.0));
                }
            }
        }
        Ok(())
    }

    /// Adds the loads.
    pub(super) fn add_loads(&mut self) -> Result<(), InputError> {
        let (file, mut builder) = (self.file, std::mem::take(&mut self.builder));
        let usual = match (&file.analysis, file.analysis.stepwise()) {
            (Analysis::Buckling(_), _) => Time::Proportional(1.0),
            (_, None | Some(Analysis::Dynamic(_))) => Time::Constant(1.0),
            (_, Some(_)) => Time::Proportional(1.0),
        };
        for (k, load) in file.loads.iter().enumerate() {
            let mut entry = Entry {
                at: self.at("loads").at(k),
                name: format!("load {}", k + 1),
                load,
                time: load.time.as_ref().unwrap_or(&usual),
                parts: self,
                builder: &mut builder,
            };
            entry.apply()?;
        }
        self.builder = builder;
        Ok(())
    }
}

/// The nodes with rotational stiffness or inertia: point masses, springs along lines and forces have
/// none, and a rotation that nothing resists has no solution.
fn turning(file: &ModelFile) -> HashSet<&String> {
    let lines = file.lines.iter().flat_map(|l| [&l.from, &l.to]);
    let joints = file.joints.iter();
    let joints = joints.flat_map(|j| [&j.parent, &j.child]).flatten();
    let rigid = |b: &&Body| b.inertia.is_some() || b.center.is_some();
    let bodies = file.bodies.iter().filter(rigid).map(|b| &b.node);
    let bushings = file.springs.iter().filter(|s| s.bushing.is_some());
    let bushings = bushings.flat_map(|s| &s.nodes);
    let moments = file
        .loads
        .iter()
        .filter(|l| l.moment.is_some() || l.follower);
    let moments = moments.filter_map(|l| l.node.as_ref());
    let set = |i: &&Initial| {
        i.rotation.is_some() || i.angular_velocity.is_some() || i.body_angular_velocity.is_some()
    };
    let initial = file.initial.iter().filter(set);
    let initial = initial.filter_map(|i| i.node.as_ref());
    let all = lines.chain(joints).chain(bodies).chain(bushings);
    all.chain(moments).chain(initial).collect()
}

/// The function of a load.
pub(in crate::input) fn function(
    at: &Location<'_>,
    inputs: &Names<Input>,
    time: &Time,
) -> Result<Box<dyn TimeFunction>, InputError> {
    match time {
        Time::Input(name) => Ok(Box::new(inputs.find(&at.at("input"), name)?)),
        own => (own.function(&BTreeMap::new())).map_err(|error| at.refuse(error)),
    }
}

/// The function of a prescribed coordinate, which must not jump.
pub(in crate::input) fn prescribed_function(
    at: &Location<'_>,
    inputs: &Names<Input>,
    time: &Time,
) -> Result<Box<dyn TimeFunction>, InputError> {
    match time {
        Time::Pulse(_) => Err(at.refuse(InputProblem::Jump)),
        _ => function(at, inputs, time),
    }
}

/// A load of the file with its location there.
struct Entry<'a> {
    at: Location<'a>,
    name: String,
    load: &'a Load,
    time: &'a Time,
    parts: &'a Assembly<'a>,
    builder: &'a mut ModelBuilder,
}

impl Entry<'_> {
    fn amplitude(&self) -> Result<Box<dyn TimeFunction>, InputError> {
        function(&self.at.at("time"), &self.parts.inputs, self.time)
    }

    /// Adds the load.
    fn apply(&mut self) -> Result<(), InputError> {
        let (at, load, parts) = (self.at.clone(), self.load, self.parts);
        let all = [
            ("force", load.force),
            ("moment", load.moment),
            ("force_per_length", load.force_per_length),
            ("gravity", load.gravity),
        ];
        let given = all.into_iter().filter_map(|(key, v)| Some((key, v?)));
        let given: Vec<(&'static str, [f64; 3])> = given.collect();
        let &[(key, vector)] = given.as_slice() else {
            let given = given.into_iter().map(|(key, _)| key).collect();
            return Err(at.refuse(InputProblem::LoadKind { keys: given }));
        };
        let target = |needs: &'static str| {
            let load = key;
            Err(at.at(key).refuse(InputProblem::LoadTarget { load, needs }))
        };
        match (key, &load.node, &load.line) {
            ("force" | "moment", Some(node), None) => {
                let which = match (key, load.follower) {
                    ("force", false) => LoadKind::DeadForce,
                    ("force", true) => LoadKind::FollowerForce,
                    (_, false) => LoadKind::SpatialMoment,
                    (_, true) => LoadKind::FollowerMoment,
                };
                let node = parts.nodes.find(&at.at("node"), node)?;
                let load = NodalLoad::new(which, vector, self.amplitude()?);
                self.add(self.name.clone(), Box::new(load), &[node])
            }
            ("force" | "moment", ..) => target("node"),
            ("force_per_length", None, Some(line)) => {
                let line = &parts.geometry.lines[parts.lines.find(&at.at("line"), line)?];
                (0..line.elements.len()).try_for_each(|e| {
                    let name = format!("{}:{}", self.name, e + 1);
                    self.distribute(line, e, name, vector)
                })
            }
            ("force_per_length", ..) => target("line"),
            (_, Some(_), _) => target("line, or on all lines and bodies if none is named"),
            _ if load.follower => Err(at.at("follower").refuse(InputProblem::FollowerGravity)),
            (_, None, Some(line)) => {
                let line = parts.lines.find(&at.at("line"), line)?;
                self.weigh_lines(vector, line..line + 1, true)
            }
            (_, None, None) => {
                // Where bodies have weight, lines may have none.
                let bodies = !parts.file.bodies.is_empty();
                self.weigh_lines(vector, 0..parts.file.lines.len(), !bodies)?;
                self.weigh_bodies(vector)
            }
        }
    }

    /// Adds the weights of all bodies.
    fn weigh_bodies(&mut self, g: [f64; 3]) -> Result<(), InputError> {
        let parts = self.parts;
        for (placed, body) in parts.geometry.bodies.iter().zip(&parts.file.bodies) {
            let name = format!("{}: weight of {}", self.name, body.name);
            let (force, amplitude) = (g.map(|g| g * body.mass), self.amplitude()?);
            let weight: Box<dyn Element> = match (body.inertia, body.center) {
                (None, None) => Box::new(NodalLoad::new(LoadKind::DeadForce, force, amplitude)),
                _ => Box::new(EccentricForce::new(force, placed.center.into(), amplitude)),
            };
            self.add(name, weight, &[placed.node])?;
        }
        Ok(())
    }

    fn add(
        &mut self,
        name: String,
        load: Box<dyn Element>,
        nodes: &[NodeId],
    ) -> Result<(), InputError> {
        let added = self.builder.element(name, load, nodes);
        added.map(|_| ()).map_err(|error| self.at.refuse(error))
    }

    /// Adds a force per length on element `e` of a line.
    fn distribute(
        &mut self,
        line: &LineGeometry,
        e: usize,
        name: String,
        force: [f64; 3],
    ) -> Result<(), InputError> {
        let nodes = nodes(line, e);
        let positions = nodes.iter().map(|&n| self.builder.position(n));
        let positions: Vec<Vector3<f64>> = positions.collect();
        let load = LineLoad::new(&positions, force, self.load.follower, self.amplitude()?);
        let load = load.map_err(|source| {
            let element = name.clone();
            self.at.refuse(ModelError::Beam { element, source })
        })?;
        let load = load.with_interpolation(line.interpolation);
        self.add(name, Box::new(load), nodes)
    }

    /// Adds the weight of lines, which must have mass if they are `heavy`.
    fn weigh_lines(
        &mut self,
        g: [f64; 3],
        lines: Range<usize>,
        heavy: bool,
    ) -> Result<(), InputError> {
        let parts = self.parts;
        for l in lines {
            let (line, section) = (&parts.geometry.lines[l], &parts.file.lines[l].section);
            let mass = (parts.sections.get(section)).map_or(0.0, |s| s.inertia.mass);
            if mass == 0.0 && heavy {
                let (line, section) = (line.name.clone(), section.clone());
                return Err((self.at.at("gravity")).refuse(InputProblem::NoMass { line, section }));
            }
            if mass != 0.0 {
                self.weigh(line, mass, g.into())?;
            }
        }
        Ok(())
    }

    /// Adds the weight of a line with a mass per length. The weight of a mass centre off the axis is distributed
    /// over the nodes like the inertia, so that free fall causes no rotation.
    fn weigh(&mut self, line: &LineGeometry, mass: f64, g: Vector3<f64>) -> Result<(), InputError> {
        for e in 0..line.elements.len() {
            let name = format!("{}:{}:{}", self.name, line.name, e + 1);
            let Some(shares) = line.carried.get(e) else {
                self.distribute(line, e, name, (g * mass).into())?;
                continue;
            };
            for (i, (mass, first_moment)) in shares.iter().enumerate() {
                let (force, center) = ((g * *mass).into(), (first_moment / *mass).into());
                let share = EccentricForce::new(force, center, self.amplitude()?);
                let name = format!("{name}, node {}", i + 1);
                self.add(name, Box::new(share), &[nodes(line, e)[i]])?;
            }
        }
        Ok(())
    }
}

/// Nodes of element `e` of a line.
fn nodes(line: &LineGeometry, e: usize) -> &[NodeId] {
    &line.nodes[e * line.order..=(e + 1) * line.order]
}
