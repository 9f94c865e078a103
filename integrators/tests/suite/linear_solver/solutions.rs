//! The linear solvers against nalgebra's dense LU, against closed forms, and against each other.

use crate::support::linear_solver::*;
use crate::support::*;
use nalgebra::DVector;

#[test]
fn all_solvers_agree_with_a_dense_factorisation() {
    let mut random = Random::new(1);
    for (shape, nodes, edges) in graphs() {
        for (symmetric, indefinite, spread) in [
            (false, false, 1.0),
            (false, true, 1e4),
            (true, false, 1e4),
            (true, true, 1e3),
        ] {
            for uniform in [None, Some(6), Some(3), Some(1), Some(4)] {
                let sizes: Vec<usize> = (0..nodes)
                    .map(|_| uniform.unwrap_or_else(|| 1 + random.range(0.0, 6.0) as usize))
                    .collect();
                let pattern = BlockPattern::new(&sizes, &edges);
                let values = random_values(&pattern, &mut random, symmetric, indefinite, spread);
                let b = random_numbers(pattern.dim(), &mut random);
                let A = pattern.matrix(&values);
                // Relative to the largest in the unknown's own units.
                let units = A.diagonal().map(|d| d.abs().sqrt());
                let exact = A.lu().solve(&DVector::from_column_slice(&b)).unwrap();
                let most = exact.component_mul(&units).amax();
                let mut all = match symmetric {
                    true => symmetric_solvers(&pattern),
                    false => solvers(&pattern, General),
                };
                let general = BlockLu::new(&pattern, General).unwrap();
                all.push(("general", Box::new(general)));
                for (name, mut solver) in all {
                    for way in [solve, solve_at_once] {
                        let x = way(&mut *solver, &values, &b)
                            .unwrap_or_else(|e| panic!("{name} on {shape}: {e}"));
                        for (i, (x, e)) in x.iter().zip(exact.iter()).enumerate() {
                            let gap = (x - e).abs() * units[i] / most;
                            assert!(gap < 1e-10, "{name} on {shape}, {i}: {x} for {e}");
                        }
                    }
                }
                if nodes > 30 {
                    break; // the dense reference is the slow part: mixed sizes only
                }
            }
        }
    }
}

#[test]
fn empty_blocks_take_no_part() {
    let pattern = BlockPattern::new(&[0, 2, 0, 1], [[0, 1], [1, 2], [2, 3], [1, 3]]);
    let values = filled(&pattern, |r, c| if r == c { 4.0 } else { 1.0 });
    for (name, mut solver) in solvers(&pattern, General) {
        let x = solve(&mut *solver, &values, &[6.0; 3]).unwrap();
        assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-14), "{name}: {x:?}");
    }
    let nothing = BlockPattern::new(&[], Vec::<[u32; 1]>::new());
    for (_, mut solver) in solvers(&nothing, General) {
        solve(&mut *solver, &[], &[]).unwrap();
    }
}

/// A plane Bernoulli beam of elements of length `l`, clamped beyond one end, and its tip.
fn cantilever(elements: usize, l: f64, ei: f64, clamp_last: bool) -> (BlockPattern, Vec<f64>) {
    let groups: Vec<[u32; 2]> = (1..elements as u32).map(|i| [i - 1, i]).collect();
    let pattern = BlockPattern::new(&vec![2; elements], &groups);
    let mut values = vec![0.0; pattern.len()];
    let k = |a: usize, b: usize| {
        let f = ei / (l * l * l);
        f * [
            [12.0, 6.0 * l, -12.0, 6.0 * l],
            [6.0 * l, 4.0 * l * l, -6.0 * l, 2.0 * l * l],
            [-12.0, -6.0 * l, 12.0, -6.0 * l],
            [6.0 * l, 2.0 * l * l, -6.0 * l, 4.0 * l * l],
        ][a][b]
    };
    for e in 0..elements {
        // Ends of element e: with the clamp at the first end, node e - 1 and node e.
        let node = |end: usize| {
            if clamp_last {
                Some(e + end).filter(|&n| n < elements)
            } else {
                (e + end).checked_sub(1)
            }
        };
        for a in 0..4 {
            for b in 0..4 {
                if let (Some(i), Some(j)) = (node(a / 2), node(b / 2)) {
                    values[pattern.find(i, j).unwrap() + a % 2 + 2 * (b % 2)] += k(a, b);
                }
            }
        }
    }
    (pattern, values)
}

fn tip_error(elements: usize, l: f64, ei: f64, clamp_last: bool) -> Result<f64, LinearError> {
    let (pattern, values) = cantilever(elements, l, ei, clamp_last);
    let tip = if clamp_last { 0 } else { 2 * (elements - 1) };
    let mut b = vec![0.0; pattern.dim()];
    b[tip] = 1.0;
    let x = solve(&mut BlockLu::new(&pattern, Symmetric)?, &values, &b)?;
    let length = l * elements as f64;
    Ok((x[tip] / (length.powi(3) / (3.0 * ei)) - 1.0).abs())
}

