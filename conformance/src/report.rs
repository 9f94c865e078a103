//! What the kit hands back: a table of components, laws, positions and measurements.

use crate::block::Block;
use std::fmt;

/// What was measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// A defect and the largest one that round-off explains.
    Defect {
        /// Found.
        defect: f64,
        /// Allowed.
        allowed: f64,
    },
    /// A log–log slope of a remainder over the step.
    Slope {
        /// Found.
        slope: f64,
        /// By Taylor's theorem; more is as good.
        expected: f64,
    },
    /// The law could not be checked, or a value was not finite.
    Impossible(String),
}

impl Measure {
    /// How much of what is allowed is used up: at most one where the law holds. A number that is
    /// none, and what could not be checked, count as infinite.
    pub fn strain(&self) -> f64 {
        let strain = match self {
            Self::Defect { defect: 0.0, .. } => 0.0,
            Self::Defect { defect, allowed } if allowed.is_finite() => defect / allowed,
            Self::Slope { slope, expected } => (expected - slope) / SHORTFALL,
            _ => f64::INFINITY,
        };
        if strain.is_nan() {
            f64::INFINITY
        } else {
            strain
        }
    }

    /// A slope that counts as enough, or the largest defect that does.
    pub fn limit(&self) -> f64 {
        match self {
            Self::Defect { allowed, .. } => *allowed,
            Self::Slope { expected, .. } => expected - SHORTFALL,
            Self::Impossible(_) => f64::NAN,
        }
    }
}

/// One law of one component at one position.
#[derive(Clone, Debug, PartialEq)]
pub struct LawRow {
    /// What was checked: the report's subject, or a part of it.
    pub component: String,
    /// The law.
    pub law: String,
    /// Where.
    pub at: String,
    /// What was measured.
    pub measure: Measure,
    /// Whether the law holds.
    pub passed: bool,
    /// The blocks that are wrong, the worst first, where they could be told.
    pub blocks: Vec<Block>,
}

/// All laws of all components at all positions.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    subject: String,
    rows: Vec<LawRow>,
}

/// The largest ratio between steps and remainders: every step is a quarter of the one before.
const RATIO: f64 = 4.0;
/// Steps at most: the last one is 2.4e-8 of the first.
const STEPS: usize = 12;
/// Steps at most that may lead out of a domain.
const OUTSIDE: usize = 4;
/// Remainders below this fraction of the scale are not told from round-off.
pub(crate) const RESOLVED: f64 = 1e-12;
/// A slope may fall short of Taylor's by this much: the next term still bends the line a little.
const SHORTFALL: f64 = 0.25;

impl Report {
    /// An empty report on something.
    pub fn new(subject: impl Into<String>) -> Self {
        Self {
            subject: subject.into(),
            rows: Vec::new(),
        }
    }

    /// What was checked.
    pub fn subject(&self) -> &str {
        &self.subject
    }

    /// All rows.
    pub fn rows(&self) -> &[LawRow] {
        &self.rows
    }

    /// Rows of laws that do not hold.
    pub fn failures(&self) -> Vec<&LawRow> {
        self.rows.iter().filter(|r| !r.passed).collect()
    }

    /// Whether anything was checked, and all of it holds.
    pub fn is_ok(&self) -> bool {
        !self.rows.is_empty() && self.rows.iter().all(|r| r.passed)
    }

    /// Asserts that all laws hold.
    ///
    /// # Panics
    /// With the table of failures when one does not: this is a test kit.
    #[track_caller]
    pub fn assert(&self) {
        assert!(
            self.is_ok(),
            "{}: {} of {} laws fail\n{}",
            self.subject,
            self.failures().len(),
            self.rows.len(),
            table(&self.subject, &self.failures())
        );
    }

    /// Appends all rows of another report.
    pub fn extend(&mut self, other: Self) {
        self.rows.extend(other.rows);
    }

