//! Modes of systems with exact eigenvalues, and of those without modes.

use crate::support::linear_solver::filled;
use crate::support::*;
use num_complex::Complex64;

/// Masses of one between n + 1 springs of one, fixed at both ends, with C = α M + β K.
fn chain(n: usize, alpha: f64, beta: f64) -> Linearized {
    let pattern = BlockPattern::new(&vec![1; n], (1..n as u32).map(|i| [i - 1, i]));
    let K = filled(&pattern, |i, j| if i == j { 2.0 } else { -1.0 });
    let M = filled(&pattern, |i, j| f64::from(i == j));
    let C = K.iter().zip(&M).map(|(K, M)| alpha * M + beta * K);
    Linearized {
        C: C.collect(),
        K,
        M,
        r_u: Vec::new(),
        names: (0..n).map(|i| format!("mass {i}")).collect(),
        pattern,
    }
}

/// ω of mode k.
fn omega(n: usize, k: usize) -> f64 {
    2.0 * (0.5 * k as f64 * std::f64::consts::PI / (n as f64 + 1.0)).sin()
}

#[track_caller]
fn near(found: f64, exact: f64, within: f64) {
    let error = (found / exact - 1.0).abs();
    assert!(error < within, "{found} for {exact}: {error:e}");
}

fn all(range: [f64; 2]) -> ModeOptions {
    ModeOptions {
        selection: Selection::Range(range),
        undamped: false,
    }
}

/// Chains side by side, each fixed at both ends: every eigenvalue occurs once in each.
#[test]
fn damped_modes_are_found_as_often_as_they_occur() {
    let (alpha, beta) = (1e-3, 0.3);
    let within = |copies: usize| if copies == 1 { 1e-12 } else { 1e-10 };
    for (n, copies, counts) in [
        (5, 1, 5..6),
        (40, 1, 5..6),
        (300, 1, 5..6),
        (100, 2, 1..6),
        (100, 3, 1..6),
    ] {
        let mut lin = chain(copies * n, alpha, beta);
        for between in (1..copies).map(|k| k * n) {
            for (i, j) in [(between - 1, between), (between, between - 1)] {
                let k = lin.pattern.find(i, j).unwrap();
                (lin.K[k], lin.C[k]) = (0.0, 0.0);
            }
        }
        for count in counts {
            let found = modes(&lin, &ModeOptions::lowest(count)).unwrap();
            assert_eq!((found.modes.len(), found.counted), (count, None));
            for (k, mode) in found.modes.iter().enumerate() {
                let omega = omega(n, k / copies + 1);
                let zeta = 0.5 * (alpha / omega + beta * omega);
                near(mode.omega(), omega, within(copies));
                near(mode.damping_ratio(), zeta, 1e-10);
                assert!(mode.residual < 1e-12, "{n}: {}", mode.residual);
            }
        }
    }
}

/// λ = −2 twice for each mass, with one shape: no other eigenvectors exist.
#[test]
fn critical_damping_of_several_masses() {
    for n in [1, 2, 3, 8] {
        let mut lin = chain(n, 4.0, 0.0);
        lin.K = lin.M.iter().map(|m| 4.0 * m).collect();
        let found = modes(&lin, &ModeOptions::lowest(2 * n)).unwrap();
        assert_eq!(found.modes.len(), 2 * n);
        for mode in &found.modes {
            let error = (mode.eigenvalue + 2.0).norm();
            assert!(error < 1e-6, "{n}: {error:e}");
            assert!(mode.residual < 1e-7, "{n}: {:e}", mode.residual);
        }
    }
}

