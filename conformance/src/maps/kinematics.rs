//! The laws of a map behind slices: its operators are derivatives of its values.

use crate::block::{Block, Column, Rows, difference, wrong_blocks, wrong_entries};
use crate::forces::{CONFIRMED, STEP, TestState};
use crate::layout::Layout;
use crate::report::Report;
use crate::sample::Random;
use crate::vectors::{add, dot, larger, minus, norm, times};
use pullback_manifold::map::Parametrization;

/// A map with the layouts of its values (`rows`) and its coordinates (`columns`).
#[derive(Clone, Copy)]
pub struct Mapped<'a> {
    /// The map.
    pub map: &'a dyn Parametrization,
    /// Layout of x.
    pub rows: &'a Layout,
    /// Layout of q.
    pub columns: &'a Layout,
}

/// x, ẋ, ẍ, B, Ḃ, B̈; matrices column by column.
type KinematicArrays = [Vec<f64>; 6];

/// Largest relative difference of an operator by two formulas: see the closed forms of [`map`](super::map()).
const SAME: f64 = 1e-10;

/// Largest first step.
const FIRST: f64 = 0.1;

/// x, ẋ, ẍ, B, Ḃ, B̈ of a map at time `t` and a motion (q, v, a); matrices column by column.
pub fn motion(map: &dyn Parametrization, t: f64, motion: [&[f64]; 3]) -> KinematicArrays {
    let (d, n) = map.dims();
    let mut all = [n, n, n, n * d, n * d, n * d].map(|len| vec![f64::NAN; len]);
    let [x, x_dot, x_ddot, B, B_dot, B_ddot] = all.each_mut().map(|x| &mut x[..]);
    let out = &mut [[x, B], [x_dot, B_dot], [x_ddot, B_ddot]];
    map.duplicate().evaluate(t, motion, out);
    all
}

impl<'a> Mapped<'a> {
    /// A map with the layouts of x and q.
    pub(crate) fn of(map: &'a dyn Parametrization, [rows, columns]: &'a [Layout; 2]) -> Self {
        Self { map, rows, columns }
    }
}

