//! A look inside a model for the conformance kit: its components one by one, in the configuration
//! last set.

use super::assembly::named;
use super::{Form, Model, Node, Prescribed, Source};
use crate::check::Frame;
use crate::element::Element;
use nalgebra::{DVector, Vector3};
use pullback_manifold::check::{Group, Layout, State, plain};
use pullback_manifold::map::Parametrization;
use pullback_manifold::system::{Evaluation, Kind, Point, System, SystemError};

/// One component, with its coordinates.
pub(crate) struct Component<T> {
    /// What it is called in reports.
    pub name: String,
    pub thing: T,
    pub layout: Layout,
    /// Those of its coordinates that are frames.
    pub frames: Vec<Frame>,
    /// First coordinates of rotation vectors that are no frame's.
    pub rotations: Vec<usize>,
}

/// A rotation vector that can be written in another chart: unknowns of its components.
pub(crate) type Rotation = [Option<usize>; 3];

impl Model {
    /// Whether node number `n` is a frame.
    pub(crate) fn is_frame_at(&self, n: usize) -> bool {
        self.nodes[n].is_frame()
    }

    /// Element `k` with its layout; `units` are those of the nodes.
    pub(crate) fn inspect_element(&self, k: usize, units: &[f64]) -> Component<&dyn Element> {
        let e = &self.elements[k];
        let nodes = e.nodes.iter().map(|&n| n as usize);
        let what = if e.element.is_load() {
            "load"
        } else {
            "element"
        };
        let own = self.extent(&e.nodes).unwrap_or(0.0);
        let unit = |n: usize| if own > 0.0 { own } else { units[n] };
        self.component(
            format!("{what} {} ({})", e.name, plain(e.element.kind())),
            &*e.element,
            nodes,
            &unit,
        )
    }

    /// The state of element `k`, in its chart, without motion.
    pub(crate) fn element_state(&self, k: usize, t: f64) -> State {
        State::statics(
            t,
            DVector::from_vec(self.element_coordinates(&self.elements[k])),
        )
    }

    /// The nodes that follow others.
    pub(crate) fn followers(&self) -> &[u32] {
        &self.dependent
    }

    /// The map of a node that follows others, with the layout of what it takes.
    pub(crate) fn inspect_map(
        &self,
        n: u32,
        units: &[f64],
    ) -> Option<Component<&dyn Parametrization>> {
        let node = &self.nodes[n as usize];
        let Source::Mapped(d) = &node.source else {
            return None;
        };
        let parents = d.parents().iter().map(|&m| m as usize);
        let what = if node.is_frame() {
            "joint "
        } else if self.reports.iter().any(|r| r.map == Some(n)) {
            ""
        } else {
            "coordinate "
        };
        Some(self.component(
            format!("{what}{} ({})", node.name, plain(d.map.kind())),
            &*d.map,
            parents,
            &|n| units[n],
        ))
    }

    /// What the map of a node gives.
    pub(crate) fn inspect_hung(&self, n: u32, units: &[f64]) -> (Layout, bool) {
        let node = &self.nodes[n as usize];
        let all = self.component(String::new(), (), std::iter::once(n as usize), &|n| {
            units[n]
        });
        (all.layout, node.is_frame())
    }

    /// Reference position of a node that follows others.
    pub(crate) fn hung_place(&self, n: u32) -> Vector3<f64> {
        self.nodes[n as usize].position
    }

    /// The motion of a map's parents.
    pub(crate) fn parent_state(&self, n: u32, t: f64) -> State {
        let Source::Mapped(d) = &self.nodes[n as usize].source else {
            return State::statics(t, DVector::zeros(0));
        };
        let all = |x: &[f64]| {
            let coordinates = d.parents().iter();
            let coordinates = coordinates.flat_map(|&m| self.nodes[m as usize].range());
            DVector::from_iterator(d.direct, coordinates.map(|c| x[c]))
        };
        let w = &self.work;
        let [x, v, a] = [&w.x, &w.v, &w.a].map(|x| all(x));
        State { t, x, v, a }
    }

