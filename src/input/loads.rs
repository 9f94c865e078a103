//! Supports and loads of the file.

#![allow(non_snake_case)]

use super::assemble::LineGeometry;
use super::bodies::{Matter, Placed};
use super::file::{Analysis, Body, DofName, Initial, Load, ModelFile, Time};
use super::names::Names;
use super::{InputError, Problem, Text};
use nalgebra::Vector3;
use pullback_elements::beam::Section;
use pullback_elements::load::{EccentricForce, LineLoad, LoadKind, NodalLoad};
use pullback_elements::model::{ModelBuilder, ModelError, NodeId};
use pullback_elements::time::{Constant, TimeFunction};
use std::collections::{BTreeMap, HashSet};

/// Prescribes coordinates; returns the nodes that have a support.
pub(super) fn support(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    nodes: &Names<NodeId>,
    file: &ModelFile,
) -> Result<Vec<NodeId>, InputError> {
    let mut taken = HashSet::new();
    let (mut supported, mut known) = (Vec::new(), HashSet::new());
    for (k, support) in file.supports.iter().enumerate() {
        let index = k.to_string();
        let path = |key: &'static str| ["supports", index.as_str(), key];
        let node = nodes.find(source, &path("node"), &support.node)?;
        let fixed = support.fix.as_ref().map_or(&[][..], |fix| fix.dofs());
        let prescribed = support.prescribed.clone().unwrap_or_default();
        let fixed = fixed
            .iter()
            .map(|&dof| (dof, path("fix").to_vec(), Time::Constant(0.0)));
        let prescribed = prescribed.given().map(|(dof, time)| {
            let path = [&path("prescribed")[..], &[dof.key()]].concat();
            (dof, path, time.clone())
        });
        let before = taken.len();
        for (dof, path, time) in fixed.chain(prescribed) {
            if !taken.insert((node, dof)) {
                let problem = Problem::PrescribedTwice {
                    node: support.node.clone(),
                    dof: dof.key(),
                };
                return Err(source.value(&path, problem));
            }
            match time {
                Time::Constant(value) => builder.prescribe(node, dof.dof(), Constant(value)),
                _ => builder.prescribe_boxed(
                    node,
                    dof.dof(),
                    prescribed_function(source, &path, &time)?,
                ),
            }
        }
        if taken.len() == before {
            let node = support.node.clone();
            return Err(source.value(&path("node"), Problem::UselessSupport { node }));
        }
        supported.extend(known.insert(node).then_some(node));
    }
    let turning = turning(file);
    for name in file.nodes.keys().filter(|name| !turning.contains(name)) {
        let Some(node) = nodes.get(name) else {
            continue;
        };
        for dof in [DofName::RX, DofName::RY, DofName::RZ] {
            if taken.insert((node, dof)) {
                builder.prescribe(node, dof.dof(), Constant(0.0));
            }
        }
    }
    Ok(supported)
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

pub(super) fn function(
    source: &Text<'_>,
    path: &[&str],
    time: &Time,
) -> Result<Box<dyn TimeFunction>, InputError> {
    time.function()
        .map_err(|error| source.value(path, Problem::Time { source: error }))
}

/// The function of a prescribed coordinate, which must not jump.
pub(super) fn prescribed_function(
    source: &Text<'_>,
    path: &[&str],
    time: &Time,
) -> Result<Box<dyn TimeFunction>, InputError> {
    match time {
        Time::Pulse(_) => Err(source.value(path, Problem::Jump)),
        _ => function(source, path, time),
    }
}

/// Lines, sections and bodies, on which loads act.
pub(super) struct Loaded<'a> {
    pub lines: &'a [LineGeometry],
    pub bodies: &'a [Placed],
    pub sections: &'a BTreeMap<String, Section>,
}

/// Adds the loads.
pub(super) fn apply(
    source: &Text<'_>,
    builder: &mut ModelBuilder,
    nodes: &Names<NodeId>,
    &Loaded {
        lines,
        bodies,
        sections,
    }: &Loaded<'_>,
    file: &ModelFile,
) -> Result<(), InputError> {
    let usual = match file.analysis {
        Analysis::Dynamic(_) => Time::Constant(1.0),
        _ => Time::Proportional(1.0),
    };
    let known = Names::lines(file);
    for (k, load) in file.loads.iter().enumerate() {
        let index = k.to_string();
        let whole = ["loads", index.as_str()];
        let path = |key: &'static str| ["loads", index.as_str(), key];
        let time = load.time.as_ref().unwrap_or(&usual);
        let amplitude = || function(source, &path("time"), time);
        let model_error = |error| source.value(&whole, Problem::Model(error));
        match which(source, &path, &whole, load)? {
            Kind::Node(which, vector, name) => {
                let node = nodes.find(source, &path("node"), name)?;
                let load = NodalLoad::boxed(which, vector, amplitude()?);
                builder
                    .element(format!("load {}", k + 1), load, &[node])
                    .map_err(model_error)?;
            }
            Kind::Line(vector, name) => {
                let line = known.find(source, &path("line"), name)?;
                for e in 0..lines[line].elements.len() {
                    let (nodes, positions) = element(builder, &lines[line], e);
                    let load = LineLoad::new(&positions, vector, load.follower, amplitude()?)
                        .map_err(|error| {
                            let element = format!("load {}", k + 1);
                            let source = error;
                            model_error(ModelError::Beam { element, source })
                        })?
                        .with_interpolation(lines[line].interpolation);
                    builder
                        .element(format!("load {}:{}", k + 1, e + 1), load, nodes)
                        .map_err(model_error)?;
                }
            }
            Kind::Gravity(g) => {
                let only = match &load.line {
                    Some(name) => Some(known.find(source, &path("line"), name)?),
                    None => None,
                };
                for (l, line) in lines.iter().enumerate() {
                    if only.is_some_and(|only| only != l) {
                        continue;
                    }
                    let name = &file.lines[l].section;
                    let A_rho = sections.get(name).map_or(0.0, |s| s.inertia.mass);
                    if A_rho == 0.0 && only.is_none() && !bodies.is_empty() {
                        // The bodies have weight, these lines do not.
                        continue;
                    }
                    if A_rho == 0.0 {
                        let problem = Problem::NoMass {
                            line: line.name.clone(),
                            section: name.clone(),
                        };
                        return Err(source.value(&path("gravity"), problem));
                    }
                    let weight = Weight {
                        name: format!("load {}", k + 1),
                        g: g.into(),
                        mass: A_rho,
                    };
                    weight.add(builder, line, &amplitude, &model_error)?;
                }
                for (b, body) in bodies.iter().enumerate().filter(|_| only.is_none()) {
                    let element = format!("load {}: weight of {}", k + 1, file.bodies[b].name);
                    match &body.matter {
                        Matter::Point(mass) => {
                            let weight = mass.weight(g, amplitude()?);
                            builder.element(element, weight, &[body.node])
                        }
                        Matter::Rigid(rigid) => {
                            let weight = rigid.weight(g, amplitude()?);
                            builder.element(element, weight, &[body.node])
                        }
                    }
                    .map_err(model_error)?;
                }
            }
        }
    }
    Ok(())
}