impl Mapped<'_> {
    fn margin(&self, t: f64, q: &[f64]) -> f64 {
        self.map.duplicate().domain(t, q).unwrap_or(0.0)
    }

    pub(crate) fn tangent(&self, t: f64, q: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (d, n) = self.map.dims();
        let (mut x, mut B) = (vec![f64::NAN; n], vec![f64::NAN; n * d]);
        let mut map = self.map.duplicate();
        // Outside of its domain the values of a map are arbitrary.
        if map.domain(t, q).is_ok() {
            map.tangent(t, q, &mut x, &mut B);
        }
        (x, B)
    }

    pub(crate) fn kinematics(&self, s: &TestState) -> KinematicArrays {
        motion(self.map, s.t, [&s.x, &s.v, &s.a].map(|x| x.as_slice()))
    }

    /// Bᵀ f.
    fn pulled(&self, t: f64, q: &[f64], f: &[f64]) -> Vec<f64> {
        let B = self.tangent(t, q).1;
        B.chunks_exact(f.len().max(1)).map(|b| dot(b, f)).collect()
    }

    fn geometric_stiffness(&self, t: f64, q: &[f64], f: &[f64]) -> Vec<f64> {
        let mut K = vec![0.0; q.len() * q.len()];
        self.map.duplicate().geometric_stiffness(t, q, f, &mut K);
        K
    }

    /// The norm of each group of rows of a matrix, in the units of rows over those of columns.
    pub(crate) fn row_norms(&self, B: &[f64]) -> Vec<f64> {
        let n = self.map.dims().1;
        let units = self.columns.units();
        let mut out = vec![0.0; self.rows.groups().len()];
        for (out, g) in out.iter_mut().zip(self.rows.groups()) {
            let mut sum = 0.0;
            for (column, unit) in B.chunks_exact(n.max(1)).zip(&units) {
                let part = &column[g.range.clone()];
                sum += part.iter().map(|b| (b * unit).powi(2)).sum::<f64>();
            }
            *out = sum.sqrt() / g.unit;
        }
        out
    }

    /// The magnitudes of the terms of x in each group, in units.
    fn sizes(&self, q: &[f64], x: &[f64], B: &[f64]) -> Vec<f64> {
        let mut terms = self.rows.magnitudes(x, 0);
        let columns = B.chunks_exact(x.len().max(1));
        for (column, m) in columns.zip(self.columns.magnitudes(q, 0)) {
            let parts = terms.iter_mut().zip(column);
            parts.for_each(|(term, b)| *term += b.abs() * m);
        }
        self.rows.coordinates(&terms)
    }

    /// The first step along a direction, or along the motion, that stays inside the domain.
    fn first(&self, inside: impl Fn(f64) -> (f64, Vec<f64>)) -> f64 {
        let (t, q) = inside(0.0);
        let mut step = (0.3 * self.margin(t, &q)).min(FIRST);
        for _ in 0..40 {
            let stays = |e: f64| {
                let (t, q) = inside(e);
                self.margin(t, &q) > 0.0
            };
            if stays(step) && stays(-step) && stays(2.0 * step) && stays(-2.0 * step) {
                break;
            }
            step *= 0.5;
        }
        step
    }

    /// Differences of a function with respect to coordinate j, with steps inside the domain.
    fn differences(
        &self,
        (t, q): (f64, &[f64]),
        (j, unit): (usize, f64),
        f: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Option<Vec<f64>> {
        let along = |e: f64| {
            let mut q = q.to_vec();
            q[j] += e * unit;
            q
        };
        let step = STEP.min(self.first(|e| (t, along(e))));
        difference(step * unit, |e| Some(f(&along(e / unit))))
    }

    pub(crate) fn compared(&self, matrix: &str, found: &[f64], right: &[f64]) -> Vec<Block> {
        let n = self.map.dims().1;
        let rows = Rows::Coordinates(self.rows);
        if found.len() == n && self.map.dims().0 != 1 {
            return wrong_entries(matrix, rows, found, right);
        }
        let pairs = (found.chunks_exact(n.max(1))).zip(right.chunks_exact(n.max(1)));
        let columns = pairs.enumerate();
        let columns = columns.map(|(j, (f, r))| (j, f.to_vec(), r.to_vec()));
        let columns: Vec<Column> = columns.collect();
        wrong_blocks(matrix, rows, self.columns, &columns)
    }
}

/// Checks the laws of a map at one state in motion: B, ẋ and ẍ, Ḃ and B̈, K_σ. If one of them is not finite, the entry
/// is reported and nothing else. Returns whether all are finite.
pub fn kinematics(
    report: &mut Report,
    prefix: &str,
    of: Mapped<'_>,
    at: &str,
    s: &TestState,
    random: &mut Random,
) -> bool {
    let law = |name: &str| format!("{prefix}{name}");
    let (t, q) = (s.t, s.x.as_slice());
    let (columns, rows) = (of.columns, of.rows);
    let (x, B) = of.tangent(t, q);
    let k = of.kinematics(s);
    if let Some(why) = of.unknown(s) {
        report.impossible(&law("values are finite"), at, why);
        return false;
    }

    let sizes = of.sizes(q, &x, &B);

    let d = random.direction_in(&columns.units()).as_slice().to_vec();
    let along = |e: f64| -> Vec<f64> { q.iter().zip(&d).map(|(q, d)| q + d * e).collect() };
    let first = of.first(|e| (t, along(e)));
    let slope = times(&B, &d, x.len());
    report.slopes(&law("B = dphi/dq"), at, 2.0, first, &sizes, |e| {
        let mut left = minus(&of.tangent(t, &along(e)).0, &x);
        add(&mut left, &slope, -e);
        rows.coordinates(&left)
    });
    let right = || -> Vec<f64> {
        let columns = (columns.units().into_iter().enumerate())
            .map(|along| of.differences((t, q), along, |q| of.tangent(t, q).0));
        columns.flatten().flatten().collect()
    };
    report.second_opinion(|| worst(&of.row_norms(&minus(&B, &right())), &sizes));
    report.blame(|| of.compared("B", &B, &right()));

    let defects = [
        rows.coordinates(&minus(&k[0], &x)),
        of.row_norms(&minus(&k[3], &B)),
    ];
    let allowed: Vec<f64> = sizes.iter().map(|s| SAME * s).collect();
    let name = law("x and B are the same at rest and in motion");
    report.defects(&name, at, &defects.concat(), &allowed.repeat(2));
    rates(report, prefix, of, at, s, &k, &sizes);
    // Without coordinates there are no forces.
    if !q.is_empty() {
        // A covector whose power at one unit of every row is about one.
        let mut f = vec![0.0; x.len()];
        random.fill(&mut f);
        f.iter_mut().zip(rows.units()).for_each(|(f, u)| *f /= u);
        stiffness(report, prefix, of, at, (t, q), (&f, &d), first);
    }
    true
}