    fn component<T>(
        &self,
        name: String,
        thing: T,
        nodes: impl Iterator<Item = usize>,
        unit: &dyn Fn(usize) -> f64,
    ) -> Component<T> {
        let (mut groups, mut first) = (Vec::new(), 0);
        let (mut frames, mut rotations) = (Vec::new(), Vec::new());
        for n in nodes {
            let node = &self.nodes[n];
            for (range, name, kind) in node.groups() {
                groups.push(group(
                    node,
                    range.start + first..range.end + first,
                    name,
                    kind,
                    unit(n),
                ));
            }
            match node.form {
                Form::Frame => frames.push(Frame {
                    first,
                    position: node.position,
                }),
                Form::Rotation => rotations.push(first),
                Form::Increment | Form::Coordinates | Form::Multipliers | Form::Idle => {}
            }
            first += node.dim;
        }
        let layout = Layout::new(groups);
        Component {
            name,
            thing,
            layout,
            frames,
            rotations,
        }
    }

    /// The largest distance between frames among nodes; `None` where there are none.
    fn extent(&self, nodes: &[u32]) -> Option<f64> {
        let positions = || {
            let nodes = nodes.iter().map(|&n| &self.nodes[n as usize]);
            nodes.filter(|n| n.is_frame()).map(|n| n.position)
        };
        positions()
            .flat_map(|a| positions().map(move |b| (a - b).norm()))
            .reduce(f64::max)
    }

    /// A typical length at each node: the size of the smallest element that it belongs to, and of
    /// the model where that has none.
    pub(crate) fn node_units(&self) -> Vec<f64> {
        let mut units = vec![f64::INFINITY; self.nodes.len()];
        for e in &self.elements {
            if let Some(size) = self.extent(&e.nodes).filter(|&l| l > 0.0) {
                for &n in e.nodes.iter() {
                    let unit = &mut units[n as usize];
                    *unit = unit.min(size);
                }
            }
        }
        // What a joint releases is of the size of what it joins.
        for &n in self.dependent.iter().rev() {
            if let Source::Mapped(d) = &self.nodes[n as usize].source {
                let all = || d.parents().iter().chain([&n]).map(|&m| m as usize);
                let least = all().map(|m| units[m]).fold(f64::INFINITY, f64::min);
                all().for_each(|m| {
                    if units[m].is_infinite() {
                        units[m] = least
                    }
                });
            }
        }
        units
            .iter_mut()
            .filter(|u| u.is_infinite())
            .for_each(|u| *u = self.length);
        units
    }

    /// The layout of the unknowns.
    pub(crate) fn layout(&self, units: &[f64]) -> Layout {
        let mut groups: Vec<Group> = Vec::new();
        for block in 0..self.pattern.blocks() {
            let all = self.pattern.unknowns(block);
            let c = self.coordinates[all.start];
            let n = self.node_of(c);
            let node = &self.nodes[n];
            for (range, name, kind) in node.groups() {
                let own = range.start + node.first..range.end + node.first;
                let inside = all.clone().filter(|&u| own.contains(&self.coordinates[u]));
                let (first, count) = (inside.clone().next(), inside.count());
                if let Some(first) = first {
                    groups.push(group(node, first..first + count, name, kind, units[n]));
                }
            }
        }
        Layout::new(groups)
    }

    /// Rate at which prescribed coordinates change, in radians and lengths of the model.
    pub(crate) fn drive_rate(&self, t: f64) -> f64 {
        let rate = |p: &Prescribed| {
            let [_, rate, second] = p.function.at(t);
            let unit = match self.kinds[p.coordinate] {
                Kind::Length => self.length,
                _ => 1.0,
            };
            (rate.abs() / unit).max((second.abs() / unit).sqrt())
        };
        self.prescribed.iter().map(rate).fold(0.0, f64::max)
    }

