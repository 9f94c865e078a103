//! The conformance kit fails when it should: errors planted in forces and in an assembly.

use crate::support::*;
use pullback_conformance::Forces;

/// Errors of a small nonlinear law of forces in three coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    Right,
    K,
    C,
    MissingM,
    Rate,
    Energy,
    NotSymmetric,
    Nowhere,
}

/// r = p(t) − ∇E(x) − |v|² v − m(x) a with E = (1 + x·x)², m = 1 + x·x.
fn law(case: Law, s: &TestState) -> Option<Forces> {
    if case == Law::Nowhere {
        return None;
    }
    let n = s.x.len();
    let one = DMatrix::<f64>::identity(n, n);
    let u = 1.0 + s.x.dot(&s.x);
    let load = DVector::from_element(n, (2.0 * s.t).sin());
    let mut r = &load - &s.x * (4.0 * u);
    let mut K = &one * (4.0 * u) + &s.x * s.x.transpose() * 8.0;
    let mut C = DMatrix::zeros(n, n);
    let mut M = C.clone();
    if !s.is_static() {
        r -= &s.v * s.v.dot(&s.v) + &s.a * u;
        K += &s.a * s.x.transpose() * 2.0;
        C = &one * s.v.dot(&s.v) + &s.v * s.v.transpose() * 2.0;
        M = &one * u;
    }
    let mut r_t = DVector::from_element(n, 2.0 * (2.0 * s.t).cos());
    let mut energy = u * u - load.dot(&s.x);
    match case {
        Law::K => K[(0, 1)] += 1e-3,
        Law::C => C *= 0.5,
        Law::MissingM => M.fill(0.0),
        Law::Rate => r_t *= 0.5,
        Law::Energy => energy *= 1.001,
        Law::NotSymmetric => {
            r[0] -= 0.1 * s.x[1];
            K[(0, 1)] += 0.1;
        }
        _ => {}
    }
    Some(Forces {
        r,
        K,
        C,
        M,
        r_t: Some(r_t),
        energy: Some(energy),
    })
}

#[test]
fn every_law_of_forces_finds_its_error() {
    let report = |case| check::forces("law", 3, true, |s| law(case, s));
    report(Law::Right).assert();
    let cases: [(Law, &[&str]); 7] = [
        (Law::K, &["K = -dr/dx", "K symmetric"]),
        (Law::C, &["C = -dr/dv"]),
        (Law::MissingM, &["M = -dr/da"]),
        (Law::Rate, &["r_t = dr/dt"]),
        (Law::Energy, &["r = -dE/dx"]),
        (Law::NotSymmetric, &["K symmetric", "r = -dE/dx"]),
        (Law::Nowhere, &["domain"]),
    ];
    for (case, laws) in cases {
        assert_eq!(report(case).failing_laws(), laws, "{case:?}");
    }
}