#[test]
fn a_long_cantilever_is_not_singular() {
    // The condition number of the scaled matrix is about N⁴, 10¹⁶ for 10,000 elements: a relative
    // change of ε in one entry may move the exact solution by as much as the solution, so that no
    // tolerance can be promised from the condition alone. Elimination from the tip transfers
    // forces as a statically determinate structure does, one lever at a time, exactly where l and
    // EI are powers of two and with rounding errors of its own otherwise: the tolerances are N
    // times to N² times ε for these, with a margin of a thousand.
    for (elements, l, ei, tolerance) in [
        (10, 0.1, 7.3, 1e-10),
        (100, 0.1, 7.3, 1e-7),
        (1000, 0.1, 7.3, 1e-3),
        (10_000, 1.0, 1.0, 1e-10),
        (10_000, 0.125, 64.0, 1e-10),
    ] {
        let error = tip_error(elements, l, ei, false).unwrap();
        assert!(error < tolerance, "{elements} elements: {error}");
    }
    // Not dyadic, and from the wrong side: solved to backward stability (the solver checks the
    // residual), with an answer of the right sign and size at best.
    for (elements, clamp_last) in [(10_000, false), (1000, true), (10_000, true)] {
        tip_error(elements, 0.1, 7.3, clamp_last).unwrap();
    }
    let (pattern, values) = cantilever(10_000, 1.0, 1.0, false);
    let mut auto = AutoSolver::new(&pattern, Symmetric).unwrap();
    auto.factorise(&values).unwrap();
    assert_eq!(auto.active(), Some(SolverKind::Block));
}

#[test]
fn the_same_bits_twice() {
    let mut random = Random::new(7);
    for (_, nodes, edges) in graphs() {
        let sizes: Vec<usize> = (0..nodes)
            .map(|_| 1 + random.range(0.0, 6.0) as usize)
            .collect();
        let pattern = BlockPattern::new(&sizes, &edges);
        let values = random_values(&pattern, &mut random, false, true, 1e3);
        let b = random_numbers(pattern.dim(), &mut random);
        let [one, two] = [0, 1].map(|_| solvers(&pattern, General));
        for ((_, mut one), (_, mut two)) in one.into_iter().zip(two) {
            let x = solve(&mut *one, &values, &b).unwrap();
            let y = solve(&mut *two, &values, &b).unwrap();
            assert_eq!(x, y);
            // And factorising again changes nothing.
            one.factorise(&values).unwrap();
            let mut z = b.clone();
            one.solve(Some(&values), &mut z).unwrap();
            assert_eq!(x, z);
        }
    }
}

#[test]
fn dense_grids_go_to_the_general_solver_and_chains_do_not() {
    let chain: Vec<[u32; 2]> = (1..200).map(|i| [i - 1, i]).collect();
    let pattern = BlockPattern::new(&[6; 200], &chain);
    let block = BlockLu::new(&pattern, General).unwrap();
    assert!(block.suits());
    let block = BlockLu::new(&BlockPattern::dense(500), General).unwrap();
    assert!(!block.suits());
}

#[test]
fn saddle_points_are_solved_in_any_unit() {
    // Lengths and angles of three bodies, a heavy one beside two light ones that two equations couple
    // to each other and to an angle without mass.
    let edges = [vec![0, 1, 2], vec![1, 2, 3, 4]];
    let bare = BlockPattern::new(&[2, 2, 2, 2, 1], &edges);
    let mut random = Random::new(11);
    let base = random_values(&bare, &mut random, true, false, 1.0);
    let base = bare.matrix(&base);
    let solution = DVector::from_fn(9, |_, _| 1.0 + random.range(-1.0, 1.0));
    let masses = [1e10, 1e10, 1.0, 1.0, 1.0, 1.0];
    let multiplies = |i: usize| i == 6 || i == 7;
    for length in [1e-12, 1e-6, 1.0, 1e6, 1e12] {
        for energy in [1e-20, 1.0, 1e20] {
            // Numbers that a typical length and a typical multiplier have in these units.
            let size = |i: usize| match i {
                6 | 7 => energy,
                0 | 2 | 4 => length,
                _ => 1.0,
            };
            let entry = |r: usize, c: usize| match (multiplies(r), multiplies(c)) {
                (true, true) => 0.0,
                (true, false) => base[(r, c)] / size(c),
                (false, true) => base[(r, c)] / size(r),
                (false, false) if r == 8 || c == 8 => 0.0,
                (false, false) => {
                    let mass = f64::min(masses[r], masses[c]);
                    energy * mass * base[(r, c)] / (size(r) * size(c))
                }
            };
            let pattern = bare.clone().with_coordinates(|i| CoordinateInfo {
                size: size(i),
                is_multiplier: multiplies(i),
                ..CoordinateInfo::default()
            });
            let values = filled(&pattern, entry);
            let x: Vec<f64> = (0..9).map(|i| solution[i] * size(i)).collect();
            let mut b = vec![0.0; 9];
            pattern.multiply_add(1.0, &values, &x, &mut b);
            let mut lu = FaerLu::new(&pattern).unwrap();
            for symmetry in [Symmetric, General] {
                let mut auto = AutoSolver::new(&pattern, symmetry).unwrap();
                let solvers: [&mut dyn LinearSolver; 2] = [&mut auto, &mut lu];
                for solver in solvers {
                    let mut found = b.clone();
                    solver.factorise_and_solve(&values, &mut found).unwrap();
                    for (found, x) in found.iter().zip(&x) {
                        let gap = (found - x).abs() / x.abs();
                        assert!(gap < 1e-9, "{length:e} {energy:e}: {found:e}, not {x:e}");
                    }
                }
                // Multipliers behind their nodes, the angle behind them: nothing is interchanged.
                assert_eq!(auto.active(), Some(SolverKind::Block));
            }
        }
    }
}