    /// For each unknown: its node's position, which coordinate of the node it is, and what it measures.
    pub(crate) fn inspect_unknowns(&self) -> Vec<(usize, Vector3<f64>, usize, Kind)> {
        let mut owner = vec![0; self.kinds.len()];
        for (n, node) in self.nodes.iter().enumerate() {
            owner[node.range()].fill(n);
        }
        let of = |&c: &usize| {
            let node = &self.nodes[owner[c]];
            (owner[c], node.position, c - node.first, self.kinds[c])
        };
        self.coordinates.iter().map(of).collect()
    }

    /// Whether a map may give coordinates another meaning.
    pub(crate) fn rewrites(&self) -> bool {
        let rewrites = |n: &u32| match &self.nodes[*n as usize].source {
            Source::Mapped(d) => d.map.rewrites(),
            Source::Own => false,
        };
        self.dependent.iter().any(rewrites)
    }

    /// Residual and configuration at a state in motion.
    pub(crate) fn snapshot(&mut self, s: &State) -> Result<Snapshot, SystemError> {
        let mut r = vec![0.0; s.x.len()];
        let [q, v, a] = [&s.x, &s.v, &s.a].map(|x| x.as_slice());
        self.evaluate(Point { t: s.t, q, v, a }, Evaluation::residual(&mut r))?;
        let direction = Vector3::new(0.48, -0.6, 0.64);
        let frames = self.frames().map(|(n, _)| {
            let n = self.node_state(n);
            [
                n.position,
                n.R * direction,
                n.velocity,
                n.omega,
                n.acceleration,
            ]
        });
        Ok(Snapshot {
            frames: frames.collect(),
            r,
        })
    }

    /// The power of elements that exert forces at rest but tell of no energy: control forces, say.
    /// They count as loads, in the configuration last evaluated in motion.
    pub(crate) fn silent_power(&mut self, t: f64) -> Result<f64, SystemError> {
        let w = &mut self.work;
        let mut power = 0.0;
        for e in self.elements.iter().filter(|e| !e.element.is_load()) {
            let local = &mut w.local;
            local.gather(e, &self.spans, &w.x);
            let n = e.element.dim();
            let rest = local.motion(e, t, true);
            if e.element.energy(&rest) != 0.0 {
                continue;
            }
            local.gather_rates(e, &self.spans, Some([&w.v, &w.a]));
            local.switch(e, &self.nodes);
            local
                .momenta(e, t, true)
                .map_err(|error| named(error, &e.name))?;
            power += (0..n).map(|i| local.r[i] * local.v[i]).sum::<f64>();
        }
        Ok(power)
    }
}

/// What a model answers that does not depend on the charts of its nodes, and the residual.
pub(crate) struct Snapshot {
    /// Residual of the unknowns, in their charts.
    pub r: Vec<f64>,
    /// Of every frame: position, a direction that turns with it, velocity, angular velocity,
    /// acceleration.
    pub frames: Vec<[Vector3<f64>; 5]>,
}

impl Node {
    /// Its coordinates in groups: which, what they are called, what they measure.
    fn groups(&self) -> Vec<(std::ops::Range<usize>, String, Kind)> {
        let name = &self.name;
        match self.form {
            Form::Frame => vec![
                (0..3, format!("displacement of node {name}"), Kind::Length),
                (3..6, format!("rotation of node {name}"), Kind::Angle),
            ],
            Form::Rotation => vec![(0..3, name.clone(), Kind::Angle)],
            Form::Increment | Form::Coordinates | Form::Multipliers | Form::Idle => (0..self.dim)
                .map(|k| (k..k + 1, self.coordinate_name(k), self.kinds[k]))
                .collect(),
        }
    }
}

fn group(
    node: &Node,
    range: std::ops::Range<usize>,
    name: String,
    kind: Kind,
    length: f64,
) -> Group {
    let measured = kind == Kind::Length;
    Group {
        name,
        range,
        unit: if measured { length } else { 1.0 },
        reach: if measured {
            node.position.norm() / length
        } else {
            0.0
        },
    }
}
