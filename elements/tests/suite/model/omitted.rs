//! Redundant equations of an element, which a model omits.

use crate::support::*;
use pullback_elements::constraint::Multipliers;

/// x = 0 and x = a multiple of t.
#[derive(Clone, Copy)]
struct Twice(f64);

impl Map<1, 2> for Twice {
    fn phi<S: Scalar>(&self, t: S, x: &SVector<S, 1>) -> SVector<S, 2> {
        SVector::<S, 2>::new(x[0], x[0] - t * self.0)
    }
}

type Plain = Multipliers<Twice, 1, 2>;

/// The same with a combined tangent of its own, K for a weight of one.
struct Fast(Plain);

impl Element for Fast {
    fn dim(&self) -> usize {
        3
    }

    fn evaluate(&self, at: &Motion<'_>, out: &mut Response<'_>) -> Result<(), DomainError> {
        self.0.evaluate(at, out)
    }

    fn abilities(&self) -> Abilities<'_> {
        Abilities {
            combined: Some(self),
            ..self.0.abilities()
        }
    }
}

impl Combined for Fast {
    fn add(
        &self,
        at: &Motion<'_>,
        r: &mut [f64],
        tangents: &mut CombinedTangents<'_>,
    ) -> Result<(), DomainError> {
        let [Some((weights, S)), None, None] = tangents else {
            panic!("one combined tangent");
        };
        assert_eq!(weights.K, 1.0);
        let (K, r_t, C, M) = (Some(&mut **S), None, None, None);
        self.0.evaluate(at, &mut Response { r, K, C, M, r_t })
    }
}

/// A coordinate and two multipliers with an element.
fn held(element: impl Element + 'static) -> Context {
    let mut b = ModelBuilder::new();
    let x = b.coordinates("x", &[Quantity::Length]).unwrap();
    let lambda = b.multipliers("force", 2).unwrap();
    b.element("held", element, &[x, lambda]).unwrap();
    Context::new(b.build().unwrap())
}

/// Residual and tangent in motion.
fn evaluate(element: impl Element + 'static) -> [Vec<f64>; 2] {
    let mut context = held(element);
    let (q, rest) = ([0.3, 1.2, -0.7], [0.0; 3]);
    let mut r = vec![0.0; 3];
    let mut S = vec![0.0; context.pattern().len()];
    let at = point(0.0, [&q, &rest, &rest]);
    let out = Evaluation::with_tangent(&mut r, Weights::STATIC, &mut S);
    context.evaluate(at, out).unwrap();
    [r, S]
}

#[test]
fn a_combined_tangent_omits_them_as_well() {
    let [r, S] = evaluate(Plain::new(Twice(0.0)));
    // One multiplier holds x, the other one is zero: its row is −λ.
    let rows = [[-1.2, -0.3, 0.7], [0.7, -1.2, -0.3]];
    assert!(rows.iter().any(|row| r == row), "{r:?}");
    assert_eq!(evaluate(Fast(Plain::new(Twice(0.0)))), [r, S]);
}

/// A state that is restored has not violated them yet.
#[test]
fn what_they_violate_is_forgotten_with_the_state() {
    let mut context = held(Plain::new(Twice(1.0)));
    let evaluate = |context: &mut Context, t: f64| {
        let mut r = [0.0; 3];
        context.evaluate(Point::statics(t, &[0.0; 3]), Evaluation::residual(&mut r))
    };
    evaluate(&mut context, 0.0).unwrap();
    let saved = context.save();
    // Charts and equations that are not there.
    let mut wrong = saved.clone();
    wrong.element_charts[0] = u32::MAX;
    assert!(!context.restore(&wrong));
    let mut wrong = saved.clone();
    *wrong.maps.last_mut().unwrap().last_mut().unwrap() = 4.0;
    assert!(!context.restore(&wrong));
    assert!(context.restore(&saved));
    // Half way between the two, whichever is left out.
    context.change_charts(1.0, &mut [0.5, 0.0, 0.0], &mut [], &mut []);
    let error = evaluate(&mut context, 1.0).unwrap_err().to_string();
    let why = "though it followed from the other equations at the start";
    assert!(error.contains(why), "{error}");
    assert!(context.restore(&saved));
    evaluate(&mut context, 0.0).unwrap();
}
