//! Equations that no coordinate changes: refused at the start, with the reason.

use crate::support::*;

/// Powers of the equation of the unit circle, c = x² + y² − 1, and others beside it.
#[derive(Clone, Copy, Debug)]
enum Circle {
    /// c.
    Plain,
    /// c², c²: zero on the circle, where their gradients vanish.
    Squares,
    /// c³, c³.
    Cubes,
    /// c and its square, which follows from it.
    BothWays,
    /// c and 0.
    Nothing,
}

impl Implicit<2, 2> for Circle {
    fn h<S: Scalar>(&self, _t: S, x: &SVector<S, 2>) -> SVector<S, 2> {
        let c = x[0] * x[0] + x[1] * x[1] - 1.0;
        let [first, second] = match self {
            Self::Plain => [c, c * 2.0],
            Self::Squares => [c * c, c * c],
            Self::Cubes => [c * c * c, c * c * c],
            Self::BothWays => [c, c * c],
            Self::Nothing => [c, S::zero()],
        };
        SVector::<S, 2>::new(first, second)
    }
}

fn solved(h: Circle, guess: [f64; 2]) -> Result<ImplicitMap, ImplicitError> {
    ImplicitMap::of(h, 1, 0.0, guess, Choice::Split)
}

#[test]
fn a_gradient_that_vanishes_where_the_guess_is() {
    for h in [Circle::Plain, Circle::Squares] {
        let error = solved(h, [0.0, 0.0]).err().unwrap();
        assert!(matches!(error, ImplicitError::Flat { .. }), "{error}");
    }
    let error = solved(Circle::Plain, [0.0, 0.0]).err().unwrap();
    let expected = "h1 is -1.000e0 and does not change with any coordinate at the point that was \
                    given or reached: start from elsewhere, unless the parts do not fit together";
    assert_eq!(error.to_string(), expected);
}

#[test]
fn a_gradient_that_vanishes_on_all_solutions() {
    for h in [Circle::Squares, Circle::Cubes] {
        for guess in [[0.6, 0.7], [0.6, 0.8], [1.0, 0.0], [-0.3, 2.0]] {
            let error = solved(h, guess).err().unwrap();
            assert!(matches!(error, ImplicitError::Touching { .. }), "{error}");
            let said = error.to_string();
            let named = ["h1", "h2"].map(|h| said.starts_with(&format!("{h} does not change")));
            assert!(named[0] || named[1], "{said}");
        }
    }
}

/// What follows from the others may vanish with its gradient.
#[test]
fn what_is_redundant_may_touch_zero() {
    for h in [Circle::Plain, Circle::BothWays, Circle::Nothing] {
        for guess in [[0.6, 0.7], [0.6, 0.8], [1.0, 0.0], [-0.3, 2.0]] {
            let map = solved(h, guess).unwrap();
            let [x, _] = tangent(&map, 0.0, &[0.0]);
            assert!((x[0].hypot(x[1]) - 1.0).abs() < 1e-12);
            assert_eq!(map.redundant().len(), 1);
        }
    }
}
