//! Probes: quantities recorded at each step.

use crate::input::{Dimension, ProbeQuantity};
use nalgebra::Vector3;
use pullback_elements::element::SectionState;
use pullback_elements::model::{Context, ElementId, EnergiesAndMomentum, NodeId, Reaction};
use pullback_integrators::dynamics::Progress;
use pullback_manifold::system::{Quantity, SystemError};
use std::f64::consts::TAU;

/// The object of a probe.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Target {
    /// A node.
    Node(NodeId),
    /// An element.
    Element(ElementId),
    /// The coordinate that a joint releases.
    Joint(NodeId, Quantity),
    /// The whole model.
    Whole,
}

/// Which part of a vector is recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ProbeComponent {
    /// All three, with the ends of their column names.
    All([&'static str; 3]),
    /// One; the first of a scalar.
    One(usize),
    /// The Euclidean norm.
    Norm,
}

/// A probe of a model.
#[derive(Clone, Debug)]
pub struct Probe {
    name: String,
    pub(crate) quantity: ProbeQuantity,
    target: Target,
    component: ProbeComponent,
    /// Rotation vector at the last step, continued over changes of chart; the next value depends on it.
    pub(crate) continued: Vector3<f64>,
}

/// The quantities of a model at one step, evaluated once for all probes.
#[derive(Default)]
pub(crate) struct Answers {
    /// Strains and forces at all integration points.
    pub sections: Vec<(ElementId, SectionState)>,
    /// Reactions of all supported nodes, in the order of their names.
    pub reactions: Vec<Reaction>,
    pub strain_energy: f64,
    pub load_potential: f64,
    /// Energies, powers and momenta of a motion, and the defect of its energy balance.
    pub motion: Option<(EnergiesAndMomentum, f64)>,
}

impl Answers {
    /// Evaluates a model in its present configuration.
    pub fn of(context: &Context, t: f64) -> Self {
        let mut reactions = context.last_forces().reactions();
        reactions.sort_unstable_by(|a, b| a.node.cmp(&b.node));
        Self {
            sections: context.section_states(t),
            reactions,
            strain_energy: context.strain_energy(t),
            load_potential: context.load_potential(t),
            motion: None,
        }
    }

    /// Evaluates a model at the present state of a motion.
    pub fn of_motion(context: &mut Context, progress: &Progress) -> Result<Self, SystemError> {
        let balance = context.energies_and_momentum(progress.state.point())?;
        let defect = progress.summary.energy.map_or(0.0, |e| e.defect());
        Ok(Self {
            motion: Some((balance, defect)),
            ..Self::of(context, progress.state.t)
        })
    }

    /// A quantity of the whole model.
    fn whole(&self, quantity: ProbeQuantity) -> Vector3<f64> {
        let (balance, defect) = self.motion.unwrap_or_default();
        let kinetic = balance.energies.kinetic;
        match quantity {
            ProbeQuantity::momentum => balance.momentum.linear,
            ProbeQuantity::angular_momentum => balance.momentum.angular,
            ProbeQuantity::kinetic_energy => scalar(kinetic),
            ProbeQuantity::total_energy => {
                scalar(kinetic + self.strain_energy + self.load_potential)
            }
            ProbeQuantity::energy_defect => scalar(defect),
            _ => scalar(self.strain_energy),
        }
    }

    /// Mean over the integration points of an element; zero without any.
    pub fn mean(
        &self,
        id: ElementId,
        part: impl Fn(&SectionState) -> Vector3<f64>,
    ) -> Vector3<f64> {
        // The states are in the order of the elements.
        let first = self.sections.partition_point(|(e, _)| *e < id);
        let own = self.sections[first..].iter().take_while(|(e, _)| *e == id);
        let (sum, count) = own.fold((Vector3::zeros(), 0.0), |(sum, count), (_, state)| {
            (sum + part(state), count + 1.0)
        });
        if count > 0.0 { sum / count } else { sum }
    }
}

impl Probe {
    /// A probe before its first rotation.
    pub(crate) fn new(
        name: &str,
        quantity: ProbeQuantity,
        target: Target,
        component: ProbeComponent,
    ) -> Self {
        Self {
            name: name.to_owned(),
            quantity,
            target,
            component,
            continued: Vector3::zeros(),
        }
    }

    /// Continues a rotation over a step that is not recorded.
    pub(crate) fn follow(&mut self, context: &Context) {
        if let (ProbeQuantity::rotation, Target::Node(node)) = (self.quantity, &self.target) {
            self.continued = continue_rotation(&self.continued, &context.node_state(*node).psi);
        }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its dimension.
    pub(crate) fn dimension(&self) -> Dimension {
        let [force, length, time, angle] = self.quantity.dimension();
        match self.target {
            Target::Joint(_, quantity) if self.quantity == ProbeQuantity::joint_effort => {
                [force, i32::from(quantity == Quantity::Angle), time, angle]
            }
            Target::Joint(_, Quantity::Length) => [force, length + 1, time, angle],
            Target::Joint(_, Quantity::Angle) => [force, length, time, angle + 1],
            _ => [force, length, time, angle],
        }
    }

    /// Whether the configuration of the model has its value: no forces and energies are needed.
    pub(crate) fn is_kinematic(&self) -> bool {
        use ProbeQuantity as Q;
        match &self.target {
            Target::Joint(..) => self.quantity != Q::joint_effort,
            Target::Node(..) => !matches!(
                self.quantity,
                Q::reaction_force | Q::reaction_moment | Q::joint_force | Q::joint_moment
            ),
            Target::Element(_) | Target::Whole => false,
        }
    }

    /// Heads of its columns.
    pub fn columns(&self) -> Vec<String> {
        match self.component {
            ProbeComponent::All(ends) => ends.map(|end| format!("{}.{end}", self.name)).to_vec(),
            _ => vec![self.name.clone()],
        }
    }

    /// Appends its values at a converged step.
    pub(crate) fn record(&mut self, context: &Context, answers: &Answers, out: &mut Vec<f64>) {
        if self.quantity.is_dynamic() && context.is_at_rest() {
            // Rates in statics are those by the load parameter.
            out.resize(out.len() + self.columns().len(), 0.0);
            return;
        }
        let v = self.vector(context, answers);
        match self.component {
            ProbeComponent::All(_) => out.extend(v.iter()),
            ProbeComponent::One(k) => out.push(v[k]),
            ProbeComponent::Norm => out.push(v.norm()),
        }
    }

    fn vector(&mut self, context: &Context, answers: &Answers) -> Vector3<f64> {
        match &self.target {
            Target::Joint(node, _) if self.quantity == ProbeQuantity::joint_effort => {
                scalar(context.last_forces().joint_effort(*node))
            }
            Target::Joint(node, _) => {
                let rate = match self.quantity {
                    ProbeQuantity::joint_rate => 1,
                    ProbeQuantity::joint_acceleration => 2,
                    _ => 0,
                };
                let motion = context.coordinate(*node, 0);
                scalar(motion.map_or(f64::NAN, |x| x[rate]))
            }
            Target::Whole => answers.whole(self.quantity),
            Target::Element(id) => answers.mean(*id, |s| match self.quantity {
                ProbeQuantity::M => s.M,
                ProbeQuantity::Gamma => s.Gamma,
                ProbeQuantity::K => s.K,
                _ => s.N,
            }),
            Target::Node(node) => {
                let state = context.node_state(*node);
                let reaction = |part: fn(&Reaction) -> Vector3<f64>| {
                    let (all, name) = (&answers.reactions, context.node(*node).name());
                    let own = all.binary_search_by(|r| r.node.as_str().cmp(name));
                    own.map_or_else(|_| Vector3::zeros(), |k| part(&all[k]))
                };
                match self.quantity {
                    ProbeQuantity::position => state.position,
                    ProbeQuantity::chart_rotation => state.psi,
                    ProbeQuantity::rotation => {
                        self.continued = continue_rotation(&self.continued, &state.psi);
                        self.continued
                    }
                    ProbeQuantity::velocity => state.velocity,
                    ProbeQuantity::angular_velocity => state.omega,
                    ProbeQuantity::acceleration => state.acceleration,
                    ProbeQuantity::angular_acceleration => state.omega_dot,
                    ProbeQuantity::joint_force | ProbeQuantity::joint_moment => {
                        let k = usize::from(self.quantity == ProbeQuantity::joint_moment);
                        let force = context.last_forces().joint_force(*node);
                        force.map_or_else(Vector3::zeros, |both| both[k])
                    }
                    ProbeQuantity::reaction_force => reaction(|r| r.force),
                    ProbeQuantity::reaction_moment => reaction(|r| r.moment),
                    _ => state.d,
                }
            }
        }
    }
}

fn scalar(x: f64) -> Vector3<f64> {
    Vector3::new(x, 0.0, 0.0)
}

/// The rotation vector of the same rotation as `psi` that is closest to `before`: the family is
/// Ψ + 2πk e with e = Ψ/ψ (any e where Ψ = 0).
pub fn continue_rotation(before: &Vector3<f64>, psi: &Vector3<f64>) -> Vector3<f64> {
    let angle = psi.norm();
    if angle < 1e-9 {
        let turns = (before.norm() / TAU).round();
        return if turns == 0.0 {
            *psi
        } else {
            before.normalize() * (turns * TAU) + psi
        };
    }
    let e = psi / angle;
    let turns = ((e.dot(before) - angle) / TAU).round();
    psi + e * (turns * TAU)
}
