//! Requests that a system cannot meet, and systems without coordinates.

use crate::support::*;

/// Masses of one on springs of one, and an input u that loads them.
struct Loaded {
    pattern: BlockPattern,
    u: [f64; 1],
}

impl Loaded {
    fn new(n: usize) -> Self {
        let pattern = BlockPattern::new(&vec![1; n], [[0_u32; 0]; 0]);
        Self { pattern, u: [3.0] }
    }
}

impl System for Loaded {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        for (i, r) in out.r.iter_mut().enumerate() {
            *r = self.u[0] - at.q[i] - at.a.get(i).copied().unwrap_or(0.0);
        }
        if let Some((weights, S)) = out.S {
            S.fill(weights.K + weights.M);
        }
        if let Some(r_t) = out.r_t {
            r_t.fill(0.0);
        }
        Ok(())
    }

    fn events(&mut self) -> Option<&mut dyn Events> {
        Some(self)
    }
}

impl Events for Loaded {
    fn inputs(&mut self) -> &mut [f64] {
        &mut self.u
    }
}

fn diagram(input: usize, count: usize) -> Result<CampbellDiagram, CampbellError> {
    let options = CampbellOptions {
        t: 0.0,
        speeds: vec![1.0, 2.0],
        count,
        statics: StaticOptions::default(),
        rotor: None,
    };
    let mut observer = |_| ControlFlow::Continue(());
    let (mut system, mut q) = (Loaded::new(2), vec![0.0; 2]);
    campbell(&mut system, input, &mut q, &options, &mut observer)
}

#[test]
fn no_modes_are_not_searched_for() {
    let none = "the number of modes must be at least 1";
    refused! {
        buckling(&mut Loaded::new(2), Point::statics(0.0, &[3.0; 2]), 0) => [none],
        diagram(0, 0) => ["at a speed of 1", none],
    }
}

#[test]
#[should_panic = "index out of bounds"]
fn an_input_that_does_not_exist_has_no_diagram() {
    assert_eq!(diagram(0, 1).unwrap().lines.len(), 2);
    let _ = diagram(1, 1);
}

#[test]
fn outputs_without_coordinates_depend_on_inputs() {
    let square = |system: &mut Loaded, _: Point<'_>| Ok(vec![system.u[0].powi(2)]);
    let at = Point::statics(0.0, &[]);
    let found = output_derivatives(&mut Loaded::new(0), at, square).unwrap();
    assert_eq!(found.q.shape(), (1, 0));
    assert!((found.u[(0, 0)] - 6.0).abs() < 1e-12, "{}", found.u);
}

#[test]
fn without_outputs_nothing_is_differentiated() {
    let mut asked = 0;
    let none = |_: &mut Loaded, _: Point<'_>| {
        asked += 1;
        Ok(Vec::new())
    };
    let at = Point::statics(0.0, &[0.0; 50]);
    let found = output_derivatives(&mut Loaded::new(50), at, none).unwrap();
    assert_eq!([found.q.shape(), found.u.shape()], [(0, 50), (0, 1)]);
    assert!(asked < 50, "{asked} evaluations");
}

/// The unit of an input need not be the one that matters.
#[test]
fn derivatives_by_inputs_do_not_depend_on_units() {
    for size in [1e-6_f64, 1e-3, 1.0, 1e3] {
        let mut system = Loaded::new(1);
        system.u = [0.3 * size];
        let at = Point::statics(0.0, &[0.0]);
        let wave = |system: &mut Loaded, _: Point<'_>| {
            let x = system.u[0] / size;
            match x.abs() < 0.4 {
                true => Ok(vec![x.sin(), (x - 0.29).abs(), 1.0]),
                false => Err(SystemError::NotFinite {
                    what: "the rail".to_owned(),
                }),
            }
        };
        let found = output_derivatives(&mut system, at, wave).unwrap().u * size;
        for (found, exact) in found.iter().zip([0.3_f64.cos(), 1.0, 0.0]) {
            assert!((found - exact).abs() < 1e-9, "{size}: {found} {exact}");
        }
    }
}

/// Angles after many turns.
#[test]
fn derivatives_of_outputs_after_many_turns() {
    let mut system = Loaded::new(1);
    for turns in [0.0, 10.0, 1e3] {
        let q = [0.3 + turns * std::f64::consts::TAU];
        let at = Point::statics(0.0, &q);
        let sine = |_: &mut Loaded, at: Point<'_>| Ok(vec![at.q[0].sin()]);
        let found = output_derivatives(&mut system, at, sine).unwrap().q[(0, 0)];
        assert!((found - q[0].cos()).abs() < 1e-8, "{turns}: {found}");
    }
}

/// Outputs read the configuration at which the system was evaluated.
#[test]
fn outputs_read_the_system_at_their_point() {
    let mut system = Loaded::new(2);
    let at = Point::statics(0.0, &[0.0; 2]);
    let mut number = 0;
    let changing = |_: &mut Loaded, _: Point<'_>| {
        number += 1;
        Ok(vec![0.0; number])
    };
    let told = output_derivatives(&mut system, at, changing).unwrap_err();
    assert!(told.to_string().contains("outputs: expected 1"), "{told}");
    let of_other = output_derivatives(&mut Loaded::new(1), Point::statics(0.0, &[0.0]), |_, at| {
        Ok(at.q.to_vec())
    });
    let lin = linearize(&mut system, Point::statics(0.0, &[3.0; 2])).unwrap();
    let told = lin.state_space(&of_other.unwrap()).unwrap_err();
    assert!(told.to_string().contains("[1, 1]"), "{told}");
    let all = modes(&lin, &ModeOptions::lowest(usize::MAX)).unwrap();
    assert_eq!(all.modes.len(), 2);
    assert_eq!(diagram(0, usize::MAX).unwrap().lines.len(), 2);
}

#[test]
fn a_state_out_of_balance_or_without_numbers_is_refused() {
    let equations = |q: [f64; 2]| linearize(&mut Loaded::new(2), Point::statics(0.0, &q));
    // q = u.
    assert!(equations([3.0; 2]).is_ok());
    refused! { equations([3.0, 1.0]) => ["the state is not in balance: ", " is 2.000e0, "] }
    let refused = equations([3.0, f64::NAN]).unwrap_err();
    let unknown = matches!(refused, LinearizationError::System(_));
    assert!(unknown, "{refused}");
}