/// K_σ of a covector `f` is the derivative of Bᵀf, measured along `d`, and symmetric.
fn stiffness(
    report: &mut Report,
    prefix: &str,
    of: Mapped<'_>,
    at: &str,
    (t, q): (f64, &[f64]),
    (f, d): (&[f64], &[f64]),
    first: f64,
) {
    let law = |name: &str| format!("{prefix}{name}");
    let (columns, n) = (of.columns, q.len());
    let K = of.geometric_stiffness(t, q, f);
    let pulled = of.pulled(t, q, f);
    let B = of.tangent(t, q).1;
    // The magnitudes of the terms of Bᵀf.
    let mut work = vec![0.0; n];
    for (w, b) in work.iter_mut().zip(B.chunks_exact(f.len().max(1))) {
        *w += b.iter().zip(f).map(|(b, f)| (b * f).abs()).sum::<f64>();
    }
    for (column, m) in K.chunks_exact(n).zip(columns.magnitudes(q, 0)) {
        work.iter_mut()
            .zip(column)
            .for_each(|(w, k)| *w += k.abs() * m);
    }
    let slope = times(&K, d, n);
    let name = law("K_sigma = d(B'f)/dq");
    report.slopes(&name, at, 2.0, first, &columns.forces(&work), |e| {
        let there: Vec<f64> = q.iter().zip(d).map(|(q, d)| q + d * e).collect();
        let mut left = minus(&of.pulled(t, &there, f), &pulled);
        add(&mut left, &slope, -e);
        columns.forces(&left)
    });
    let units = columns.units();
    let compared = || -> Vec<Column> {
        let column = |(j, unit): (usize, &f64)| {
            let right = of.differences((t, q), (j, *unit), |q| of.pulled(t, q, f))?;
            Some((j, K[j * n..(j + 1) * n].to_vec(), right))
        };
        units.iter().enumerate().filter_map(column).collect()
    };
    report.second_opinion(|| {
        let mut off = vec![0.0; columns.groups().len()];
        for (j, found, right) in compared() {
            add(&mut off, &columns.forces(&minus(&found, &right)), units[j]);
        }
        worst(&off, &columns.forces(&work))
    });
    report.blame(|| wrong_blocks("K_sigma", Rows::Forces(columns), columns, &compared()));
    symmetric(report, &law("K_sigma symmetric"), at, &K, &units, &work);
}

/// The symmetry of K_σ up to the rounding errors of the terms of Bᵀf, whose magnitudes are `work`.
fn symmetric(report: &mut Report, law: &str, at: &str, K: &[f64], units: &[f64], work: &[f64]) {
    let n = units.len();
    let (mut gap, mut size) = (0.0, 0.0);
    for i in 0..n {
        for j in 0..n {
            let unit = units[i] * units[j];
            gap += ((K[i + j * n] - K[j + i * n]) * unit).powi(2);
            size += (K[i + j * n] * unit).powi(2);
        }
    }
    let terms = work.iter().zip(units).map(|(w, u)| (w * u).abs());
    let rounding = 1e-14 * terms.fold(0.0, f64::max);
    let allowed = SAME * f64::sqrt(size) + rounding;
    report.defect(law, at, f64::sqrt(gap), allowed);
}

