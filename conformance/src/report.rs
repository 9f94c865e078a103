//! The results of checks: a table of components, laws, positions and measured values.

use crate::block::Block;
use std::fmt;

/// The result of one check.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// A defect and its largest value due to round-off.
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
        /// The smallest slope by Taylor's theorem.
        expected: f64,
    },
    /// The law could not be checked, or a value was not finite.
    Impossible(String),
}

impl Measure {
    /// The defect, or the shortfall of a slope, over the allowed one: at most 1 where the law holds. Infinite for
    /// NaN, and where the law could not be checked.
    pub fn strain(&self) -> f64 {
        let strain = match self {
            Self::Defect { defect: 0.0, .. } => 0.0,
            Self::Defect { defect, allowed } if allowed.is_finite() => defect / allowed,
            Self::Slope { slope, expected } => (expected - slope) / SHORTFALL,
            _ => f64::INFINITY,
        };
        match strain.is_nan() {
            true => f64::INFINITY,
            false => strain,
        }
    }

    /// The smallest slope, or the largest defect, that is accepted.
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
    /// The component: the subject of the report, or a part of it.
    pub component: String,
    /// The law.
    pub law: String,
    /// Name of the position.
    pub at: String,
    /// The result.
    pub measure: Measure,
    /// Whether the law holds.
    pub passed: bool,
    /// The wrong blocks, if known, the worst first.
    pub blocks: Vec<Block>,
}

impl LawRow {
    /// Whether it is a slope that is too small.
    fn falls_short(&self) -> bool {
        matches!(self.measure, Measure::Slope { .. }) && !self.passed
    }
}

/// All laws of all components at all positions.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    subject: String,
    rows: Vec<LawRow>,
}

/// Ratio of successive steps.
const RATIO: f64 = 4.0;
/// Most steps: the last one is 2.4e-7 of the first.
const STEPS: usize = 12;
/// Most steps that may lead out of a domain.
const OUTSIDE: usize = 8;
/// Remainders below this fraction of the scale are round-off.
const RESOLVED: f64 = 1e-12;
/// Largest shortfall of a slope, which the next Taylor term causes.
const SHORTFALL: f64 = 0.25;

impl Report {
    /// An empty report on a component.
    pub fn new(subject: impl Into<String>) -> Self {
        Self {
            subject: subject.into(),
            rows: Vec::new(),
        }
    }

    /// Name of what was checked.
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

    /// Laws that do not hold, each once, in alphabetical order.
    pub fn failing_laws(&self) -> Vec<String> {
        let mut laws: Vec<_> = self.failures().iter().map(|r| r.law.clone()).collect();
        laws.sort();
        laws.dedup();
        laws
    }

    /// Whether at least one law was checked, and all of them hold.
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

    /// One row for each component and law: the one with the largest [`Measure::strain`].
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

    fn push(&mut self, law: &str, at: &str, measure: Measure) {
        let passed = measure.strain() <= 1.0 && measure.limit().is_finite();
        self.rows.push(LawRow {
            component: self.subject.clone(),
            law: law.to_owned(),
            at: at.to_owned(),
            measure,
            passed,
            blocks: Vec::new(),
        });
    }

    /// Adds the wrong blocks to the last row, if it failed.
    pub fn blame(&mut self, blocks: impl FnOnce() -> Vec<Block>) {
        if let Some(row) = self.rows.last_mut().filter(|row| !row.passed) {
            row.blocks = blocks();
        }
    }

    /// Makes two attempts at a law: if the slope of the first is too small its row is replaced by that of the second,
    /// since terms of two orders may cancel by chance.
    pub(crate) fn twice(&mut self, mut measure: impl FnMut(&mut Self)) {
        measure(self);
        if self.rows.last().is_some_and(LawRow::falls_short) {
            self.rows.pop();
            measure(self);
        }
    }

    /// Checks a slope in the last row that is too small by a defect, found by differences, and the allowed defect, if
    /// they are known. The defect replaces the slope if it is small enough: terms that cancel by chance may bend a
    /// line.
    pub fn second_opinion(&mut self, opinion: impl FnOnce() -> Option<(f64, f64)>) {
        if let Some(row) = self.rows.last_mut().filter(|row| row.falls_short())
            && let Some((defect, allowed)) = opinion()
            && defect <= allowed
        {
            row.measure = Measure::Defect { defect, allowed };
            row.passed = true;
        }
    }

    /// Adds a law that could not be checked, which is a failure.
    pub fn impossible(&mut self, law: &str, at: &str, why: impl Into<String>) {
        self.push(law, at, Measure::Impossible(why.into()));
    }

    /// Adds a defect and the allowed one.
    pub fn defect(&mut self, law: &str, at: &str, defect: f64, allowed: f64) {
        self.push(law, at, Measure::Defect { defect, allowed });
    }

    /// Adds a measured slope and the expected one.
    pub fn rate(&mut self, law: &str, at: &str, slope: f64, expected: f64) {
        self.push(law, at, Measure::Slope { slope, expected });
    }

    /// Adds the worst of some defects, given the allowed ones; returns its number.
    pub fn defects(&mut self, law: &str, at: &str, defects: &[f64], allowed: &[f64]) -> usize {
        let measures = defects.iter().zip(allowed);
        let measures = measures.map(|(&defect, &allowed)| Measure::Defect { defect, allowed });
        let (worst, measure) = worst(measures);
        self.push(law, at, measure);
        worst
    }

    /// Measures the order of a remainder in the step: `order` or more, down to round-off.
    ///
    /// `scale` is the size of the numbers that cancel in the remainder. Steps decrease from `first`; the slope is that
    /// of the last three remainders above round-off, the least affected by the next Taylor term.
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

    /// Measures the orders of several remainders, each with its own scale, and adds the worst; returns its number.
    ///
    /// Small numbers beside large ones, such as a soft spring in a stiff structure or moments in millimetres beside
    /// forces, are thus not lost in a common norm. First steps with a remainder that is NaN may lead out of the domain,
    /// and are left out.
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
                    // Where terms of other signs cancel, a remainder is small by chance.
                    ([.., a, b, c], _) => Measure::Slope {
                        slope: (0.5 * (a / c).ln()).max((b / c).ln()) / RATIO.ln(),
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
        self.push(law, at, measure);
        worst
    }
}

/// The measure with the largest strain, and its number.
fn worst(measures: impl Iterator<Item = Measure>) -> (usize, Measure) {
    let worst = measures
        .enumerate()
        .max_by(|a, b| a.1.strain().total_cmp(&b.1.strain()));
    worst.unwrap_or_else(|| (0, Measure::Impossible("nothing to measure".to_owned())))
}

fn table(subject: &str, rows: &[&LawRow]) -> String {
    let width = |of: fn(&LawRow) -> &str| rows.iter().map(|r| of(r).chars().count()).max();
    // Components are named where one is not the subject.
    let parts = rows.iter().any(|r| r.component != subject);
    let component = width(|r| &r.component).map_or(0, |w| if parts { w + 2 } else { 0 });
    let law = width(|r| &r.law).unwrap_or(0);
    let at = width(|r| &r.at).unwrap_or(0);
    let mut out = String::new();
    for row in rows {
        let verdict = if row.passed { "ok  " } else { "FAIL" };
        let name = if parts { &row.component } else { "" };
        out += &format!(
            "{verdict}  {name:component$}{:law$}  {:at$}  {}\n",
            row.law, row.at, row.measure
        );
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