    /// One row for each component and law: where it came closest to failing, or failed worst.
    #[must_use]
    pub fn worst(self) -> Self {
        let mut rows: Vec<LawRow> = Vec::new();
        let mut positions = std::collections::HashMap::new();
        for row in self.rows {
            let key = (row.component.clone(), row.law.clone());
            let k = *positions.entry(key).or_insert(rows.len());
            match rows.get_mut(k) {
                None => rows.push(row),
                Some(kept) if row.measure.strain() > kept.measure.strain() => *kept = row,
                Some(_) => {}
            }
        }
        let subject = self.subject;
        Self { subject, rows }
    }

    fn push(&mut self, law: &str, at: &str, measure: Measure, passed: bool) {
        self.rows.push(LawRow {
            component: self.subject.clone(),
            law: law.to_owned(),
            at: at.to_owned(),
            measure,
            passed,
            blocks: Vec::new(),
        });
    }

    /// Says which blocks are wrong in the law noted last, if it failed.
    pub fn blame(&mut self, blocks: impl FnOnce() -> Vec<Block>) {
        if let Some(row) = self.rows.last_mut().filter(|row| !row.passed) {
            row.blocks = blocks();
        }
    }

    /// Drops the law noted last, to measure it anew; whether it was a slope that falls short.
    pub fn retry(&mut self) -> bool {
        let short = |row: &LawRow| matches!(row.measure, Measure::Slope { .. }) && !row.passed;
        let retry = self.rows.last().is_some_and(short);
        if retry {
            self.rows.pop();
        }
        retry
    }

    /// Takes a second opinion where a slope noted last falls short: a defect by differences and what
    /// it is allowed, or nothing. Single numbers can bend a line where two terms cancel by chance.
    ///
    /// The opinion takes the slope's position if it is that all is well.
    pub fn second_opinion(&mut self, opinion: impl FnOnce() -> Option<(f64, f64)>) {
        let slope = |row: &&mut LawRow| matches!(row.measure, Measure::Slope { .. }) && !row.passed;
        if let Some(row) = self.rows.last_mut().filter(slope)
            && let Some((defect, allowed)) = opinion()
            && defect <= allowed
        {
            row.measure = Measure::Defect { defect, allowed };
            row.passed = true;
        }
    }

    /// Notes a law that could not be checked: a failure.
    pub fn impossible(&mut self, law: &str, at: &str, why: impl Into<String>) {
        self.push(law, at, Measure::Impossible(why.into()), false);
    }

    /// Notes a defect that round-off must explain.
    pub fn defect(&mut self, law: &str, at: &str, defect: f64, allowed: f64) {
        // A NaN is not below anything: it fails.
        let passed = defect <= allowed && allowed.is_finite();
        self.push(law, at, Measure::Defect { defect, allowed }, passed);
    }

    /// Notes a slope that was measured elsewhere, and the one expected.
    pub fn rate(&mut self, law: &str, at: &str, slope: f64, expected: f64) {
        let measure = Measure::Slope { slope, expected };
        let passed = measure.strain() <= 1.0;
        self.push(law, at, measure, passed);
    }

    /// Notes the worst of some defects and what each is allowed; which one it was.
    pub fn defects(&mut self, law: &str, at: &str, defects: &[f64], allowed: &[f64]) -> usize {
        let measures = defects.iter().zip(allowed);
        let measures = measures.map(|(&defect, &allowed)| Measure::Defect { defect, allowed });
        let (worst, measure) = worst(measures);
        let passed = measure.strain() <= 1.0;
        self.push(law, at, measure, passed);
        worst
    }

    /// Measures how fast a remainder falls: like `step`^`order` or faster, down to round-off.
    ///
    /// `scale` is the size of the numbers that cancel in the remainder. Steps start at `first` and
    /// shrink; the slope is that of the last three remainders above round-off, where neither the
    /// next Taylor term nor round-off bends it.
    pub fn slope(
        &mut self,
        law: &str,
        at: &str,
        order: f64,
        first: f64,
        scale: f64,
        mut remainder: impl FnMut(f64) -> f64,
    ) {
        self.slopes(law, at, order, first, &[scale], |e| vec![remainder(e)]);
    }

