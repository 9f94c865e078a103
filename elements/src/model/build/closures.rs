//! Loops that are closed by multipliers or a penalty between two frames.

use crate::constraint::{Multipliers, Penalty, PenaltyStiffness};
use crate::element::Element;
use crate::model::build::builder::{ModelBuilder, NodeId};
use crate::model::loops::{Closing, Coincide, EQUATIONS, LoopReport};
use crate::model::{ModelError, NodeForm};
use nalgebra::SVector;
use pullback_manifold::domain::DomainError;
use pullback_manifold::map::Map;
use pullback_manifold::scalar::Scalar;
use pullback_manifold::system::Quantity;

/// Method of closing a loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Closure {
    /// A map: coordinates of joints along the loop follow from independent ones.
    #[default]
    Map,
    /// Lagrange multipliers of the same six equations, as unknowns of the model: index 3, for
    /// schemes with damping at infinite frequencies.
    Multipliers,
    /// Springs and dampers: `p` is the stiffness (force over length) against the gap; against the
    /// relative rotation it is p L², L the size of the model.
    Penalty(PenaltyStiffness),
}

impl ModelBuilder {
    /// As [`ModelBuilder::close`], with another method.
    ///
    /// Multipliers and penalties act between the two frames: a free child stays free, and the loop may
    /// contain bodies that fly freely. Both methods enforce the equations of the map: the gap in the
    /// child's axes over the size of the model, and twice the vector part of the quaternion between the
    /// frames. An analysis of such a model starts from [`Model::initial`](crate::model::Model::initial), or
    /// from another start after [`Context::project_state`](crate::model::Context::project_state).
    ///
    /// # Errors
    /// As [`ModelBuilder::close`]; [`ModelError::Penalty`].
    pub fn close_by(
        &mut self,
        frame: NodeId,
        child: NodeId,
        by: Closure,
    ) -> Result<(), ModelError> {
        self.check_own(&[frame, child], || "a loop".to_owned())?;
        let is_frame = |n: NodeId| self.nodes[n.0 as usize].is_frame();
        if frame == child || !is_frame(frame) || !is_frame(child) {
            return Err(ModelError::NotFrames {
                first: self.node_name(frame).to_owned(),
                second: self.node_name(child).to_owned(),
            });
        }
        let [a, b] = [frame, child].map(|n| &self.nodes[n.0 as usize]);
        let joint = match a.is_view() {
            true => &self.nodes[a.partner as usize],
            false => a,
        };
        let mut parents = joint.all_parents();
        let own_parent = match self.carried.iter().find(|[_, joint]| *joint == frame) {
            Some([parent, _]) => *parent == child,
            None => parents.any(|m| [child.0, b.partner].contains(&m)),
        };
        if own_parent {
            return Err(ModelError::OwnParent {
                joint: a.name.clone(),
                child: b.name.clone(),
            });
        }
        if let Closure::Penalty(stiffness) = by {
            let probe = Coincide::default();
            Penalty::<_, 12, 6>::new(probe, stiffness).map_err(|source| ModelError::Penalty {
                joint: self.node_name(frame).to_owned(),
                source,
            })?;
        }
        self.closings.push(Closing { frame, child, by });
        Ok(())
    }

    /// Adds `count` multipliers, unknowns without mass, for
    /// [`Multipliers`](crate::constraint::Multipliers).
    ///
    /// # Errors
    /// [`ModelError::DuplicateNode`].
    pub fn multipliers(
        &mut self,
        name: impl Into<String>,
        count: usize,
    ) -> Result<NodeId, ModelError> {
        let quantities = vec![Quantity::Other; count];
        self.add_coordinates_of(name, NodeForm::Multipliers, &quantities)
    }

    /// Adds the elements of all closures by multipliers or penalties, in a model of this size;
    /// returns the report on each, and these closures.
    pub(in crate::model) fn enforce_closings(
        &mut self,
        length: f64,
    ) -> Result<(Vec<LoopReport>, Vec<Closing>), ModelError> {
        let closings: Vec<Closing>;
        (self.closings, closings) = (self.closings.drain(..)).partition(|c| c.by == Closure::Map);
        let mut reports = Vec::new();
        for &Closing { frame, child, by } in &closings {
            let name = self.node_name(frame).to_owned();
            let apart = self.position(frame) - self.position(child);
            let closed = |most| Closed {
                between: Coincide { apart },
                scale: length.recip(),
                most,
            };
            let mut nodes = vec![frame, child];
            let mut words = format!("joint {name}: closed by multipliers");
            let element: Box<dyn Element> = match by {
                Closure::Penalty(PenaltyStiffness { p, tau }) => {
                    let p_l2 = p * length * length;
                    let made =
                        Penalty::<_, 12, 6>::new(closed(TORN), PenaltyStiffness { p: p_l2, tau });
                    let made = made.map_err(|source| ModelError::Penalty {
                        joint: name.clone(),
                        source,
                    })?;
                    words = format!("joint {name}: closed by a penalty of {p:e}");
                    Box::new(made.named(&EQUATIONS))
                }
                Closure::Map | Closure::Multipliers => {
                    // A frame may coincide with several.
                    let both = format!("{name} and {}", self.node_name(child));
                    nodes.push(self.multipliers(format!("multipliers of {both}"), 6)?);
                    Box::new(Multipliers::<_, 12, 6>::new(closed(f64::INFINITY)).named(&EQUATIONS))
                }
            };
            let id = self.element(format!("closure of {name}"), element, &nodes)?;
            reports.push(LoopReport {
                element: Some(id.0),
                ..LoopReport::say(words)
            });
        }
        Ok((reports, closings))
    }
}

/// Residual, relative to the size of its equation, beyond which a penalty counts as violated.
const TORN: f64 = 0.1;
/// Limit of a penalty in messages.
const OPEN: &str = "the neighbourhood of its closed position: its gap would be more than a tenth of the size \
                    of the model, as its penalty is too small for these loads, or no closed position carries \
                    them";

/// Two coinciding frames, gaps in units of the model.
struct Closed {
    between: Coincide,
    /// One over the length of the model.
    scale: f64,
    /// Largest residual: a penalty has other equilibria, at which a loop is torn open and its springs are at a dead point.
    most: f64,
}

impl Map<12, 6> for Closed {
    fn phi<S: Scalar>(&self, t: S, x: &SVector<S, 12>) -> SVector<S, 6> {
        let mut h = self.between.phi(t, x);
        h.iter_mut()
            .take(3)
            .for_each(|gap| *gap = *gap * self.scale);
        h
    }

    fn domain(&self, t: f64, x: &SVector<f64, 12>) -> Result<f64, DomainError> {
        match self.most {
            f64::INFINITY => Ok(self.most),
            most => DomainError::within(most - self.phi(t, x).amax(), OPEN),
        }
    }
}
