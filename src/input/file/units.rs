//! Units in figures.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Names of the units of your choice, for the axes of figures; nothing is converted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Unit of lengths, such as "m".
    pub length: Option<String>,
    /// Unit of forces, such as "N".
    pub force: Option<String>,
    /// Unit of time, such as "s".
    pub time: Option<String>,
}

/// Dimension of a quantity: exponents of force, length, time and angle.
pub type Dimension = [i32; 4];

impl Units {
    /// Whether no unit has a name.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Label of an axis: the name of a quantity, and its unit where all parts of it have a name; angles are in radians.
    pub fn label(&self, quantity: &str, dimension: Dimension) -> String {
        match self.unit(dimension) {
            Some(unit) => format!("{quantity} [{unit}]"),
            None => quantity.to_owned(),
        }
    }

    fn unit(&self, dimension: Dimension) -> Option<String> {
        let named = [&self.force, &self.length, &self.time].map(Option::as_deref);
        let [mut above, mut below] = [Vec::new(), Vec::new()];
        for (name, power) in named.into_iter().chain([Some("rad")]).zip(dimension) {
            let part = if power > 0 { &mut above } else { &mut below };
            match power.abs() {
                0 => {}
                1 => part.push(name?.to_owned()),
                2 => part.push(format!("{}²", name?)),
                power => part.push(format!("{}^{power}", name?)),
            }
        }
        let [above, below] = [above, below].map(|part| part.join(" "));
        match (above.is_empty(), below.is_empty()) {
            (true, true) => None,
            (false, true) => Some(above),
            (true, false) => Some(format!("1/{below}")),
            (false, false) => Some(format!("{above}/{below}")),
        }
    }
}