/// A rotor on springs at its critical speed, in rotating coordinates: what is left of K is the drag d of a damper that does not
/// rotate, and is skew. With z = x + i y, z̈ + (d + 2 i) ż + i d z = 0.
#[test]
fn a_rotor_at_its_critical_speed() {
    let d = 0.01;
    let mut lin = chain(2, d, 0.0);
    lin.K.fill(0.0);
    for (i, j, sign) in [(0, 1, -1.0), (1, 0, 1.0)] {
        let k = lin.pattern.find(i, j).unwrap();
        (lin.K[k], lin.C[k]) = (sign * d, 2.0 * sign);
    }
    let sum = Complex64::new(d, 2.0);
    let root = (sum * sum - Complex64::new(0.0, 4.0 * d)).sqrt();
    let exact = [root, -root].map(|root| 0.5 * (root - sum));
    let found = modes(&lin, &ModeOptions::lowest(2)).unwrap();
    for (mode, exact) in found.modes.iter().zip(exact) {
        let off = |exact: Complex64| (mode.eigenvalue - exact).norm();
        let error = off(exact).min(off(exact.conj()));
        assert!(error < 1e-12, "{}: {error:e}", mode.eigenvalue);
    }
}

#[test]
fn a_range_contains_the_frequencies_at_its_ends() {
    for (n, beta) in [(5, 0.0), (5, 0.1), (2000, 0.0), (300, 0.1)] {
        let ends = [2, 4].map(|k| omega(n, k));
        let found = modes(&chain(n, 0.0, beta), &all(ends)).unwrap();
        assert_eq!(found.modes.len(), 3, "{n}, {beta}");
    }
}

/// Two masses of one with a circulatory force have ω² = 0.2 ± 0.98 i: |λ| = 1, whatever the real part.
#[test]
fn a_range_contains_modes_of_a_flutter() {
    let mut lin = chain(2, 0.0, 0.0);
    for (i, j, K) in [(0, 0, 0.2), (1, 1, 0.2), (0, 1, 0.98), (1, 0, -0.98)] {
        let k = lin.pattern.find(i, j).unwrap();
        lin.K[k] = K;
    }
    let size = 0.2_f64.hypot(0.98).sqrt();
    let found = modes(&lin, &all([0.9, 1.1])).unwrap();
    assert_eq!(found.modes.len(), 2);
    for mode in &found.modes {
        near(mode.omega(), size, 1e-14);
    }
}

#[test]
fn modes_in_a_range_are_counted() {
    let n = 2000;
    let inside = |range: [f64; 2]| {
        let all = (1..=n).map(|k| omega(n, k));
        let inside = all.filter(|omega| (range[0]..range[1]).contains(omega));
        inside.count()
    };
    for range in [[0.5, 0.51], [1.9999, 2.1], [0.0, 0.01]] {
        let found = modes(&chain(n, 0.0, 0.0), &all(range)).unwrap();
        assert_eq!(found.counted, Some(inside(range)));
        assert_eq!(found.modes.len(), inside(range));
    }
    let empty = modes(&chain(n, 0.0, 0.0), &all([2.1, 3.0])).unwrap();
    assert_eq!((empty.modes.len(), empty.counted), (0, Some(0)));
    let damped = modes(&chain(n, 0.0, 0.2), &all([0.0, 0.02])).unwrap();
    assert_eq!(damped.modes.len(), inside([0.0, 0.02]));
}

#[test]
fn more_modes_than_freedoms() {
    let found = modes(&chain(3, 0.0, 0.0), &ModeOptions::lowest(10)).unwrap();
    assert!(found.complete && found.modes.len() == 3 && found.counted == Some(3));
    let damped = modes(&chain(3, 0.0, 0.1), &ModeOptions::lowest(10)).unwrap();
    assert!(damped.complete && damped.modes.len() == 3);
}

#[test]
fn coordinates_without_mass() {
    for beta in [0.0, 0.3] {
        // Every second mass is zero: springs of one half between the others.
        let mut lin = chain(401, 0.0, beta);
        let diagonal: Vec<usize> = lin.pattern.diagonal().collect();
        for k in diagonal.iter().step_by(2) {
            lin.M[*k] = 0.0;
        }
        let found = modes(&lin, &ModeOptions::lowest(6)).unwrap();
        assert_eq!(found.modes.len(), 6);
        if beta == 0.0 {
            // At the shift zero, and beyond the last mode, to count.
            assert_eq!((found.counted, found.factorisations), (Some(6), 2));
        }
        for (k, mode) in found.modes.iter().enumerate() {
            let exact = omega(200, k + 1) / 2.0_f64.sqrt();
            near(mode.omega(), exact, 1e-12);
            assert!(mode.residual < 1e-13, "{beta}: {}", mode.residual);
        }
    }
}

