//! Systems with known motions.

use pullback_manifold::sparse::BlockPattern;
use pullback_manifold::system::{
    ChartChanges, Charts, Energetics, Energies, Evaluation, Point, System, SystemError,
};

/// Two masses that depend on their positions, coupled by a spring and gyroscopic forces, with damping and a force sin x:
///
/// ```text
/// (1 + ½ xᵢ²) ẍᵢ + ½ xᵢ ẋᵢ² + c ẋᵢ ∓ g ẋⱼ + 2 sin xᵢ + k (xᵢ − xⱼ) = fᵢ(t)
/// ```
///
/// with the f(t) for which the motion is [`KnownMotion::motion`]; or conservative, without damping, gyroscopic forces and f.
/// Coordinates are q = x, or in the other chart q with x = sinh q.
pub(crate) struct KnownMotion {
    pattern: BlockPattern,
    forced: bool,
    switching: bool,
    /// Whether x = sinh q.
    sinh_chart: bool,
    calls: usize,
}

const DAMPING: f64 = 0.3;
const GYROSCOPIC: f64 = 0.2;
const SPRING: f64 = 1.5;

impl KnownMotion {
    /// The driven motion, in one chart or with a change of chart every third step.
    pub fn new(switching: bool) -> Self {
        Self {
            pattern: BlockPattern::new(&[1, 1], [[0, 1]]),
            forced: true,
            switching,
            sinh_chart: false,
            calls: 0,
        }
    }

    /// The conservative system, whose motion is reversible.
    pub(crate) fn alone() -> Self {
        Self {
            forced: false,
            ..Self::new(false)
        }
    }

    /// x, ẋ and ẍ of the driven motion.
    pub fn motion(t: f64) -> [[f64; 2]; 3] {
        let parts = [[0.8, 1.3, 0.2], [-0.5, 2.1, 1.0]];
        let wave = |[a, w, p]: [f64; 3]| {
            let (sin, cos) = (w * t + p).sin_cos();
            [a * sin, a * w * cos, -a * w * w * sin]
        };
        let [one, two] = parts.map(wave);
        [0, 1, 2].map(|k| [one[k], two[k]])
    }

    /// x, ẋ and ẍ of coordinates, velocities and accelerations in the present chart.
    pub fn position(&self, [q, v, a]: [&[f64]; 3]) -> [[f64; 2]; 3] {
        let mut out = [[0.0; 2]; 3];
        for i in 0..2 {
            let [x, B, B_q, _] = map(self.sinh_chart, q[i]);
            out[0][i] = x;
            out[1][i] = B * v[i];
            out[2][i] = B * a[i] + B_q * v[i] * v[i];
        }
        out
    }

    /// Left side of the equation i, and its derivatives by x, ẋ and ẍ of both masses.
    fn side(&self, i: usize, [x, v, a]: [[f64; 2]; 3]) -> (f64, [[f64; 2]; 3]) {
        let j = 1 - i;
        let [c, g] = match self.forced {
            true => [DAMPING, if i == 0 { -GYROSCOPIC } else { GYROSCOPIC }],
            false => [0.0; 2],
        };
        let m = 1.0 + 0.5 * x[i] * x[i];
        let value = m * a[i]
            + 0.5 * x[i] * v[i] * v[i]
            + c * v[i]
            + g * v[j]
            + 2.0 * x[i].sin()
            + SPRING * (x[i] - x[j]);
        let mut by = [[0.0; 2]; 3];
        by[0][i] = x[i] * a[i] + 0.5 * v[i] * v[i] + 2.0 * x[i].cos() + SPRING;
        by[0][j] = -SPRING;
        by[1][i] = x[i] * v[i] + c;
        by[1][j] = g;
        by[2][i] = m;
        (value, by)
    }
}

/// x(q) and its derivatives up to the third, for x = sinh q or x = q.
fn map(sinh_chart: bool, q: f64) -> [f64; 4] {
    match sinh_chart {
        true => [q.sinh(), q.cosh(), q.sinh(), q.cosh()],
        false => [q, 1.0, 0.0, 0.0],
    }
}

