//! Functions of time: values, derivatives, kinks, and refused numbers.

use crate::support::*;

#[test]
fn constants_and_straight_lines_have_the_slopes_drawn() {
    assert_eq!(Constant(-2.5).at(7.0, &[]), [-2.5, 0.0, 0.0]);
    assert_eq!(Proportional(1.5).at(-2.0, &[]), [-3.0, 1.5, 0.0]);
    let ramp = Table::ramp(1.0, 3.0, 8.0).unwrap();
    let table = [[-1.0, 2.0], [1.0, 6.0], [1.5, 5.0], [4.0, 5.0]];
    let table = Table::new(table.to_vec()).unwrap();
    let triangle = Table::triangle(0.0, 0.5, 1.0, 40.0).unwrap();
    let rows: [(&Table, f64, [f64; 2]); 17] = [
        (&ramp, 0.5, [0.0, 0.0]),
        (&ramp, 1.0, [0.0, 4.0]),
        (&ramp, 2.0, [4.0, 4.0]),
        (&ramp, 3.0, [8.0, 0.0]),
        (&ramp, 9.0, [8.0, 0.0]),
        (&table, -2.0, [2.0, 0.0]),
        (&table, -1.0, [2.0, 2.0]),
        (&table, 0.0, [4.0, 2.0]),
        (&table, 1.0, [6.0, -2.0]),
        (&table, 1.25, [5.5, -2.0]),
        (&table, 1.5, [5.0, 0.0]),
        (&table, 9.0, [5.0, 0.0]),
        (&triangle, -1.0, [0.0, 0.0]),
        (&triangle, 0.25, [20.0, 80.0]),
        (&triangle, 0.5, [40.0, -80.0]),
        (&triangle, 0.75, [20.0, -80.0]),
        (&triangle, 2.0, [0.0, 0.0]),
    ];
    for (f, t, [value, slope]) in rows {
        assert_eq!(f.at(t, &[]), [value, slope, 0.0], "{f:?} at {t}");
    }
    assert_eq!(ramp.kinks(), [1.0, 3.0]);
    assert_eq!(table.kinks(), [-1.0, 1.0, 1.5, 4.0]);
    assert_eq!(triangle.kinks(), [0.0, 0.5, 1.0]);
}

#[test]
fn a_sine_has_its_mean_amplitude_frequency_and_phase() {
    let sine = Sine {
        amplitude: 3.0,
        omega: 2.0,
        phase: TAU / 12.0,
        offset: 1.0,
    };
    // Angles of 30°, 90° and 210°.
    let slope = 3.0 * 3.0_f64.sqrt();
    for (twelfths, expected) in [
        (0.0, [2.5, slope, -6.0]),
        (1.0, [4.0, 0.0, -12.0]),
        (3.0, [-0.5, -slope, 6.0]),
    ] {
        for (found, expected) in sine.at(twelfths * TAU / 12.0, &[]).iter().zip(expected) {
            assert!((found - expected).abs() < 1e-14, "{found} for {expected}");
        }
    }
    assert!(sine.kinks().is_empty());
}

#[test]
fn a_pulse_is_on_from_its_start_until_its_end() {
    let pulse = Pulse::new(0.0, 2.5, 8.0).unwrap();
    let on = [-0.1, 0.0, 2.5_f64.next_down(), 2.5].map(|t| pulse.at(t, &[])[0]);
    assert_eq!(on, [0.0, 8.0, 8.0, 0.0]);
    assert!(Pulse::new(1.0, 1.0, 2.0).is_err());
}

#[test]
fn a_spin_up_is_smooth_and_its_derivatives_are_its_own() {
    let f = SpinUp::new(6.0, 15.0).unwrap();
    for t in [15.0_f64.next_down(), 15.0] {
        let [x, v, a] = f.at(t, &[]);
        assert!((x - 45.0).abs() < 1e-12 && (v - 6.0).abs() < 1e-12 && a.abs() < 1e-12);
    }
    for t in [0.5, 3.0, 7.5, 14.0, 20.0] {
        let h = 1e-4;
        for k in 0..2 {
            let difference = (f.at(t + h, &[])[k] - f.at(t - h, &[])[k]) / (2.0 * h);
            assert!((difference - f.at(t, &[])[k + 1]).abs() < 1e-8);
        }
    }
    assert_eq!(f.at(0.0, &[]), [0.0; 3]);
    assert!(SpinUp::new(6.0, 0.0).is_err());
}

#[test]
fn bad_tables_are_refused() {
    refused! {
        Table::new(vec![]) => "a table needs at least one point",
        Table::new(vec![[0.0, f64::NAN]]) => "a time function needs finite numbers, got NaN",
        Table::ramp(1.0, 1.0, 2.0) => "times must increase strictly, but 1 is followed by 1",
    }
}

/// With x = 2πt/T: rate x² t² (1/24 − x²/720 + …)/T, where ½ t² + (cos x − 1) t²/x² has lost all digits.
#[test]
fn a_spin_up_begins_with_all_digits() {
    let (rate, T, t) = (6.0, 15.0, 1e-3);
    let x = std::f64::consts::TAU * t / T;
    let f = SpinUp::new(rate, T).unwrap().at(t, &[]);
    let series = [
        (x * t).powi(2) * (1.0 / 24.0 - x * x / 720.0),
        x * x * t * (1.0 / 6.0 - x * x / 120.0),
        x * x * (0.5 - x * x / 24.0),
    ];
    for (found, exact) in f.iter().zip(series.map(|x| rate / T * x)) {
        assert!((found / exact - 1.0).abs() < 1e-14, "{found:e} {exact:e}");
    }
}
