//! Finds values of a map that are not finite, before they are compared with anything.

use super::kinematics::Mapped;
use crate::forces::TestState;
use crate::layout::Layout;

/// Distance of neighbouring coordinates, in units, at which the map may be finite.
const BESIDE: f64 = 1e-3;

impl Mapped<'_> {
    /// Describes the first entry of x, its rates and operators that is not finite at a state, if any, and the
    /// coordinates along which the neighbours are finite.
    pub(crate) fn unknown(&self, s: &TestState) -> Option<String> {
        let n = self.map.dims().1;
        let (x, B) = self.tangent(s.t, s.x.as_slice());
        let [_, x_dot, x_ddot, _, B_dot, B_ddot] = self.kinematics(s);
        let names = ["x", "B", "x_dot", "x_ddot", "B_dot", "B_ddot"];
        let values = [x, B, x_dot, x_ddot, B_dot, B_ddot];
        let (row, value, name) = values.iter().zip(names).find_map(|(all, name)| {
            let k = all.iter().position(|x| !x.is_finite())?;
            Some((k % n, all[k], name))
        })?;
        let units = self.columns.units();
        let beside = units.iter().enumerate().filter(|(j, unit)| {
            [BESIDE, -BESIDE].iter().any(|step| {
                let mut s = s.clone();
                s.x[*j] += step * **unit;
                let (_, B) = self.tangent(s.t, s.x.as_slice());
                B.iter().all(|b| b.is_finite())
            })
        });
        let beside: Vec<String> = beside.map(|(j, _)| entry(self.columns, j)).collect();
        let what = if name == "x" { "value" } else { "derivative" };
        let mut why = format!(
            "{name} is {value} in the row of {}: phi has no {what} there",
            entry(self.rows, row)
        );
        if !beside.is_empty() {
            why += &format!("; it has beside, in {}", beside.join(", "));
        }
        Some(why)
    }
}

/// Name of coordinate i.
fn entry(of: &Layout, i: usize) -> String {
    let group = of.groups().iter().find(|g| g.range.contains(&i));
    group.map_or_else(String::new, |g| match g.range.len() {
        1 => g.name.clone(),
        _ => format!("{} ({})", g.name, i - g.range.start + 1),
    })
}
