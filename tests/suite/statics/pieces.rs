//! A bead on a track of two pieces, by maps that contain the one which changes its piece.

use crate::support::dynamics::spring;
use pullback::elements::constraint::{Multipliers, Penalty, PenaltyStiffness};
use pullback::elements::energy::EnergyElement;
use pullback::elements::load::CoordinateForce;
use pullback::integrators::linearization::{ModeOptions, linearize, modes};
use pullback::manifold::implicit::{Choice, Description, Equation, ImplicitMap, Unknown};
use pullback::manifold::map::{Linear, Map, MapGraph, MapState, Parametrization, Read};
use pullback::manifold::system::{ChartChanges, Point};
use pullback::prelude::*;

/// Height y of the track, 0 up to x = 1 and ½ (x − 1)² beyond, up to x = 2: the second coordinate of x ↦ (x, y), or the gap of
/// (x, y).
#[derive(Clone)]
struct Track<const D: usize> {
    beyond: bool,
}

impl<const D: usize> Track<D> {
    const START: Self = Self { beyond: false };

    fn height<S: Scalar>(&self, x: S) -> S {
        match self.beyond {
            true => (x - 1.0).powi(2) * 0.5,
            false => S::zero(),
        }
    }

    fn end(x: f64) -> Result<f64, DomainError> {
        DomainError::within(2.0 - x, "the track")
    }
}

impl Map<1, 2> for Track<1> {
    fn phi<S: Scalar>(&self, _t: S, q: &SVector<S, 1>) -> SVector<S, 2> {
        SVector::<S, 2>::new(q[0], self.height(q[0]))
    }

