//! `drift.csv`: energies and momenta at all common times of all runs, the data of the figure of drift.

use super::tables::number;
use super::{Comparison, ComparisonRow};

/// One line per run and common time reached; unknown values are empty. Runs with late changes of chart are left out.
pub(super) fn csv(comparison: &Comparison) -> String {
    let mut out =
        "run,scheme,step,t,energy,energy_balance_defect,momentum_1,momentum_2,momentum_3,\
                   angular_momentum_1,angular_momentum_2,angular_momentum_3,violation\n"
            .to_owned();
    for (run, all) in [("compared", &comparison.rows), ("long", &comparison.long)] {
        all.iter().for_each(|row| rows(&mut out, run, row));
    }
    out
}

fn rows(out: &mut String, run: &str, row: &ComparisonRow) {
    for sample in &row.samples {
        let momenta = sample.momenta.iter().flat_map(|p| p.iter().copied());
        let numbers = [Some(sample.energy), sample.defect].into_iter();
        let numbers = numbers.chain(momenta.map(Some)).chain([sample.violation]);
        let cells: Vec<String> = numbers.map(number).collect();
        let (scheme, step, t, cells) = (&row.scheme, row.step, sample.t, cells.join(","));
        *out += &format!("{run},{scheme},{step},{t},{cells}\n");
    }
}