#[test]
fn systems_and_requests_without_modes() {
    let refused = |lin: &Linearized, options: &ModeOptions| modes(lin, options).unwrap_err();
    let mut lin = chain(4, 0.0, 0.0);
    for options in [ModeOptions::lowest(0), all([2.0, 1.0])] {
        assert!(matches!(refused(&lin, &options), ModesError::Options(_)));
    }
    lin.M[0] = -1.0;
    let error = refused(&lin, &ModeOptions::lowest(1)).to_string();
    assert!(error.contains("mass 0"), "{error}");
    lin.M.fill(0.0);
    assert_eq!(refused(&lin, &ModeOptions::lowest(1)), ModesError::NoMass);
}

#[test]
fn a_system_without_stiffness_has_zero_frequencies() {
    let mut lin = chain(4, 0.0, 0.0);
    lin.K.fill(0.0);
    let found = modes(&lin, &ModeOptions::lowest(4)).unwrap();
    assert!(found.modes.iter().all(|mode| mode.omega() == 0.0) && found.modes.len() == 4);
    assert!(found.modes.iter().all(|mode| mode.residual == 0.0));
}

/// A massless end behind a spring of one and a damper β relaxes with λ = −1/β, and nothing else moves. The masses before it
/// are a chain with a free end.
#[test]
fn a_massless_end_relaxes() {
    let mut lin = chain(4, 0.0, 0.0);
    let at = |lin: &Linearized, i, j| lin.pattern.find(i, j).unwrap();
    let beta = 0.1;
    for (i, j, damping) in [(2, 2, beta), (3, 3, beta), (2, 3, -beta), (3, 2, -beta)] {
        let k = at(&lin, i, j);
        lin.C[k] = damping;
    }
    let last = at(&lin, 3, 3);
    (lin.K[last], lin.M[last]) = (1.0, 0.0);
    let found = modes(&lin, &ModeOptions::lowest(10)).unwrap();
    assert!(found.complete && found.modes.len() == 4);
    let (relaxing, rest): (Vec<_>, Vec<_>) =
        (found.modes.iter()).partition(|mode| mode.eigenvalue.im == 0.0);
    near(relaxing[0].eigenvalue.re, -1.0 / beta, 1e-13);
    let shape = relaxing[0].shape.iter().map(|x| x.norm());
    for (x, exact) in shape.zip([0.0, 0.0, 0.0, 1.0]) {
        assert!((x - exact).abs() < 1e-13, "{relaxing:?}");
    }
    for (k, mode) in rest.iter().enumerate() {
        let exact = 2.0 * ((2 * k + 1) as f64 * std::f64::consts::PI / 14.0).sin();
        near(mode.eigenvalue.im, exact, 1e-12);
        assert!(mode.eigenvalue.re.abs() < 1e-13 && mode.residual < 1e-13);
    }
}

/// A mass without a spring does not move, whatever the other one does.
#[test]
fn a_rigid_mode_beside_an_unstable_one() {
    let mut lin = chain(2, 0.0, 0.0);
    lin.K.fill(0.0);
    let [one, coupling, other] =
        [(1, 1), (0, 1), (1, 0)].map(|(i, j)| lin.pattern.find(i, j).unwrap());
    lin.K[one] = -3.0;
    (lin.M[coupling], lin.M[other]) = (0.3, 0.3);
    let found = modes(&lin, &ModeOptions::lowest(2)).unwrap();
    assert_eq!(found.modes[0].eigenvalue, 0.0.into());
    // M⁻¹ K has the trace −3 / (1 − 0.09).
    let growth = (3.0_f64 / 0.91).sqrt();
    near(found.modes[1].eigenvalue.re, growth, 1e-13);
}