    fn domain(&self, _t: f64, q: &SVector<f64, 1>) -> Result<f64, DomainError> {
        Self::end(q[0])
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl Map<2, 1> for Track<2> {
    fn phi<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 1> {
        SVector::<S, 1>::new(x[1] - self.height(x[0]))
    }

    fn domain(&self, _t: f64, x: &SVector<f64, 2>) -> Result<f64, DomainError> {
        Self::end(x[0])
    }

    fn state(&mut self) -> Option<&mut dyn MapState> {
        Some(self)
    }
}

impl<const D: usize> MapState for Track<D> {
    fn change_charts(&mut self, _t: f64, q: &[f64]) -> ChartChanges {
        let before = std::mem::replace(&mut self.beyond, q[0] > 1.0);
        let residual = before != self.beyond;
        ChartChanges {
            charts: usize::from(residual),
            residual,
        }
    }

    fn save(&self) -> Vec<f64> {
        vec![f64::from(u8::from(self.beyond))]
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        self.beyond = saved == [1.0];
        saved.len() == 1
    }
}

/// A spring of stiffness 4 along x, and a weight of 9.81.
struct Bead;

impl EnergyElement<2> for Bead {
    fn potential<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> S {
        x[0] * x[0] * 2.0 + x[1] * 9.81
    }
}

/// The equations of the track solved for y.
fn solved() -> ImplicitMap {
    let unknown = |name: &str, preference| Unknown {
        name: name.to_owned(),
        size: 1.0,
        start: None,
        preference,
    };
    let about = Description {
        unknowns: vec![unknown("x", 1.0), unknown("y", 0.0)],
        equations: vec![Equation {
            name: "track".to_owned(),
            size: None,
        }],
        freedoms: Some(1),
        choice: Choice::Fixed,
        ..Description::default()
    };
    ImplicitMap::new(Track::<2>::START.boxed(), about, 0.0, &[]).unwrap()
}

fn maps() -> [Box<dyn Parametrization>; 3] {
    let mut graph = MapGraph::new(1);
    graph.add(Track::<1>::START.boxed(), vec![(Read::Input(0), 1)]);
    [
        Track::<1>::START.boxed(),
        Box::new(graph.with_outputs(1)),
        Box::new(solved()),
    ]
}

#[test]
fn a_change_of_piece_changes_the_residual() {
    for mut map in maps() {
        let state = map.state().unwrap();
        assert!(!state.change_charts(0.0, &[0.5]).residual);
        assert!(state.change_charts(0.0, &[1.5]).residual);
        assert!(!state.change_charts(0.0, &[1.6]).residual);
    }
}

/// The bead under a force 10 t, in equilibrium at x = 5t/2 and, beyond 1, at (10 t + 9.81)/13.81.
#[test]
fn equilibria_beyond_a_change_of_piece() {
    for map in maps() {
        let mut b = ModelBuilder::new();
        let q = b.coordinates("q", &[Quantity::Length]).unwrap();
        let x = b
            .mapped_coordinates("x", &[Quantity::Length; 2], map, &[q])
            .unwrap();
        b.element("bead", Bead.into_element(), &[x]).unwrap();
        let along = Linear::<2, 1>::pick(0, 0.0).boxed();
        let along = b.mapped_coordinates("along", &[Quantity::Length], along, &[x]);
        let force = CoordinateForce::new(Proportional(10.0));
        b.element("force", force, &[along.unwrap()]).unwrap();
        let mut context = Context::new(b.build().unwrap());
        let options = StaticOptions {
            to: 0.45,
            first_step: 0.15,
            max_step: 0.15,
            ..StaticOptions::default()
        };
        let mut run = LoadSteps::new(&mut context, Vec::new(), &options).unwrap();
        let mut last = 0.0;
        while let Some(step) = run.step().unwrap() {
            last = step.q[0];
        }
        assert!((last - (4.5 + 9.81) / 13.81).abs() < 1e-9, "{last}");
    }
}

#[test]
fn equations_end_with_the_domain_of_their_map() {
    for (x, inside) in [(1.9, true), (2.1, false)] {
        let evaluates = |element: &dyn pullback::elements::element::Element| {
            let mut r = vec![0.0; element.dim()];
            let x = [x, 0.0, 1.0];
            let at = pullback::elements::element::Motion {
                t: 0.0,
                inputs: &[],
                x: &x[..element.dim()],
                v: &[],
                a: &[],
                previous: None,
            };
            let mut out = pullback::elements::element::Response {
                r: &mut r,
                K: None,
                C: None,
                M: None,
                r_t: None,
            };
            element.evaluate(&at, &mut out).is_ok()
        };
        let h = || Track::<2>::START;
        let stiffness = PenaltyStiffness { p: 1.0, tau: 0.0 };
        assert_eq!(evaluates(&Multipliers::<_, 2, 1>::new(h())), inside);
        let penalty = Penalty::<_, 2, 1>::new(h(), stiffness).unwrap();
        assert_eq!(evaluates(&penalty), inside);
        assert_eq!(solved().domain(0.0, &[x]).is_ok(), inside);
    }
}

/// A joint that turns by itself with the load parameter.
#[derive(Clone)]
struct Turning;

impl Joint<2> for Turning {
    fn pose<S: Scalar>(&self, t: S, q: &SVector<S, 2>) -> Pose<S> {
        let turn = Quaternion::about(&Vector3::z(), q[0] + t * 3.0);
        let out = Vector3::new(q[1] + 1.0, S::zero(), S::zero());
        Pose::identity().rotated(&turn).translated(&out)
    }

    fn coordinates(&self) -> [JointCoordinate; 2] {
        [("angle", Quantity::Angle), ("length", Quantity::Length)]
    }
}

/// A mass of 2 at the radius 1 on springs of 10 and 20 is linearised at rest, where nothing turns: ω² = 5 and 10.
#[test]
fn joints_that_follow_the_load_parameter_rest_in_statics() {
    let mut b = ModelBuilder::new();
    let ground = b.node("ground", [0.0; 3]).unwrap();
    b.support(ground, &Dof::ALL);
    let joint = b.attach("joint", ground, Turning).unwrap();
    b.element("mass", PointMass::new(2.0).unwrap(), &[joint.frame])
        .unwrap();
    for (k, coordinate) in [10.0, 20.0].into_iter().zip(joint.coordinates) {
        spring(&mut b, k, coordinate);
    }
    let mut context = Context::new(b.build().unwrap());
    let lin = linearize(&mut context, Point::statics(0.5, &[0.0; 2])).unwrap();
    assert!(lin.C.iter().all(|c| *c == 0.0), "{:?}", lin.C);
    let found = modes(&lin, &ModeOptions::lowest(2)).unwrap();
    for (mode, square) in found.modes.iter().zip([5.0, 10.0]) {
        assert!((mode.omega().powi(2) - square).abs() < 1e-12 * square);
    }
    assert_eq!(found.modes.len(), 2);
}