/// ẋ, ẍ and Ḃ, B̈ along the motion.
fn rates(
    report: &mut Report,
    prefix: &str,
    of: Mapped<'_>,
    at: &str,
    s: &TestState,
    k: &KinematicArrays,
    sizes: &[f64],
) {
    let rate = of.columns.rate;
    let along = |tau: f64| (s.t + tau, s.ahead(tau).as_slice().to_vec());
    let first = of.first(|e| along(e / rate)) / rate;
    let path = |tau: f64| {
        let (t, q) = along(tau);
        let (x, B) = of.tangent(t, &q);
        [x, B]
    };
    let [x, x_dot, x_ddot, B, B_dot, B_ddot] = k;
    let [b, b_dot, b_ddot] = [B, B_dot, B_ddot].map(|B| of.row_norms(B));
    let [speed, acceleration] = [x_dot, x_ddot].map(|x| of.rows.coordinates(x));
    let none = vec![0.0; sizes.len()];
    let laws = [
        (
            ["x_dot", "x_ddot"],
            [x, x_dot, x_ddot],
            [none, speed, acceleration],
        ),
        (["B_dot", "B_ddot"], [B, B_dot, B_ddot], [b, b_dot, b_ddot]),
    ];
    for (k, (names, [now, dot, ddot], norms)) in laws.into_iter().enumerate() {
        let sizes: Vec<f64> = (0..sizes.len())
            .map(|i| sizes[i] + norms[0][i] + norms[1][i] / rate + norms[2][i] / (rate * rate))
            .collect();
        let law = format!("{prefix}{}, {} along the motion", names[0], names[1]);
        report.slopes(&law, at, 3.0, first, &sizes, |tau| {
            let mut left = minus(&path(tau)[k], now);
            add(&mut left, dot, -tau);
            add(&mut left, ddot, -0.5 * tau * tau);
            match k {
                0 => of.rows.coordinates(&left),
                _ => of.row_norms(&left),
            }
        });
        let differences =
            |part: f64| differences(part * STEP / rate, |tau| path(tau)[k].clone(), now);
        report.second_opinion(|| agree([dot, ddot], differences));
        report.blame(|| either(of, names, [dot, ddot], &differences(1.0)));
    }
}

/// First and second derivative along the motion.
fn differences(h: f64, at: impl Fn(f64) -> Vec<f64>, now: &[f64]) -> [Vec<f64>; 2] {
    let first = difference(h, |tau| Some(at(tau))).unwrap_or_default();
    let second = |h: f64| -> Vec<f64> {
        let (ahead, behind) = (at(h), at(-h));
        (0..now.len())
            .map(|i| (ahead[i] - 2.0 * now[i] + behind[i]) / (h * h))
            .collect()
    };
    // Second differences lose more digits and take longer steps.
    let (coarse, fine) = (second(8.0 * h), second(4.0 * h));
    let pairs = coarse.iter().zip(&fine);
    let second = pairs.map(|(c, f)| (4.0 * f - c) / 3.0).collect();
    [first, second]
}

/// The relative defect of two derivatives against differences with the most favourable step, since a wrong derivative
/// has a defect with every step; and the allowed one.
fn agree(found: [&Vec<f64>; 2], differences: impl Fn(f64) -> [Vec<f64>; 2]) -> Option<(f64, f64)> {
    let off = |part: f64| {
        let right = differences(part);
        let size = |k: usize| norm(&right[k]).max(f64::MIN_POSITIVE);
        let off = |k: usize| norm(&minus(found[k], &right[k])) / size(k);
        larger(off(0), off(1))
    };
    let least = [1.0, 0.25, 0.0625]
        .map(off)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    Some((least, TELLING))
}

/// The largest defect over its size, and the one that differences allow.
fn worst(defects: &[f64], sizes: &[f64]) -> Option<(f64, f64)> {
    let strains = defects.iter().zip(sizes).map(|(d, s)| d / s);
    Some((strains.fold(0.0, larger), CONFIRMED))
}

/// The first derivative if that is wrong, the second otherwise.
fn either(
    of: Mapped<'_>,
    names: [&str; 2],
    found: [&Vec<f64>; 2],
    right: &[Vec<f64>; 2],
) -> Vec<Block> {
    let gap = norm(&minus(found[0], &right[0]));
    let k = usize::from(gap <= TELLING * norm(&right[0]));
    of.compared(names[k], found[k], &right[k])
}

/// Largest relative difference of a correct derivative from its differences.
const TELLING: f64 = 1e-7;
