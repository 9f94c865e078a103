//! Continuity of a map that consists of several pieces.

use super::kinematics::Mapped;
use crate::forces::TestState;
use crate::report::Report;
use crate::sample::Random;
use crate::vectors::minus;
use pullback_manifold::map::Parametrization;

/// Step, in units, and number of steps of the search for other pieces along every coordinate.
const STRIDE: f64 = 0.25;
const STEPS: i32 = 12;
/// Largest relative difference of continuous values: see the closed forms of [`map`](super::map()).
const SAME: f64 = 1e-10;
/// Continuous values; B̈ of a map with two continuous derivatives is not.
const MEETING: [&str; 5] = ["x", "x_dot", "x_ddot", "B", "B_dot"];

/// Checks that x, ẋ, ẍ, B and Ḃ are continuous where the next piece of a map begins, along every coordinate from a state
/// ([`MapState::freeze_piece`](pullback_manifold::map::MapState::freeze_piece)). Maps that solve equations
/// are not checked: their pieces are those of the equations, and distant states are on another branch.
pub fn pieces(report: &mut Report, of: Mapped<'_>, at: &str, s: &TestState, random: &mut Random) {
    if of.map.duplicate().implicit().is_some() {
        return;
    }
    let units = of.columns.units();
    let mut noise = || random.entries(&units);
    let seam = Seam {
        of,
        // With rates of about 1 all derivatives have similar magnitudes.
        s: &TestState {
            v: noise(),
            a: noise(),
            ..s.clone()
        },
    };
    let mut here = of.map.duplicate();
    freeze_piece(&mut *here, Some((s.t, s.x.as_slice())));
    let mut any = of.map.duplicate();
    freeze_piece(&mut *any, None);
    for (j, unit) in units.iter().enumerate() {
        for step in [STRIDE * unit, -STRIDE * unit] {
            if let Some(end) = seam.find([&*here, &*any], j, step) {
                seam.compare(report, &*here, at, (j, end));
            }
        }
    }
}

/// Freezes a map to the piece that holds at (t, q), or releases it.
pub(crate) fn freeze_piece(map: &mut dyn Parametrization, at: Option<(f64, &[f64])>) {
    if let Some(state) = map.state() {
        state.freeze_piece(at);
    }
}

/// The search for the end of the piece that holds at a state.
struct Seam<'a> {
    of: Mapped<'a>,
    s: &'a TestState,
}

impl Seam<'_> {
    fn state(&self, (j, e): (usize, f64)) -> TestState {
        let mut s = self.s.clone();
        s.x[j] += e;
        s
    }

    fn with<'b>(&'b self, map: &'b dyn Parametrization) -> Mapped<'b> {
        Mapped { map, ..self.of }
    }

    /// The differences of two maps group by group, for each of x … B̈, and the sums of their magnitudes.
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
            gaps.push(norms(k, &minus(a, b)));
        }
        (gaps, sizes)
    }

    /// The change of a coordinate at which the two maps begin to differ: the first is the frozen piece, the second the
    /// map itself.
    fn find(&self, maps: [&dyn Parametrization; 2], j: usize, step: f64) -> Option<f64> {
        // `None` outside of the domain.
        let differ = |e: f64| -> Option<bool> {
            let s = self.state((j, e));
            if maps[1].duplicate().domain(s.t, s.x.as_slice()).is_err() {
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
        freeze_piece(&mut *next, None);
        freeze_piece(&mut *next, Some((s.t, s.x.as_slice())));
        let (gaps, sizes) = self.apart([here, &*next], end);
        let gaps = gaps[..MEETING.len()].concat();
        let allowed: Vec<f64> = sizes.iter().map(|s| SAME * s).collect();
        let law = "pieces meet: x, x_dot, x_ddot, B, B_dot";
        let allowed = allowed.repeat(MEETING.len());
        report.defects(law, at, &gaps, &allowed);
        // The first wrong value; its derivatives are wrong, too.
        let first = gaps.iter().zip(&allowed).position(|(gap, a)| gap > a);
        let k = first.unwrap_or(0) / sizes.len();
        report.blame(|| {
            let [before, after] = [here, &*next].map(|map| self.with(map).kinematics(&s));
            self.of.compared(MEETING[k], &after[k], &before[k])
        });
    }
}
