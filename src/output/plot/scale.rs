//! Linear and logarithmic axes: positions of values and ticks.

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisScale {
    /// Linear.
    Linear,
    /// Logarithmic; values that are not positive are not drawn.
    Logarithmic,
}

impl AxisScale {
    /// Position of a value: itself, or its decimal logarithm; `None` if it cannot be drawn.
    pub(super) fn position(self, value: f64) -> Option<f64> {
        let position = match self {
            Self::Linear => value,
            Self::Logarithmic if value > 0.0 => value.log10(),
            Self::Logarithmic => return None,
        };
        position.is_finite().then_some(position)
    }

    /// Ticks between two positions, and the labels of some of them.
    pub(super) fn ticks(self, range: [f64; 2], most: usize) -> Vec<(f64, Option<String>)> {
        match self {
            Self::Linear => linear(range, most),
            Self::Logarithmic => logarithmic(range, most),
        }
    }
}

/// A number as a tick label.
pub(super) fn tick(value: f64, range: f64) -> String {
    if value.abs() < 1e-9 * range {
        return "0".to_owned();
    }
    let size = value.abs().max(range);
    let text = if (1e-3..1e5).contains(&size) {
        // Four digits of the range suffice for ticks.
        let digits = (3.0 - range.log10().floor()).clamp(0.0, 9.0) as usize;
        let fixed = format!("{value:.digits$}");
        match fixed.contains('.') {
            true => fixed.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => fixed,
        }
    } else {
        let short = format!("{value:.3e}");
        let (number, exponent) = short.split_once('e').unwrap_or((&short, "0"));
        let number = number.trim_end_matches('0').trim_end_matches('.');
        format!("{number}e{exponent}")
    };
    text.replace('-', "−")
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn linear([low, high]: [f64; 2], most: usize) -> Vec<(f64, Option<String>)> {
    let size = high - low;
    let least = size / most.max(1) as f64;
    let decade = 10f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|f| f * decade >= least);
    let step = factor.unwrap_or(10.0) * decade;
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    let values = (first..=last).map(|k| k as f64 * step);
    values.map(|x| (x, Some(tick(x, size)))).collect()
}

/// Powers of ten if there are two of them; otherwise 1, 2 and 5 times one, or every digit.
fn logarithmic([low, high]: [f64; 2], most: usize) -> Vec<(f64, Option<String>)> {
    let inside = |x: &f64| (low..=high).contains(x);
    let [from, to] = [low.floor() as i32, high.ceil() as i32];
    let digit = |d: u8, k: i32| f64::from(d).log10() + f64::from(k);
    let decades: Vec<i32> = (from..=to).filter(|&k| inside(&f64::from(k))).collect();
    let all_digits = || {
        let digits = (from..=to).flat_map(|k| (1..=9).map(move |d| (d, k)));
        digits.filter(|&(d, k)| inside(&digit(d, k)))
    };
    if decades.len() < 2 {
        let some: &[u8] = match high - low {
            w if w < 0.4 => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
            _ => &[1, 2, 5],
        };
        let ticks = all_digits().map(|(d, k)| {
            let value = f64::from(d) * 10f64.powi(k);
            (digit(d, k), some.contains(&d).then(|| tick(value, value)))
        });
        return ticks.collect();
    }
    let stride = decades.len().div_ceil(most.max(2)) as i32;
    let label = |d: u8, k: i32| (d == 1 && k.rem_euclid(stride) == 0).then(|| power(k));
    match stride {
        1 => (all_digits().map(|(d, k)| (digit(d, k), label(d, k)))).collect(),
        _ => (decades.iter().map(|&k| (f64::from(k), label(1, k)))).collect(),
    }
}

/// 10ᵏ in small raised digits.
fn power(k: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = k
        .to_string()
        .chars()
        .map(|c| match c.to_digit(10) {
            Some(d) => DIGITS[d as usize],
            None => '⁻',
        })
        .collect::<String>();
    format!("10{raised}")
}