/// The weight of a line.
struct Weight {
    name: String,
    g: Vector3<f64>,
    /// Mass per length.
    mass: f64,
}

impl Weight {
    /// Adds it. The weight of a mass centre off the axis is distributed over the nodes like the
    /// inertia, so that free fall causes no rotation.
    fn add(
        &self,
        builder: &mut ModelBuilder,
        line: &LineGeometry,
        amplitude: &dyn Fn() -> Result<Box<dyn TimeFunction>, InputError>,
        model_error: &dyn Fn(ModelError) -> InputError,
    ) -> Result<(), InputError> {
        for e in 0..line.elements.len() {
            let (nodes, positions) = element(builder, line, e);
            let name = format!("{}:{}:{}", self.name, line.name, e + 1);
            let Some(shares) = line.carried.get(e) else {
                let force = (self.g * self.mass).into();
                let whole = LineLoad::new(&positions, force, false, amplitude()?);
                let whole = whole.map_err(|source| {
                    let element = name.clone();
                    model_error(ModelError::Beam { element, source })
                })?;
                builder.element(name, whole, nodes).map_err(model_error)?;
                continue;
            };
            for (i, (mass, S)) in shares.iter().enumerate() {
                let (n, at) = ((self.g * *mass).into(), (S / *mass).into());
                let part = EccentricForce::boxed(n, at, amplitude()?);
                builder
                    .element(format!("{name}, node {}", i + 1), part, &[nodes[i]])
                    .map_err(model_error)?;
            }
        }
        Ok(())
    }
}

/// A load as an element.
enum Kind<'a> {
    Node(LoadKind, [f64; 3], &'a str),
    Line([f64; 3], &'a str),
    Gravity([f64; 3]),
}

fn which<'a>(
    source: &Text<'_>,
    path: &dyn Fn(&'static str) -> [&'a str; 3],
    whole: &[&str],
    load: &'a Load,
) -> Result<Kind<'a>, InputError> {
    let all = [
        ("force", load.force),
        ("moment", load.moment),
        ("force_per_length", load.force_per_length),
        ("gravity", load.gravity),
    ];
    let given: Vec<(&'static str, [f64; 3])> = all
        .into_iter()
        .filter_map(|(key, vector)| Some((key, vector?)))
        .collect();
    let &[(key, vector)] = given.as_slice() else {
        let given = given.into_iter().map(|(key, _)| key).collect();
        return Err(source.value(whole, Problem::LoadKind { given }));
    };
    let target = |needs: &'static str| {
        let load = key;
        source.value(&path(key), Problem::LoadTarget { load, needs })
    };
    match key {
        "force" | "moment" => {
            let which = match (key, load.follower) {
                ("force", false) => LoadKind::DeadForce,
                ("force", true) => LoadKind::FollowerForce,
                (_, false) => LoadKind::SpatialMoment,
                (_, true) => LoadKind::FollowerMoment,
            };
            let node = load.node.as_deref().filter(|_| load.line.is_none());
            let node = node.ok_or_else(|| target("node"))?;
            Ok(Kind::Node(which, vector, node))
        }
        "force_per_length" => {
            let line = load.line.as_deref().filter(|_| load.node.is_none());
            Ok(Kind::Line(vector, line.ok_or_else(|| target("line"))?))
        }
        _ if load.node.is_some() => Err(target("line")),
        _ if load.follower => Err(source.value(&path("follower"), Problem::FollowerGravity)),
        _ => Ok(Kind::Gravity(vector)),
    }
}

/// Nodes and reference positions of an element of a line.
fn element<'a>(
    builder: &ModelBuilder,
    line: &'a LineGeometry,
    e: usize,
) -> (&'a [NodeId], Vec<Vector3<f64>>) {
    let nodes = &line.nodes[e * line.order..=(e + 1) * line.order];
    (nodes, nodes.iter().map(|&n| builder.position(n)).collect())
}