/// The same law as a system of one dense block, with errors of an assembly.
struct Assembled {
    pattern: BlockPattern,
    error: Assembly,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Assembly {
    Right,
    NotOverwritten,
    WeightForgotten,
    Transposed,
    ResidualChanges,
    /// A symmetric one in which terms of 1e6 cancel.
    Cancels,
    /// The same, where an error is left.
    CancelsWrongly,
}

impl Assembly {
    fn cancels(self) -> bool {
        matches!(self, Self::Cancels | Self::CancelsWrongly)
    }
}

impl System for Assembled {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn is_symmetric(&self) -> bool {
        self.error.cancels()
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let vector = |x: &[f64]| DVector::from_column_slice(x);
        let s = TestState {
            t: at.t,
            x: vector(at.q),
            v: vector(at.v),
            a: vector(at.a),
        };
        let case = match self.error.cancels() {
            true => Law::Right,
            false => Law::NotSymmetric,
        };
        let Some(mut f) = law(case, &s) else {
            return Ok(());
        };
        if self.error.cancels() {
            let large = [1e6 * s.x[0], 1e6 / 3.0 * s.x[0] * 3.0];
            f.K[(0, 1)] = (f.K[(0, 1)] + large[0]) - large[1];
        }
        if self.error == Assembly::CancelsWrongly {
            f.K[(0, 1)] += 1e-7;
        }
        out.r.copy_from_slice(f.r.as_slice());
        let Some((w, values)) = out.S else {
            if let Some(r_t) = out.r_t {
                r_t.copy_from_slice(f.r_t.unwrap_or_default().as_slice());
            }
            return Ok(());
        };
        if self.error == Assembly::ResidualChanges {
            out.r[1] += 1e-9;
        }
        let mut S = f.K * w.K;
        let forgotten = self.error == Assembly::WeightForgotten && w.K != 0.0;
        let c = if forgotten { 1.0 } else { w.C };
        S += f.C * c + f.M * w.M;
        if self.error == Assembly::Transposed {
            S.transpose_mut();
        }
        if self.error != Assembly::NotOverwritten {
            values.fill(0.0);
        }
        for (value, s) in values.iter_mut().zip(S.iter()) {
            *value += s;
        }
        Ok(())
    }
}

#[test]
fn every_law_of_a_system_finds_its_error() {
    let report = |error| {
        let mut system = Assembled {
            pattern: BlockPattern::dense(3),
            error,
        };
        check::system("assembled", &mut system, &check::states(3))
    };
    report(Assembly::Right).assert();
    let failing = |error, law: &str| {
        let report = report(error);
        let found = report.failing_laws().contains(&law.to_owned());
        assert!(found, "{error:?}\n{report}");
    };
    failing(Assembly::NotOverwritten, "K = -dr/dx");
    failing(Assembly::WeightForgotten, "S = cK K + cC C + cM M");
    failing(Assembly::Transposed, "K = -dr/dx");
    // Rounding errors that change with the last digits of the coordinates are no asymmetry.
    report(Assembly::Cancels).assert();
    failing(Assembly::CancelsWrongly, "K symmetric");
    let law = "r does not depend on what else is requested";
    failing(Assembly::ResidualChanges, law);
}

/// A unit mass on the sphere |x|² = 2 t³ by a multiplier, h = ½ x·x − t³, with errors at the level of accelerations.
struct OnSphere {
    pattern: BlockPattern,
    error: Level,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Level {
    Right,
    NotRaised,
    WithoutVelocities,
    WithoutTime,
    NoRow,
    NoColumn,
}

impl System for OnSphere {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let raised = out.accelerations.is_some() && self.error != Level::NotRaised;
        let by = |on: bool| f64::from(u8::from(on));
        let (mut second, mut square) = (-6.0 * at.t * by(self.error != Level::WithoutTime), 0.0);
        for i in 0..at.q.len() - 1 {
            let a = if at.a.is_empty() { 0.0 } else { at.a[i] };
            let v = if at.v.is_empty() { 0.0 } else { at.v[i] };
            out.r[i] = -a - at.q[3] * at.q[i];
            square += at.q[i] * at.q[i];
            second += at.q[i] * a + v * v * by(self.error != Level::WithoutVelocities);
        }
        out.r[3] = if raised {
            -second
        } else {
            at.t.powi(3) - 0.5 * square
        };
        if let Some(r_t) = out.r_t {
            r_t.fill(0.0);
            r_t[3] = 3.0 * at.t * at.t;
        }
        let Some((w, values)) = out.S else {
            return Ok(());
        };
        values.fill(0.0);
        let held = if raised { w.M } else { w.K };
        for i in 0..3 {
            values[5 * i] = w.M + w.K * at.q[3];
            values[4 * i + 3] = at.q[i]
                * if self.error == Level::NoRow {
                    w.K
                } else {
                    held
                };
            values[12 + i] = at.q[i]
                * if self.error == Level::NoColumn {
                    w.K
                } else {
                    held
                };
        }
        Ok(())
    }
}

#[test]
fn equations_of_multipliers_are_differentiated_twice_for_accelerations() {
    let report = |error| {
        let gap = |i| CoordinateInfo {
            is_multiplier: i == 3,
            ..CoordinateInfo::default()
        };
        let pattern = BlockPattern::dense(4).with_coordinates(gap);
        let mut system = OnSphere { pattern, error };
        check::system("on a sphere", &mut system, &check::states(4))
    };
    report(Level::Right).assert();
    let [second, row] = [
        "d2h/dt2 for accelerations",
        "dh/dq with M for accelerations",
    ];
    for (error, laws) in [
        (Level::NotRaised, vec![second, row]),
        (Level::WithoutVelocities, vec![second]),
        (Level::WithoutTime, vec![second]),
        (Level::NoRow, vec![row]),
        (Level::NoColumn, vec![row]),
    ] {
        let found = report(error).failing_laws();
        assert_eq!(found, laws, "{error:?}");
    }
}

#[test]
fn dense_matrices_come_out_of_their_blocks() {
    let pattern = BlockPattern::new(&[2, 1, 3], [[0, 1], [1, 2]]);
    assert_eq!([pattern.dim(), pattern.blocks()], [6, 3]);
    assert_eq!(pattern.len(), 4 + 2 + 2 + 1 + 3 + 3 + 9);
    assert_eq!(pattern.find(0, 2), None);
    let values: Vec<f64> = (1..=pattern.len()).map(|k| k as f64).collect();
    let A = pattern.matrix(&values);
    // The second row of a block of one column.
    assert_eq!(A[(1, 2)], values[pattern.find(0, 1).unwrap() + 1]);
    let x: Vec<f64> = (0..6).map(|k| 1.0 + k as f64).collect();
    let mut y = vec![0.0; 6];
    pattern.multiply_add(2.0, &values, &x, &mut y);
    assert_eq!((A * 2.0 * DVector::from_vec(x)).as_slice(), y);
}
