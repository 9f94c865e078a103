//! The laws of a map behind slices: its operators are derivatives of its values.

use crate::block::{Block, Compared, difference};
use crate::forces::CONFIRMED;
use crate::forces::State;
use crate::layout::Layout;
use crate::report::Report;
use crate::sample::Random;
use pullback_manifold::map::{KinematicsMut, Parametrization};

/// A map with the coordinates that it takes (`columns`) and gives (`rows`).
#[derive(Clone, Copy)]
pub struct Mapped<'a> {
    /// The map.
    pub map: &'a dyn Parametrization,
    /// What it gives.
    pub rows: &'a Layout,
    /// What it takes.
    pub columns: &'a Layout,
}

/// x, ẋ, ẍ, B, Ḃ, B̈; matrices column by column.
pub(crate) type Kinematics = [Vec<f64>; 6];

/// Two evaluations of the same operator by different formulas differ by less than this, relatively:
/// see the closed forms of [`map`](super::map()).
const SAME: f64 = 1e-10;

/// A step that is well inside the domain, and small beside the next Taylor terms.
const FIRST: f64 = 0.1;
/// Step of differences that tell which operator is wrong.
const STEP: f64 = 1e-3;

impl Mapped<'_> {
    fn margin(&self, t: f64, q: &[f64]) -> f64 {
        self.map.duplicate().margin(t, q)
    }

    pub(crate) fn tangent(&self, t: f64, q: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (d, n) = self.map.dims();
        let (mut x, mut B) = (vec![f64::NAN; n], vec![f64::NAN; n * d]);
        let mut map = self.map.duplicate();
        // Outside of its domain a map may give anything.
        if map.margin(t, q) > 0.0 {
            map.tangent(t, q, &mut x, &mut B);
        }
        (x, B)
    }

    pub(crate) fn kinematics(&self, s: &State) -> Kinematics {
        let (d, n) = self.map.dims();
        let mut all = [n, n, n, n * d, n * d, n * d].map(|len| vec![f64::NAN; len]);
        let [x, x_dot, x_ddot, B, B_dot, B_ddot] = &mut all;
        let out = KinematicsMut {
            x,
            x_dot,
            x_ddot,
            B,
            B_dot,
            B_ddot,
        };
        let [q, v, a] = [&s.x, &s.v, &s.a].map(|x| x.as_slice());
        self.map.duplicate().kinematics(s.t, q, v, a, out);
        all
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

    /// The norm of each group of rows of a matrix, in units of rows over those of columns.
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

    /// The largest step along a direction, or along the motion, that stays inside the domain.
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

    /// Differences of a function of the coordinates with respect to coordinate j, in its unit, as far as
    /// the domain reaches on both sides.
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
        let pairs = found
            .chunks_exact(n.max(1))
            .zip(right.chunks_exact(n.max(1)));
        let whole = Layout::single();
        Compared {
            matrix,
            rows: self.rows,
            columns: if found.len() == n && self.map.dims().0 != 1 {
                &whole
            } else {
                self.columns
            },
            forces: false,
            values: pairs
                .enumerate()
                .map(|(j, (f, r))| (j, f.to_vec(), r.to_vec()))
                .collect(),
        }
        .worst()
    }
}