impl System for KnownMotion {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        let position = self.position([at.q, at.v, at.a]);
        let maps = [0, 1].map(|i| map(self.sinh_chart, at.q[i]));
        let mut S = out.S;
        for i in 0..2 {
            let (side, by) = self.side(i, position);
            let drive = match self.forced {
                true => self.side(i, Self::motion(at.t)).0,
                false => 0.0,
            };
            let r = drive - side;
            out.r[i] = maps[i][1] * r;
            let Some((w, values)) = &mut S else { continue };
            for j in 0..2 {
                // The pull-back of the tangents.
                let [_, B, B_q, B_qq] = maps[j];
                let (v, a) = (at.v[j], at.a[j]);
                let [k, c, m] = [by[0][j], by[1][j], by[2][j]];
                let mut K = maps[i][1] * (k * B + c * B_q * v + m * (B_q * a + B_qq * v * v));
                if i == j {
                    K -= B_q * r;
                }
                let C = maps[i][1] * (c * B + m * 2.0 * B_q * v);
                let M = maps[i][1] * m * B;
                let position = self.pattern.find(i, j).unwrap_or(0);
                values[position] = w.K * K + w.C * C + w.M * M;
            }
        }
        Ok(())
    }

    fn energetics(&mut self) -> Option<&mut dyn Energetics> {
        Some(self)
    }

    fn charts(&mut self) -> Option<&mut dyn Charts> {
        Some(self)
    }
}

impl Energetics for KnownMotion {
    fn energies(&mut self, at: Point<'_>) -> Result<Energies, SystemError> {
        let [x, v, _] = self.position([at.q, at.v, at.a]);
        let mut out = Energies {
            stored: 0.5 * SPRING * (x[0] - x[1]).powi(2),
            ..Energies::default()
        };
        for i in 0..2 {
            out.kinetic += 0.5 * (1.0 + 0.5 * x[i] * x[i]) * v[i] * v[i];
            out.stored += 2.0 * (1.0 - x[i].cos());
            if self.forced {
                out.supplied += self.side(i, Self::motion(at.t)).0 * v[i];
                out.dissipated += DAMPING * v[i] * v[i];
            }
        }
        Ok(out)
    }
}

impl Charts for KnownMotion {
    fn change_charts(
        &mut self,
        _: f64,
        q: &mut [f64],
        v: &mut [f64],
        accelerations: &mut [&mut [f64]],
    ) -> ChartChanges {
        self.calls += 1;
        if !self.switching || !self.calls.is_multiple_of(3) {
            return ChartChanges::default();
        }
        for i in 0..2 {
            // From the old chart to x, and from there to the new one.
            let [x, B, B_q, _] = map(self.sinh_chart, q[i]);
            for a in accelerations.iter_mut() {
                a[i] = B * a[i] + B_q * v[i] * v[i];
            }
            let x_dot = B * v[i];
            q[i] = if self.sinh_chart { x } else { x.asinh() };
            let [_, B, B_q, _] = map(!self.sinh_chart, q[i]);
            v[i] = x_dot / B;
            for a in accelerations.iter_mut() {
                a[i] = (a[i] - B_q * v[i] * v[i]) / B;
            }
        }
        self.sinh_chart = !self.sinh_chart;
        ChartChanges::of(2)
    }
}

/// One coordinate with q̈ = p̈(t), of a polynomial p.
pub(crate) struct OneCoordinate {
    pattern: BlockPattern,
    /// Degree of p.
    degree: usize,
}

impl OneCoordinate {
    /// Largest degree of a polynomial.
    pub(crate) const DEGREE: usize = 4;
    const COEFFICIENTS: [f64; Self::DEGREE + 1] = [0.3, 0.7, -0.4, 0.5, -0.2];

    pub(crate) fn polynomial(degree: usize) -> Self {
        Self {
            pattern: BlockPattern::dense(1),
            degree,
        }
    }

    /// p̈.
    pub(crate) fn acceleration(&self, t: f64) -> f64 {
        let terms = Self::COEFFICIENTS[..=self.degree].iter().zip(0..).skip(2);
        terms
            .map(|(c, n)| f64::from(n * (n - 1)) * c * t.powi(n - 2))
            .sum()
    }

    /// p and ṗ.
    pub(crate) fn motion(&self, t: f64) -> [f64; 2] {
        let terms = Self::COEFFICIENTS[..=self.degree].iter().zip(0..);
        terms.fold([0.0; 2], |[q, v], (c, n)| {
            let rate = match n {
                0 => 0.0,
                _ => f64::from(n) * c * t.powi(n - 1),
            };
            [q + c * t.powi(n), v + rate]
        })
    }
}

impl System for OneCoordinate {
    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn evaluate(&mut self, at: Point<'_>, out: Evaluation<'_>) -> Result<(), SystemError> {
        out.r[0] = self.acceleration(at.t) - at.a[0];
        if let Some((w, S)) = out.S {
            S[0] = w.M;
        }
        Ok(())
    }

    fn energetics(&mut self) -> Option<&mut dyn Energetics> {
        Some(self)
    }
}

impl Energetics for OneCoordinate {
    fn energies(&mut self, at: Point<'_>) -> Result<Energies, SystemError> {
        let v = at.v[0];
        Ok(Energies {
            kinetic: 0.5 * v * v,
            supplied: self.acceleration(at.t) * v,
            ..Energies::default()
        })
    }
}