    /// Measures how fast several remainders fall, each with its own scale, and notes the worst; which
    /// one it was.
    ///
    /// Small numbers beside large ones (a soft spring in a stiff structure, moments in millimetres
    /// beside forces) are thus not lost in a common norm. First steps with a remainder that is no
    /// number may lead out of the domain, and are left out.
    pub fn slopes(
        &mut self,
        law: &str,
        at: &str,
        order: f64,
        first: f64,
        scales: &[f64],
        mut remainders: impl FnMut(f64) -> Vec<f64>,
    ) -> usize {
        let mut found: Vec<Vec<f64>> = vec![Vec::with_capacity(STEPS); scales.len()];
        let mut below: Vec<Option<f64>> = vec![None; scales.len()];
        let mut step = first;
        for tried in 0..STEPS {
            let defects = remainders(step);
            let inside = defects.iter().all(|d| d.is_finite());
            if !inside && tried < OUTSIDE && found.iter().all(Vec::is_empty) {
                step /= RATIO;
                continue;
            }
            for (k, defect) in defects.into_iter().enumerate() {
                if !defect.is_finite() {
                    let why = format!("remainder {defect} at step {step:.1e}");
                    self.impossible(law, at, why);
                    return k;
                }
                if below[k].is_some() {
                } else if defect <= RESOLVED * scales[k] {
                    below[k] = Some(defect);
                } else {
                    found[k].push(defect);
                }
            }
            if below.iter().all(Option::is_some) {
                break;
            }
            step /= RATIO;
        }
        let measures = found
            .iter()
            .zip(&below)
            .zip(scales)
            .map(|((found, below), scale)| {
                match (found.as_slice(), below) {
                    ([.., a, _, c], _) => Measure::Slope {
                        slope: (a / c).ln() / (2.0 * RATIO.ln()),
                        expected: order,
                    },
                    (_, Some(defect)) => Measure::Defect {
                        defect: *defect,
                        allowed: RESOLVED * scale,
                    },
                    // STEPS > 3, so remainders are found or fall below.
                    _ => Measure::Impossible("no remainder".to_owned()),
                }
            });
        let (worst, measure) = worst(measures);
        let passed = measure.strain() <= 1.0;
        self.push(law, at, measure, passed);
        worst
    }
}

/// The measure that strains its law most, and its number.
fn worst(measures: impl Iterator<Item = Measure>) -> (usize, Measure) {
    let worst = measures
        .enumerate()
        .max_by(|a, b| a.1.strain().total_cmp(&b.1.strain()));
    worst.unwrap_or_else(|| (0, Measure::Impossible("nothing to measure".to_owned())))
}

fn table(subject: &str, rows: &[&LawRow]) -> String {
    let width = |of: fn(&LawRow) -> &str| rows.iter().map(|r| of(r).chars().count()).max();
    // Where everything is about the subject, nobody needs to be told.
    let parts = rows.iter().any(|r| r.component != subject);
    let component = width(|r| &r.component).map_or(0, |w| if parts { w + 2 } else { 0 });
    let law = width(|r| &r.law).unwrap_or(0);
    let at = width(|r| &r.at).unwrap_or(0);
    let mut out = String::new();
    for row in rows {
        let verdict = if row.passed { "ok  " } else { "FAIL" };
        let line = format!(
            "{verdict}  {:component$}{:law$}  {:at$}  {}\n",
            if parts { &row.component } else { "" },
            row.law,
            row.at,
            row.measure
        );
        out += &line;
        for block in &row.blocks {
            out += &format!("      {block}\n");
        }
    }
    out
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Defect { defect, allowed } => {
                write!(f, "defect {defect:9.2e}  allowed  {allowed:9.2e}")
            }
            Self::Slope { slope, expected } => {
                write!(f, "slope  {slope:9.2}  expected {expected:9.2}")
            }
            Self::Impossible(why) => f.write_str(why),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.subject)?;
        f.write_str(&table(&self.subject, &self.rows.iter().collect::<Vec<_>>()))
    }
}
