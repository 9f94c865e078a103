//! Where the formulas of a map meet that is pieced together from several.

use super::kinematics::Mapped;
use crate::block::Block;
use crate::forces::State;
use crate::report::Report;
use crate::sample::Random;
use nalgebra::DVector;
use pullback_manifold::map::Parametrization;

/// Pieces are looked for along every coordinate, by steps of this many units, this often.
const STRIDE: f64 = 0.25;
const STEPS: i32 = 12;
/// What meets agrees to this part of its size: see the closed forms of [`map`](super::map()).
const SAME: f64 = 1e-10;
/// What has to be the same on both sides; B̈ of a map with two continuous derivatives is not.
const MEETING: [&str; 5] = ["x", "x_dot", "x_ddot", "B", "B_dot"];

/// Notes that pieces meet: from a state on along every coordinate, x, ẋ, ẍ, B and Ḃ are the same by the
/// formula that holds there and by the one that takes over
/// ([`Parametrization::freeze_piece`](pullback_manifold::map::Parametrization::freeze_piece)). Nothing is noted where there are no pieces, and of maps
/// that solve equations: their pieces are those of what they solve, and far away they are on another branch.
pub fn pieces(report: &mut Report, of: Mapped<'_>, at: &str, s: &State, random: &mut Random) {
    if of.map.duplicate().implicit().is_some() {
        return;
    }
    let units = of.columns.units();
    let mut noise = || {
        let mut v = DVector::zeros(units.len());
        random.fill(v.as_mut_slice());
        v.component_mul(&DVector::from_column_slice(&units))
    };
    let seam = Seam {
        of,
        // Rates of the size of one: all derivatives count alike.
        s: &State {
            v: noise(),
            a: noise(),
            ..s.clone()
        },
    };
    let mut here = of.map.duplicate();
    here.freeze_piece(Some((s.t, s.x.as_slice())));
    let mut any = of.map.duplicate();
    any.freeze_piece(None);
    for (j, unit) in units.iter().enumerate() {
        for step in [STRIDE * unit, -STRIDE * unit] {
            if let Some(end) = seam.find([&*here, &*any], j, step) {
                seam.compare(report, &*here, at, (j, end));
            }
        }
    }
}

struct Seam<'a> {
    of: Mapped<'a>,
    s: &'a State,
}

impl Seam<'_> {
    fn state(&self, (j, e): (usize, f64)) -> State {
        let mut s = self.s.clone();
        s.x[j] += e;
        s
    }

    fn with<'b>(&'b self, map: &'b dyn Parametrization) -> Mapped<'b> {
        Mapped { map, ..self.of }
    }

    /// How far two maps are apart group by group, each of x … B̈, and the sizes of all of them.
    fn apart(
        &self,
        maps: [&dyn Parametrization; 2],
        at: (usize, f64),
    ) -> (Vec<Vec<f64>>, Vec<f64>) {
        let s = self.state(at);
        let [a, b] = maps.map(|map| self.with(map).kinematics(&s));
        let norms = |k: usize, x: &[f64]| match k < 3 {
            true => self.of.rows.coordinates(x),
            false => self.of.row_norms(x),
        };
        let mut sizes = vec![1.0; self.of.rows.groups().len()];
        let mut gaps = Vec::new();
        for (k, (a, b)) in a.iter().zip(&b).enumerate() {
            let size = norms(k, a);
            sizes.iter_mut().zip(size).for_each(|(all, s)| *all += s);
            let gap: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            gaps.push(norms(k, &gap));
        }
        (gaps, sizes)
    }

    /// How far along a coordinate another formula takes over from the first of two maps, where the
    /// second one has that which holds.
    fn find(&self, maps: [&dyn Parametrization; 2], j: usize, step: f64) -> Option<f64> {
        // Nothing is known beyond the domain.
        let differ = |e: f64| -> Option<bool> {
            let s = self.state((j, e));
            if maps[1].duplicate().margin(s.t, s.x.as_slice()) <= 0.0 {
                return None;
            }
            let (gaps, sizes) = self.apart(maps, (j, e));
            let known = gaps.iter().flatten().chain(&sizes).all(|s| s.is_finite());
            let apart = |gap: &Vec<f64>| gap.iter().zip(&sizes).any(|(g, s)| *g > SAME * s);
            known.then(|| gaps.iter().any(apart))
        };
        let mut last = 0.0;
        for k in 1..=STEPS {
            let next = step * f64::from(k);
            if differ(next)? {
                let mut ends = [last, next];
                for _ in 0..f64::MANTISSA_DIGITS {
                    let middle = 0.5 * (ends[0] + ends[1]);
                    ends[usize::from(differ(middle)?)] = middle;
                }
                return Some(ends[1]);
            }
            last = next;
        }
        None
    }

    fn compare(
        &self,
        report: &mut Report,
        here: &dyn Parametrization,
        at: &str,
        end: (usize, f64),
    ) {
        let s = self.state(end);
        let mut next = self.of.map.duplicate();
        next.freeze_piece(None);
        next.freeze_piece(Some((s.t, s.x.as_slice())));
        let (gaps, sizes) = self.apart([here, &*next], end);
        let gaps = gaps[..MEETING.len()].concat();
        let allowed: Vec<f64> = sizes.iter().map(|s| SAME * s).collect();
        let law = "pieces meet: x, x_dot, x_ddot, B, B_dot";
        let allowed = allowed.repeat(MEETING.len());
        report.defects(law, at, &gaps, &allowed);
        // What is off first; its derivatives are so too.
        let first = gaps.iter().zip(&allowed).position(|(gap, a)| gap > a);
        report.blame(|| self.blocks([here, &*next], &s, first.unwrap_or(0) / sizes.len()));
    }

    /// What is off in one of x … Ḃ: what comes is compared with what was.
    fn blocks(&self, maps: [&dyn Parametrization; 2], s: &State, k: usize) -> Vec<Block> {
        let [before, after] = maps.map(|map| self.with(map).kinematics(s));
        self.of.compared(MEETING[k], &after[k], &before[k])
    }
}