#[test]
fn an_observer_ends_the_search() {
    let lin = chain(2000, 0.0, 0.0);
    let mut stop = |dimension| match dimension < 3 {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    let ended = modes_while(&lin, &ModeOptions::lowest(5), &mut stop);
    assert_eq!(ended.unwrap_err(), ModesError::Interrupted);
}

/// Three coordinates with these matrices, K and M diagonal.
fn three(K: [f64; 3], C: [[f64; 3]; 3], M: [f64; 3]) -> Linearized {
    let diagonal = |x: [f64; 3]| {
        (0..9)
            .map(|k| if k % 4 == 0 { x[k / 4] } else { 0.0 })
            .collect()
    };
    Linearized {
        K: diagonal(K),
        C: C.concat(),
        M: diagonal(M),
        r_u: Vec::new(),
        names: ["a", "b", "c"].map(str::to_owned).to_vec(),
        pattern: BlockPattern::dense(3),
    }
}

/// ω² = −4, 9, 25: the first one grows with λ = 2.
#[test]
fn a_range_holds_growing_modes_with_and_without_damping() {
    for damping in [0.0, 1e-9] {
        let mut C = [[0.0; 3]; 3];
        C[1][1] = damping;
        let lin = three([-4.0, 9.0, 25.0], C, [1.0; 3]);
        for (range, exact) in [
            ([0.0, 4.0], &[2.0, 3.0][..]),
            ([1.5, 2.5], &[2.0]),
            ([2.5, 6.0], &[3.0, 5.0]),
        ] {
            let found = modes(&lin, &all(range)).unwrap().modes;
            // With damping λ = −2 is a mode of its own.
            let growing = found.iter().filter(|m| m.eigenvalue.re > -1.0);
            let found: Vec<f64> = growing.map(|m| m.eigenvalue.norm()).collect();
            assert_eq!(found.len(), exact.len(), "{damping} {range:?}: {found:?}");
            for (found, exact) in found.iter().zip(exact) {
                near(*found, *exact, 1e-8);
            }
        }
    }
}

/// K = diag(1, 4, 9) and a triangular M: ω² are the quotients of their diagonals.
#[test]
fn a_mass_matrix_need_not_be_symmetric() {
    let mut lin = three([1.0, 4.0, 9.0], [[0.0; 3]; 3], [1.0; 3]);
    lin.M[3] = 5.0;
    let found = modes(&lin, &ModeOptions::lowest(3)).unwrap().modes;
    for (mode, omega) in found.iter().zip([1.0, 2.0, 3.0]) {
        near(mode.omega(), omega, 1e-12);
    }
    assert_eq!(found.len(), 3);
}

/// Two free carts with dampers to each other, to a third one and to the ground: K x = 0 for both, so that λ = 0 twice.
#[test]
fn two_rigid_modes_with_dampers_are_both_found() {
    let C = [[3.0, -2.0, -1.0], [-2.0, 4.0, -2.0], [-1.0, -2.0, 5.0]];
    let lin = three([0.0, 0.0, 5.0], C, [3.0, 4.0, 3.0]);
    let found = modes(&lin, &ModeOptions::lowest(6)).unwrap().modes;
    let rigid = found.iter().filter(|m| m.eigenvalue.norm() < 1e-7);
    assert_eq!(rigid.count(), 2, "{found:?}");
    // Each is asked for and found once: the others are −0.717, −0.663 ± 0.718 i and −1.62.
    for count in 1..=5 {
        let found = modes(&lin, &ModeOptions::lowest(count)).unwrap().modes;
        assert_eq!(found.len(), count, "{found:?}");
    }
}

/// Frequencies 1, 3 and 10: 3 is nearer to 2.1 than 1, but its square is farther.
#[test]
fn the_nearest_modes_are_nearest_by_frequency() {
    for damping in [0.0, 1e-9] {
        let mut C = [[0.0; 3]; 3];
        C[1][1] = damping;
        let lin = three([1.0, 9.0, 100.0], C, [1.0; 3]);
        for (omega, count, exact) in [
            (2.1, 1, &[3.0][..]),
            (1.9, 1, &[1.0]),
            (2.1, 2, &[1.0, 3.0]),
        ] {
            let selection = Selection::Nearest { count, omega };
            let options = ModeOptions {
                selection,
                undamped: false,
            };
            let found = modes(&lin, &options).unwrap().modes;
            assert_eq!(found.len(), count, "{damping} {omega}");
            for (mode, exact) in found.iter().zip(exact) {
                near(mode.omega(), *exact, 1e-8);
            }
        }
    }
}
