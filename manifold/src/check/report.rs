//! What the kit hands back: a table of laws, places and measurements.

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

/// One law at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The law.
    pub law: String,
    /// Where.
    pub at: String,
    /// What was measured.
    pub measure: Measure,
    /// Whether the law holds.
    pub passed: bool,
}

/// All laws at all places.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    subject: String,
    rows: Vec<Row>,
}

/// The largest ratio between steps and remainders: every step is a quarter of the one before.
const RATIO: f64 = 4.0;
/// Steps at most: the last one is 2.4e-8 of the first.
const STEPS: usize = 12;
/// Remainders below this fraction of the scale are not told from round-off.
const RESOLVED: f64 = 1e-12;
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
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// Rows of laws that do not hold.
    pub fn failures(&self) -> Vec<&Row> {
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
            table(&self.failures())
        );
    }

    /// Appends all rows of another report.
    pub fn extend(&mut self, other: Self) {
        self.rows.extend(other.rows);
    }

    fn push(&mut self, law: &str, at: &str, measure: Measure, passed: bool) {
        self.rows.push(Row {
            law: law.to_owned(),
            at: at.to_owned(),
            measure,
            passed,
        });
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
        let floor = RESOLVED * scale;
        let mut found: Vec<f64> = Vec::with_capacity(STEPS);
        let mut step = first;
        let mut below = None;
        for _ in 0..STEPS {
            let defect = remainder(step);
            if !defect.is_finite() {
                return self.impossible(law, at, format!("remainder {defect} at step {step:.1e}"));
            }
            if defect <= floor {
                below = Some(defect);
                break;
            }
            found.push(defect);
            step /= RATIO;
        }
        match (found.as_slice(), below) {
            ([.., a, _, c], _) => {
                let slope = (a / c).ln() / (2.0 * RATIO.ln());
                let passed = slope >= order - SHORTFALL;
                let measure = Measure::Slope {
                    slope,
                    expected: order,
                };
                self.push(law, at, measure, passed);
            }
            (_, Some(defect)) => self.defect(law, at, defect, floor),
            // STEPS > 3, so remainders are found or fall below.
            _ => self.impossible(law, at, "no remainder"),
        }
    }
}

fn table(rows: &[&Row]) -> String {
    let width = |of: fn(&Row) -> &str| rows.iter().map(|r| of(r).chars().count()).max();
    let law = width(|r| &r.law).unwrap_or(0);
    let at = width(|r| &r.at).unwrap_or(0);
    let mut out = String::new();
    for row in rows {
        let verdict = if row.passed { "ok  " } else { "FAIL" };
        let line = format!(
            "{verdict}  {:law$}  {:at$}  {}\n",
            row.law, row.at, row.measure
        );
        out += &line;
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
        f.write_str(&table(&self.rows.iter().collect::<Vec<_>>()))
    }
}
