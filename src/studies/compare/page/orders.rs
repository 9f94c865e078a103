//! Tables of orders and of the reference.

use super::{Page, escaped, exact, with_errors};
use crate::studies::compare::order::{ABOVE_REFERENCE, NEAR, STRAIGHT};
use crate::studies::compare::tables::{order, short, theory};
use crate::studies::compare::{Comparison, ErrorQuantity, Reference, SchemeOrders, Slope, unknown};

pub(super) fn orders(out: &mut Page, c: &Comparison) {
    let caption = format!(
        "Slope of log error over log step by least squares, ± half of its 95 % confidence interval \
         (Student), and the number of step sizes on that line: from the two \
         finest on while slopes between neighbours differ by at most {STRAIGHT}, errors below {} \
         times the error of the reference and runs with rejected steps left out. It is an order where \
         three steps at least lie on the line and its slope is within {NEAR} of theory. A steeper line \
         of three steps is <small>above theory</small>: the leading term of the error is smaller at \
         these steps than the next one. Any other slope is <span class=\"slope\">grey, in \
         brackets</span>, and no order: steps are not (or not seen to be) in the asymptotic range. – \
         stands where fewer than two errors can be used.{}",
        ABOVE_REFERENCE as usize,
        levels(c)
    );
    out.table(&caption, &with_errors(&["scheme", "theory"]), 1);
    for scheme in &c.orders {
        let mut row = vec![
            escaped(&scheme.scheme),
            theory(scheme.theory).replace('-', "–"),
        ];
        row.extend(ErrorQuantity::ALL.map(|q| match scheme.of(q) {
            None => "–".to_owned(),
            Some(o) => {
                let steps = format!("<br/><small>{} steps</small>", o.points);
                let slope = escaped(&order(&o));
                match scheme.slope(q) {
                    Some(Slope::Theory) => slope + &steps,
                    Some(Slope::Above) => format!("{slope}{steps}<br/><small>above theory</small>"),
                    _ => format!("<span class=\"slope\">({slope})</span>{steps}"),
                }
            }
        }));
        out.row(false, 1, &row);
    }
    out.end_table();
    formulations(out, c);
}

/// Note on theory with several orders.
fn levels(c: &Comparison) -> &'static str {
    let mut orders = c.orders.iter().filter_map(|o| o.theory);
    match orders.all(|o| o.0.iter().all(|p| *p == o.0[0])) {
        true => "",
        false => {
            " The equations of multipliers are of index 3: where theory has several orders they are those of \
             positions, velocities and accelerations."
        }
    }
}

/// Description of the rotations in each scheme, unless they are the same in all.
fn formulations(out: &mut Page, c: &Comparison) {
    let first = c.orders.first().map(|o| o.formulation);
    if c.orders.iter().all(|o| Some(o.formulation) == first) {
        return;
    }
    let text = "Rotations of frames are unknowns in these formulations:";
    out.paragraph("", text);
    let item = |scheme: &SchemeOrders| {
        let [name, formulation] = [&scheme.scheme[..], scheme.formulation].map(escaped);
        format!("<code>{name}</code>: {formulation}")
    };
    out.list(&c.orders.iter().map(item).collect::<Vec<_>>());
}

pub(super) fn describe(out: &mut Page, comparison: &Comparison, r: &Reference) {
    let name = escaped(&r.scheme);
    if r.steps[2] == 0.0 {
        let text = format!(
            "Errors are those against a solution that is given: <code>{name}</code>. It knows the \
             quantities that have errors below."
        );
        return out.paragraph("", &text);
    }
    let [a, b, c] = r.steps.map(exact);
    let text = format!(
        "Reference: <code>{name}</code> with step sizes A = {a}, B = {b} and C = {c}. A quantity \
         whose observed order is that in theory is extrapolated from B and C after Richardson, \
         and the estimate of its error is twice the distance from the extrapolation of A and B. {} \
         evaluations, {} changes of chart in C.",
        r.evaluations, r.chart_changes
    );
    out.paragraph("", &text);
    out.table("The reference's own error", &with_errors(&[""]), 1);
    let mut row = |name: &str, value: &dyn Fn(ErrorQuantity) -> String| {
        let values = ErrorQuantity::ALL.map(value).to_vec();
        out.row(false, 1, &[vec![name.to_owned()], values].concat());
    };
    row("observed order", &|q| match r.order.of(q) {
        order if order.is_finite() => format!("{order:.2}").replace('-', "−"),
        _ => "–".to_owned(),
    });
    row("extrapolated", &|q| {
        if r.extrapolated.of(q) { "yes" } else { "no" }.to_owned()
    });
    row("error (rms)", &|q| short(r.error.of(q)));
    out.end_table();
    if let Some(why) = unknown(comparison) {
        let capital = why[..1].to_uppercase() + &why[1..];
        out.paragraph("warning", &format!("{}.", escaped(&capital)));
    }
}
