//! Orders of a motion with an equation between coordinates enforced by a multiplier (index 3).

use super::run;
use crate::Report;
use pullback_integrators::dynamics::{DynamicsError, Progress, Scheme, start};
use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{
    CoordinateInfo, Energetics, Energies, Evaluation, Point, Quantity, System, SystemError,
};

/// A charged mass held to a circle by a multiplier, with a spring to the line y = 0, damping, a magnetic field and a driving
/// force, in Cartesian coordinates:
///
/// ```text
/// m ẍ + c ẋ + b e₃ × ẋ + k y e₂ + λ x = f(t),   h(x) = ½ (x·x − 1) = 0
/// ```
///
/// with the f(t) for which x = (cos θ, sin θ), θ(t) and λ(t) are [`Circle::motion`]. By the field, velocities that do not satisfy
/// ḣ = 0 disturb accelerations along the circle. The unknowns are x, y and λ.
struct Circle {
    pattern: BlockPattern,
}

const MASS: f64 = 1.3;
const DAMPING: f64 = 0.2;
const FIELD: f64 = 0.7;
const SPRING: f64 = 2.0;

impl Circle {
    fn new() -> Self {
        Self {
            pattern: BlockPattern::dense(3).with_coordinates(|i| CoordinateInfo {
                quantity: [Quantity::Length, Quantity::Length, Quantity::Other][i],
                is_multiplier: i == 2,
                ..CoordinateInfo::default()
            }),
        }
    }

    /// x, ẋ and ẍ, and λ.
    fn motion(t: f64) -> ([[f64; 2]; 3], f64) {
        let (sin, cos) = (1.7 * t + 0.4).sin_cos();
        let [angle, rate, change] = [0.3 + 0.9 * sin, 0.9 * 1.7 * cos, -0.9 * 1.7 * 1.7 * sin];
        let (s, c) = angle.sin_cos();
        let x = [c, s];
        let v = [-s * rate, c * rate];
        let a = [-s * change - c * rate * rate, c * change - s * rate * rate];
        ([x, v, a], 1.5 + (2.3 * t + 0.2).sin())
    }

    /// m ẍ + c ẋ + b e₃ × ẋ + k y e₂ + λ x.
    fn side([x, v, a]: [[f64; 2]; 3], lambda: f64) -> [f64; 2] {
        [0, 1].map(|i| {
            let spring = if i == 1 { SPRING * x[1] } else { 0.0 };
            let field = FIELD * [-v[1], v[0]][i];
            MASS * a[i] + DAMPING * v[i] + field + spring + lambda * x[i]
        })
    }

    /// f.
    fn force(t: f64) -> [f64; 2] {
        let (motion, lambda) = Self::motion(t);
        Self::side(motion, lambda)
    }
}

impl System for Circle {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    /// The equations of motion, and in the last row minus the enforced equation, or for accelerations its second
    /// derivative; the weight of the tangent of this row and of λ is that of K or of M.
    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let twice = out.accelerations.is_some();
        let of = |z: &[f64]| [z[0], z[1]];
        let (x, v, a, lambda) = (of(at.q), of(at.v), of(at.a), at.q[2]);
        let (side, f) = (Self::side([x, v, a], lambda), Self::force(at.t));
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        out.r[0] = f[0] - side[0];
        out.r[1] = f[1] - side[1];
        out.r[2] = match twice {
            true => -(dot(v, v) + dot(x, a)),
            false => -0.5 * (dot(x, x) - 1.0),
        };
        let Some((w, S)) = out.S else { return Ok(()) };
        let held = if twice { w.M } else { w.K };
        S.fill(0.0);
        for i in 0..2 {
            // Column by column.
            S[3 * i + i] = w.M * MASS + w.C * DAMPING + w.K * lambda;
            S[3 * i + 2] = held * x[i];
            S[3 * 2 + i] = held * x[i];
        }
        S[3 + 1] += w.K * SPRING;
        S[3] -= w.C * FIELD;
        S[1] += w.C * FIELD;
        Ok(())
    }

    fn energetics(&mut self) -> Option<&mut dyn Energetics> {
        Some(self)
    }
}

impl Energetics for Circle {
    fn energies(&mut self, at: Point<'_>) -> Result<Energies, SystemError> {
        let (v, f) = (at.v, Self::force(at.t));
        let square = v[0] * v[0] + v[1] * v[1];
        Ok(Energies {
            kinetic: 0.5 * MASS * square,
            stored: 0.5 * SPRING * at.q[1] * at.q[1],
            supplied: f[0] * v[0] + f[1] * v[1],
            dissipated: DAMPING * square,
            ..Energies::default()
        })
    }
}

/// The largest errors of position, velocity, acceleration and multiplier at t = 0.8, after `first` steps, and at three
/// later times: the disturbance of the first steps has decayed by then, and errors that are zero by chance are so at
/// one time only.
fn errors(scheme: &Scheme, first: usize) -> Result<[f64; 4], DynamicsError> {
    let mut system = Circle::new();
    let ([x, v, _], _) = Circle::motion(0.0);
    let state = start(&system, 0.0, &[x[0], x[1], 0.0], &[v[0], v[1], 0.0])?;
    let mut progress = Progress::new(state);
    let mut errors = [0.0_f64; 4];
    for to in [0.8, 0.9, 1.0, 1.1] {
        let steps = if to == 0.8 { first } else { first / 8 };
        run(&mut system, scheme, &mut progress, to, steps)?;
        let found = &progress.state;
        let ([x, v, a], lambda) = Circle::motion(to);
        let gap = |found: &[f64], exact: [f64; 2]| (found[0] - exact[0]).hypot(found[1] - exact[1]);
        let here = [
            gap(&found.q, x),
            gap(&found.v, v),
            gap(&found.a, a),
            (found.q[2] - lambda).abs(),
        ];
        errors = [0, 1, 2, 3].map(|k| errors[k].max(here[k]));
    }
    Ok(errors)
}

/// Orders with a multiplier are the stated ones ([`Scheme::orders_with_multipliers`]), neither less nor more. Schemes
/// without damping at infinite frequencies refuse multipliers, and no others.
pub(crate) fn orders(report: &mut Report, scheme: &Scheme) {
    let (law, at) = ("orders with multipliers", "a mass on a circle");
    let runs = [80, 160].map(|steps| errors(scheme, steps));
    let [coarse, fine] = match runs {
        [Ok(coarse), Ok(fine)] => [coarse, fine],
        [Err(DynamicsError::Undamped { rho, .. }), _] => {
            return report.defect(law, "refused", (1.0 - rho).max(0.0), 1e-6);
        }
        [Err(error), _] | [_, Err(error)] => {
            return report.impossible(law, at, error.to_string());
        }
    };
    let [position, velocity] = scheme.orders_with_multipliers();
    let expected = [
        ("position", position),
        ("velocity", velocity),
        ("acceleration", velocity),
        ("multiplier", velocity),
    ];
    for (k, (what, order)) in expected.into_iter().enumerate() {
        let slope = (coarse[k] / fine[k]).log2();
        report.rate(law, what, slope, order as f64);
        let at = format!("{what}, and no more");
        report.defect(law, &at, slope - order as f64, 0.3);
    }
}
