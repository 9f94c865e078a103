//! Tables of energies and momenta.

use super::{Page, escaped, run_table};
use crate::studies::compare::tables::{known, short};
use crate::studies::compare::{Comparison, ComparisonRow, Components, Conserved, Drift};

pub(super) fn drift(out: &mut Page, c: &Comparison) {
    let found = c.reference.as_ref().map(|r| r.conserved);
    let found = found.unwrap_or_default();
    let constraints = if c.enforced {
        "Loops closed by multipliers hold their equations h at every step to the tolerance of the \
         solver, those closed by a penalty to its compliance; their rates are not enforced."
    } else {
        "Constraints are maps x = φ(t, q): they hold at every step whatever the scheme. Where loops are \
         closed by their equations, |h| is what Newton's method leaves of them at a given q."
    };
    out.heading(2, "", "What the motion keeps");
    let conserved = described(&c.conserved()) + &zero(&found, c.zero_momenta);
    out.paragraph("", &format!("{conserved} {constraints}"));
    let caption = "Largest change since the start at common times, of conserved quantities; |h|, the largest \
                   residual of a loop there, each equation over its size; and the largest \
                   defect of the balance of energy over all steps, kinetic and stored less supplied \
                   (the work by the trapezoidal rule). The trend measures growth with time: the \
                   mean change of the energy (if it is not conserved, the defect of its balance) in the \
                   last quarter of the run less that in the first. All relative to the largest energy, \
                   the magnitudes of kinetic and stored energy and load potential.";
    rows(out, caption, &c.rows);
    if let Some(row) = c.long.first() {
        out.heading(2, "", "What a long run keeps");
        let end = short(row.samples.last().map_or(0.0, |s| s.t));
        let halved = c.long.iter().filter(|row| row.counts.rejected > 0);
        let halved: Vec<&str> = halved.map(|row| row.scheme.as_str()).collect();
        let halved = match halved.is_empty() {
            true => String::new(),
            false => format!(
                "; some steps were halved by {}",
                escaped(&halved.join(", "))
            ),
        };
        let caption = format!("The same over a long run, until t = {end}{halved}.");
        rows(out, &caption, &c.long);
    }
}

/// Quantities that are conserved because they are zero.
fn zero(conserved: &Conserved, zero: Components) -> String {
    let both = |a: [bool; 3], zero: [bool; 3]| [0, 1, 2].map(|i| a[i] && zero[i]);
    let zero = Conserved {
        energy: false,
        momentum: both(conserved.momentum, zero[0]),
        angular_momentum: both(conserved.angular_momentum, zero[1]),
    };
    match names(&zero).as_str() {
        "" => String::new(),
        names => format!(" Excluded, as zero in all runs: {names}."),
    }
}

/// A number of the drift of a run, if it is known.
type Part = fn(&Drift) -> Option<f64>;

fn rows(out: &mut Page, caption: &str, all: &[ComparisonRow]) {
    let columns: [(&str, Part); 8] = [
        ("energy", |d| d.energy),
        ("relative", |d| d.relative(d.energy)),
        ("momentum", |d| d.momentum),
        ("angular momentum", |d| d.angular_momentum),
        ("|h|", |d| d.violation),
        ("balance of energy", |d| d.balance),
        ("relative", |d| d.relative(d.balance)),
        ("trend, relative", |d| d.relative(d.trend)),
    ];
    run_table(out, caption, &columns.map(|c| c.0), all, |row| {
        Some(columns.map(|c| known(c.1(&row.drift))).to_vec())
    });
}

/// Description of the components of a momentum, if any.
fn components(name: &str, which: [bool; 3]) -> Option<String> {
    let numbers = (0..3).filter(|&i| which[i]);
    let numbers: Vec<String> = numbers.map(|i| (i + 1).to_string()).collect();
    match numbers.len() {
        0 => None,
        3 => Some(name.to_owned()),
        1 => Some(format!("{name} (component {})", numbers[0])),
        _ => Some(format!("{name} (components {})", numbers.join(", "))),
    }
}

/// The names of conserved quantities.
fn names(conserved: &Conserved) -> String {
    let all = [
        conserved.energy.then(|| "energy".to_owned()),
        components("momentum", conserved.momentum),
        components("angular momentum", conserved.angular_momentum),
    ];
    all.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Description of the conserved quantities of a motion.
fn described(conserved: &Conserved) -> String {
    match names(conserved).as_str() {
        "" => "The reference conserves neither energy nor momentum.".to_owned(),
        names => format!("The reference conserves {names}."),
    }
}
