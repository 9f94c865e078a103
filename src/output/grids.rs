//! Selection and names of the grids (ParaView files) of rows.

use super::history::HistoryRow;
use super::vtu::VtuFrame;
use crate::input::Plan;

/// Approximate default number of grids of a motion.
const GRIDS: f64 = 200.0;

/// Name of the grid of a row.
pub(super) fn grid_name(plan: &Plan, number: usize) -> String {
    match plan {
        Plan::Dynamic(_) => format!("step_{number:06}.vtu"),
        _ => format!("step_{number:04}.vtu"),
    }
}

/// The grids of rows.
pub(super) fn frames(plan: &Plan, rows: &[HistoryRow]) -> Vec<VtuFrame> {
    let written = rows.iter().enumerate().filter(|(_, row)| row.grid);
    let frame = |(number, row): (usize, &HistoryRow)| VtuFrame {
        // A path may turn back in the load; ParaView needs ascending times.
        t: match plan {
            Plan::Path(..) => number as f64,
            _ => row.t,
        },
        file: grid_name(plan, number),
    };
    written.map(frame).collect()
}

/// When a grid is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Grids {
    /// Never.
    None,
    /// Every this many rows.
    Rows(usize),
    /// At the first row in each interval of this duration.
    Spans(f64),
}

impl Grids {
    /// As often as the model file says, or by default.
    pub fn of(every: Option<usize>, plan: &Plan) -> Self {
        match (every, plan) {
            (Some(0), _) => Self::None,
            (Some(every), _) => Self::Rows(every),
            (None, Plan::Dynamic(plan)) => Self::Spans(plan.options.to / GRIDS),
            (None, _) => Self::Rows(1),
        }
    }

    /// Whether row `number` at time `t`, after a row at time `before`, has a grid.
    pub fn due(self, number: usize, before: Option<f64>, t: f64) -> bool {
        match self {
            Self::None => false,
            Self::Rows(every) => number.is_multiple_of(every),
            Self::Spans(span) => {
                // Tolerates rounding of times at the beginning of an interval.
                let span = |t: f64| (t / span + 1e-6).floor();
                before.is_none_or(|before| span(before) < span(t))
            }
        }
    }
}