/// Notes the laws of a map at one state in motion: B, ẋ and ẍ, Ḃ and B̈, K_σ. Where one of them is not
/// finite, notes which entry it is and nothing else; whether all are finite.
pub fn kinematics(
    report: &mut Report,
    prefix: &str,
    of: Mapped<'_>,
    at: &str,
    s: &State,
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

    // Sizes of what cancels, in units of the rows.
    let magnitudes = columns.magnitudes(q, 0);
    let mut behind = rows.magnitudes(&x, 0);
    for (column, m) in B.chunks_exact(x.len().max(1)).zip(&magnitudes) {
        behind
            .iter_mut()
            .zip(column)
            .for_each(|(o, b)| *o += b.abs() * m);
    }
    let sizes = rows.coordinates(&behind);

    let mut d = vec![0.0; q.len()];
    random.direction(1.0, &mut d);
    d.iter_mut().zip(columns.units()).for_each(|(d, u)| *d *= u);
    let along = |e: f64| -> Vec<f64> { q.iter().zip(&d).map(|(q, d)| q + d * e).collect() };
    let first = of.first(|e| (t, along(e)));
    let slope = times(&B, &d, x.len());
    report.slopes(&law("B = dphi/dq"), at, 2.0, first, &sizes, |e| {
        let there = of.tangent(t, &along(e)).0;
        let parts = there.iter().zip(&x).zip(&slope);
        let left: Vec<f64> = parts.map(|((a, b), s)| a - b - s * e).collect();
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
    let both = defects.concat();
    let name = law("x and B are the same at rest and in motion");
    report.defects(&name, at, &both, &allowed.repeat(2));
    motion(report, prefix, of, at, s, &k, &sizes);

    // Without coordinates nothing is pulled back.
    if q.is_empty() {
        return true;
    }
    // A covector whose work on one unit of every row is of the size of one.
    let mut f = vec![0.0; x.len()];
    random.fill(&mut f);
    f.iter_mut().zip(rows.units()).for_each(|(f, u)| *f /= u);
    let K = of.geometric_stiffness(t, q, &f);
    let pulled = of.pulled(t, q, &f);
    let mut work = vec![0.0; q.len()];
    for (w, b) in work.iter_mut().zip(B.chunks_exact(f.len().max(1))) {
        *w += b.iter().zip(&f).map(|(b, f)| (b * f).abs()).sum::<f64>();
    }
    for (column, m) in K.chunks_exact(q.len().max(1)).zip(&magnitudes) {
        work.iter_mut()
            .zip(column)
            .for_each(|(w, k)| *w += k.abs() * m);
    }
    let slope = times(&K, &d, q.len());
    let name = law("K_sigma = d(B'f)/dq");
    report.slopes(&name, at, 2.0, first, &columns.forces(&work), |e| {
        let there = of.pulled(t, &along(e), &f);
        let parts = there.iter().zip(&pulled).zip(&slope);
        let left: Vec<f64> = parts.map(|((a, b), s)| a - b - s * e).collect();
        columns.forces(&left)
    });
    let units = columns.units();
    let compared = || {
        let column = |(j, unit): (usize, &f64)| {
            let right = of.differences((t, q), (j, *unit), |q| of.pulled(t, q, &f))?;
            Some((j, K[j * q.len()..(j + 1) * q.len()].to_vec(), right))
        };
        Compared {
            matrix: "K_sigma",
            rows: columns,
            columns,
            forces: true,
            values: units.iter().enumerate().filter_map(column).collect(),
        }
    };
    report.second_opinion(|| {
        let mut off = vec![0.0; columns.groups().len()];
        for (j, found, right) in compared().values {
            let gaps = columns.forces(&minus(&found, &right));
            off.iter_mut()
                .zip(gaps)
                .for_each(|(o, g)| *o += g * units[j]);
        }
        worst(&off, &columns.forces(&work))
    });
    report.blame(|| compared().worst());
    let (mut gap, mut size) = (0.0, 0.0);
    for i in 0..q.len() {
        for j in 0..q.len() {
            let unit = units[i] * units[j];
            gap += ((K[i + j * q.len()] - K[j + i * q.len()]) * unit).powi(2);
            size += (K[i + j * q.len()] * unit).powi(2);
        }
    }
    // Where derivatives cancel, K_sigma is what rounding leaves of the work behind it.
    let behind = work.iter().zip(&units).map(|(w, u)| (w * u).abs());
    let rounding = 1e-14 * behind.fold(0.0, f64::max);
    let allowed = SAME * f64::sqrt(size) + rounding;
    report.defect(&law("K_sigma symmetric"), at, f64::sqrt(gap), allowed);
    true
}

/// ẋ, ẍ and Ḃ, B̈ along the motion.
fn motion(
    report: &mut Report,
    prefix: &str,
    of: Mapped<'_>,
    at: &str,
    s: &State,
    k: &Kinematics,
    sizes: &[f64],
) {
    let law = |name: &str| format!("{prefix}{name}");
    let rate = of.columns.rate;
    let along = |tau: f64| -> (f64, Vec<f64>) {
        let q = &s.x + &s.v * tau + &s.a * (0.5 * tau * tau);
        (s.t + tau, q.as_slice().to_vec())
    };
    let first = of.first(|e| along(e / rate)) / rate;
    let [x, x_dot, x_ddot, B, B_dot, B_ddot] = k;
    let left = |there: &[f64], x: &[f64], x_dot: &[f64], x_ddot: &[f64], tau: f64| -> Vec<f64> {
        (0..x.len())
            .map(|i| there[i] - x[i] - x_dot[i] * tau - x_ddot[i] * (0.5 * tau * tau))
            .collect()
    };
    let [speed, acceleration] = [x_dot, x_ddot].map(|x| of.rows.coordinates(x));
    let all: Vec<f64> = (0..sizes.len())
        .map(|k| sizes[k] + speed[k] / rate + acceleration[k] / (rate * rate))
        .collect();
    let name = law("x_dot, x_ddot along the motion");
    report.slopes(&name, at, 3.0, first, &all, |tau| {
        let (t, q) = along(tau);
        of.rows
            .coordinates(&left(&of.tangent(t, &q).0, x, x_dot, x_ddot, tau))
    });
    let path = |tau: f64| {
        let (t, q) = along(tau);
        of.tangent(t, &q)
    };
    let shorter = |part: f64| differences(part * STEP / rate, |tau| path(tau).0, x);
    let right = || shorter(1.0);
    report.second_opinion(|| agree([x_dot, x_ddot], shorter));
    report.blame(|| either(of, ["x_dot", "x_ddot"], [x_dot, x_ddot], &right()));
    let [b, b_dot, b_ddot] = [B, B_dot, B_ddot].map(|B| of.row_norms(B));
    let all: Vec<f64> = (0..sizes.len())
        .map(|k| sizes[k] + b[k] + b_dot[k] / rate + b_ddot[k] / (rate * rate))
        .collect();
    let name = law("B_dot, B_ddot along the motion");
    report.slopes(&name, at, 3.0, first, &all, |tau| {
        let (t, q) = along(tau);
        of.row_norms(&left(&of.tangent(t, &q).1, B, B_dot, B_ddot, tau))
    });
    let shorter = |part: f64| differences(part * STEP / rate, |tau| path(tau).1, B);
    let right = || shorter(1.0);
    report.second_opinion(|| agree([B_dot, B_ddot], shorter));
    report.blame(|| either(of, ["B_dot", "B_ddot"], [B_dot, B_ddot], &right()));
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
    // Second differences lose more digits: they want longer steps.
    let (coarse, fine) = (second(8.0 * h), second(4.0 * h));
    let pairs = coarse.iter().zip(&fine);
    let second = pairs.map(|(c, f)| (4.0 * f - c) / 3.0).collect();
    [first, second]
}

/// How far two derivatives are from their differences, relatively, and what these allow: from those
/// with the step that suits them best, as what is wrong is off by all of them.
fn agree(found: [&Vec<f64>; 2], differences: impl Fn(f64) -> [Vec<f64>; 2]) -> Option<(f64, f64)> {
    let off = |part: f64| {
        let right = differences(part);
        let off =
            |k: usize| norm(&minus(found[k], &right[k])) / norm(&right[k]).max(f64::MIN_POSITIVE);
        larger(off(0), off(1))
    };
    let least = [1.0, 0.25, 0.0625]
        .map(off)
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    Some((least, TELLING))
}

/// The larger number, or the one that is none: what differences do not know is not confirmed by them.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// The largest defect over its size, and what differences allow.
fn worst(defects: &[f64], sizes: &[f64]) -> Option<(f64, f64)> {
    let strains = defects.iter().zip(sizes).map(|(d, s)| d / s);
    Some((strains.fold(0.0, larger), CONFIRMED))
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
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

/// A first derivative that agrees with its differences to this fraction is not what is wrong.
const TELLING: f64 = 1e-7;

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// A d for a matrix of n rows.
fn times(A: &[f64], d: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; n];
    for (column, d) in A.chunks_exact(n.max(1)).zip(d) {
        out.iter_mut().zip(column).for_each(|(o, a)| *o += a * d);
    }
    out
}
