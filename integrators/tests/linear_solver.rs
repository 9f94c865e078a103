//! The linear solvers against nalgebra's dense LU, against closed forms, and against each other on
//! singular matrices.

#![allow(clippy::unwrap_used)]

use nalgebra::{DMatrix, DVector};
use pullback_integrators::linear_solver::{
    AutoSolver, BlockLu, Chosen, FaerCholesky, FaerLu, LinearError, LinearSolver, Symmetry,
    null_vector,
};
use pullback_manifold::sparse::BlockPattern;

/// Numbers in (-1, 1), the same every time.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1_u64 << 30) as f64 - 1.0
    }

    fn size(&mut self) -> usize {
        1 + ((self.next() + 1.0) * 3.0) as usize % 6
    }
}

/// Shapes of structures: edges between nodes.
fn graphs() -> Vec<(&'static str, usize, Vec<[u32; 2]>)> {
    let chain = (1..40).map(|i| [i - 1, i]).collect();
    let tree = (1..60).map(|i| [(i - 1) / 3, i]).collect();
    let ring = (0..30).map(|i| [i, (i + 1) % 30]).collect();
    let star = (1..25).map(|i| [0, i]).collect();
    let mut grid = Vec::new();
    for x in 0..7 {
        for y in 0..8 {
            let here = 8 * x + y;
            if x < 6 {
                grid.push([here, here + 8]);
            }
            if y < 7 {
                grid.push([here, here + 1]);
            }
        }
    }
    let full = (0..9).flat_map(|i| (0..i).map(move |j| [i, j])).collect();
    vec![
        ("chain", 40, chain),
        ("tree", 60, tree),
        ("ring", 30, ring),
        ("star", 25, star),
        ("grid", 56, grid),
        ("full", 9, full),
        ("alone", 1, Vec::new()),
        ("two parts", 4, vec![[0, 2], [1, 3]]),
    ]
}

/// Random values, diagonally dominant up to the sign of the diagonal, rows and columns scaled to
/// the given spread of units.
fn random_values(
    pattern: &BlockPattern,
    random: &mut Random,
    symmetric: bool,
    indefinite: bool,
    spread: f64,
) -> Vec<f64> {
    let n = pattern.dim();
    let mut values: Vec<f64> = (0..pattern.len()).map(|_| random.next()).collect();
    let mut sums = vec![1.0; n];
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            for (k, index) in range.enumerate() {
                let (r, c) = (k % pattern.size(i), k / pattern.size(i));
                if symmetric && (i, r) > (j, c) {
                    // Taken over from the transposed entry.
                    let other = pattern.find(j, i).unwrap() + c + r * pattern.size(j);
                    values[index] = values[other];
                }
            }
        }
    }
    if symmetric {
        // The loop above read entries to the right before or after as they came: do both sides.
        let dense = dense(pattern, &values);
        write(pattern, &mut values, |r, c| dense[(r.min(c), r.max(c))]);
    }
    let matrix = dense(pattern, &values);
    for (r, sum) in sums.iter_mut().enumerate() {
        *sum += matrix.row(r).iter().map(|v| v.abs()).sum::<f64>();
    }
    let units: Vec<f64> = (0..n).map(|_| spread.powf(random.next())).collect();
    write(pattern, &mut values, |r, c| {
        let sign = if indefinite && r % 3 == 0 { -1.0 } else { 1.0 };
        let diagonal = if r == c { sign * sums[r] } else { 0.0 };
        (matrix[(r, c)] + diagonal) * units[r] * units[c]
    });
    values
}

fn write(pattern: &BlockPattern, values: &mut [f64], entry: impl Fn(usize, usize) -> f64) {
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            for (k, index) in range.enumerate() {
                let (r, c) = (k % pattern.size(i), k / pattern.size(i));
                let row = pattern.unknowns(i).start + r;
                values[index] = entry(row, pattern.unknowns(j).start + c);
            }
        }
    }
}

fn dense(pattern: &BlockPattern, values: &[f64]) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(pattern.dim(), pattern.dim());
    for j in 0..pattern.blocks() {
        for (i, range) in pattern.column(j) {
            for (k, index) in range.enumerate() {
                let (r, c) = (k % pattern.size(i), k / pattern.size(i));
                matrix[(pattern.unknowns(i).start + r, pattern.unknowns(j).start + c)] =
                    values[index];
            }
        }
    }
    matrix
}

fn solvers() -> Vec<(&'static str, Box<dyn LinearSolver>)> {
    vec![
        ("block", Box::new(BlockLu::new())),
        ("faer LU", Box::new(FaerLu::new())),
        ("auto", Box::new(AutoSolver::new())),
    ]
}

fn solve(
    solver: &mut dyn LinearSolver,
    pattern: &BlockPattern,
    symmetry: Symmetry,
    values: &[f64],
    b: &[f64],
) -> Result<Vec<f64>, LinearError> {
    solver.analyse(pattern, symmetry)?;
    solver.factorise(values)?;
    let mut x = b.to_vec();
    solver.solve(Some(values), &mut x)?;
    Ok(x)
}

/// As [`solve`], in one call.
fn solve_at_once(
    solver: &mut dyn LinearSolver,
    pattern: &BlockPattern,
    symmetry: Symmetry,
    values: &[f64],
    b: &[f64],
) -> Result<Vec<f64>, LinearError> {
    solver.analyse(pattern, symmetry)?;
    let mut x = b.to_vec();
    solver.factorise_and_solve(values, &mut x)?;
    Ok(x)
}

#[test]
fn all_solvers_agree_with_a_dense_factorisation() {
    let mut random = Random(1);
    for (shape, nodes, edges) in graphs() {
        for (symmetric, indefinite, spread) in [
            (false, false, 1.0),
            (false, true, 1e4),
            (true, false, 1e4),
            (true, true, 1e3),
        ] {
            for uniform in [None, Some(6), Some(3), Some(1), Some(4)] {
                let sizes: Vec<usize> = (0..nodes)
                    .map(|_| uniform.unwrap_or_else(|| random.size()))
                    .collect();
                let pattern = BlockPattern::new(&sizes, &edges);
                let values = random_values(&pattern, &mut random, symmetric, indefinite, spread);
                let b: Vec<f64> = (0..pattern.dim()).map(|_| random.next()).collect();
                let exact = dense(&pattern, &values)
                    .lu()
                    .solve(&DVector::from_column_slice(&b))
                    .unwrap();
                let symmetry = if symmetric {
                    Symmetry::Symmetric
                } else {
                    Symmetry::General
                };
                let mut all = solvers();
                all.push(("general", Box::new(BlockLu::new())));
                if symmetric {
                    all.push(("cholesky", Box::new(FaerCholesky::new())));
                }
                for (name, mut solver) in all {
                    let symmetry = if name == "general" {
                        Symmetry::General
                    } else {
                        symmetry
                    };
                    for way in [solve, solve_at_once] {
                        let x = way(&mut *solver, &pattern, symmetry, &values, &b)
                            .unwrap_or_else(|e| panic!("{name} on {shape}: {e}"));
                        for (i, (x, e)) in x.iter().zip(exact.iter()).enumerate() {
                            // Relative to the largest in the unknown's own units.
                            let unit = dense(&pattern, &values)[(i, i)].abs().sqrt();
                            let most = scaled_max(&pattern, &values, &exact);
                            assert!(
                                (x - e).abs() * unit < 1e-10 * most,
                                "{name} on {shape}, unknown {i}: {x} instead of {e}"
                            );
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

fn scaled_max(pattern: &BlockPattern, values: &[f64], x: &DVector<f64>) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..pattern.blocks() {
        let start = pattern.find(j, j).unwrap();
        for (c, u) in pattern.unknowns(j).enumerate() {
            let d = values[start + c * (pattern.size(j) + 1)].abs().sqrt();
            largest = largest.max(d * x[u].abs());
        }
    }
    largest
}

#[test]
fn empty_blocks_take_no_part() {
    let pattern = BlockPattern::new(&[0, 2, 0, 1], [[0, 1], [1, 2], [2, 3], [1, 3]]);
    let mut values = vec![0.0; pattern.len()];
    write(&pattern, &mut values, |r, c| if r == c { 4.0 } else { 1.0 });
    for (name, mut solver) in solvers() {
        let x = solve(
            &mut *solver,
            &pattern,
            Symmetry::General,
            &values,
            &[6.0; 3],
        )
        .unwrap();
        assert!(x.iter().all(|x| (x - 1.0).abs() < 1e-14), "{name}: {x:?}");
    }
    let nothing = BlockPattern::new(&[], Vec::<[u32; 1]>::new());
    for (_, mut solver) in solvers() {
        solve(&mut *solver, &nothing, Symmetry::General, &[], &[]).unwrap();
    }
}

/// Scalar springs between neighbours, and to the ground at the nodes given.
fn springs(nodes: usize, grounded: &[usize], random: &mut Random) -> (BlockPattern, Vec<f64>) {
    let groups: Vec<[u32; 2]> = (1..nodes as u32).map(|i| [i - 1, i]).collect();
    let pattern = BlockPattern::new(&vec![1; nodes], &groups);
    let mut values = vec![0.0; pattern.len()];
    let mut add = |i: usize, j: usize, k: f64| values[pattern.find(i, j).unwrap()] += k;
    for [i, j] in groups.iter().map(|g| g.map(|i| i as usize)) {
        let k = 3.0 + random.next();
        for (a, b, k) in [(i, i, k), (j, j, k), (i, j, -k), (j, i, -k)] {
            add(a, b, k);
        }
    }
    for &i in grounded {
        add(i, i, 1.0);
    }
    (pattern, values)
}

#[test]
fn an_unsupported_chain_is_singular_and_its_mechanism_is_a_translation() {
    let mut random = Random(2);
    for nodes in [2, 10, 1000, 10_000] {
        let (pattern, values) = springs(nodes, &[], &mut random);
        for symmetry in [Symmetry::General, Symmetry::Symmetric] {
            for (name, mut solver) in solvers() {
                solver.analyse(&pattern, symmetry).unwrap();
                let error = solver.factorise(&values).unwrap_err();
                assert!(
                    matches!(
                        error,
                        LinearError::VanishingPivot { .. } | LinearError::Singular { .. }
                    ),
                    "{name}: {error}"
                );
                // Elimination runs from the tip to the base: there a support is missing.
                if name != "faer LU"
                    && let LinearError::VanishingPivot { unknown, .. } = error
                {
                    assert_eq!(unknown, 0, "{name}");
                }
            }
        }
        let null = null_vector(&pattern, &values).unwrap();
        assert!(
            null.vector.iter().all(|v| (v - 1.0).abs() < 1e-6),
            "{nodes}: {null:?}"
        );
        assert!(null.residual < 1e-13, "{nodes}: {:.1e}", null.residual);
        // Supported at either end it is regular, and has no null vector.
        for end in [0, nodes - 1] {
            let (pattern, values) = springs(nodes, &[end], &mut random);
            for (name, mut solver) in solvers() {
                solver.analyse(&pattern, Symmetry::General).unwrap();
                solver
                    .factorise(&values)
                    .unwrap_or_else(|e| panic!("{name}, {nodes}: {e}"));
            }
            assert!(null_vector(&pattern, &values).is_none());
        }
    }
}

#[test]
fn a_zero_row_is_named_by_everybody() {
    let mut random = Random(3);
    let pattern = BlockPattern::new(&[6, 6, 6], [[0, 1], [1, 2]]);
    let full = random_values(&pattern, &mut random, true, false, 1.0);
    let matrix = dense(&pattern, &full);
    let mut values = full.clone();
    write(&pattern, &mut values, |r, c| {
        if r == 9 || c == 9 {
            0.0
        } else {
            matrix[(r, c)]
        }
    });
    let mut all = solvers();
    all.push(("cholesky", Box::new(FaerCholesky::new())));
    for (name, mut solver) in all {
        solver.analyse(&pattern, Symmetry::Symmetric).unwrap();
        let error = solver.factorise(&values).unwrap_err();
        assert_eq!(error, LinearError::ZeroRow { unknown: 9 }, "{name}");
        // And recovers.
        solver.factorise(&full).unwrap();
        solver.solve(Some(&full), &mut [1.0; 18]).unwrap();
    }
    let null = null_vector(&pattern, &values).unwrap();
    assert_eq!(null.vector.iter().position(|&v| v == 1.0), Some(9));
}

#[test]
fn exactly_singular_matrices_with_which_faer_reports_success_are_detected() {
    // Two equal rows within a block, and a structurally regular matrix of rank one.
    let pattern = BlockPattern::dense(2);
    let mut all = solvers();
    all.push(("cholesky", Box::new(FaerCholesky::new())));
    for (name, mut solver) in all {
        solver.analyse(&pattern, Symmetry::Symmetric).unwrap();
        let error = solver.factorise(&[1.0, 1.0, 1.0, 1.0]).unwrap_err();
        assert!(
            matches!(
                error,
                LinearError::VanishingPivot { .. } | LinearError::Singular { .. }
            ),
            "{name}: {error}"
        );
    }
}

#[test]
fn null_vector_of_an_unsymmetric_matrix() {
    // A = B P with P annihilating `v`: rows of a regular B minus their product with v.
    let mut random = Random(4);
    let pattern = BlockPattern::new(&[3, 2, 4], [[0, 1], [1, 2], [0, 2]]);
    let n = pattern.dim();
    let regular = random_values(&pattern, &mut random, false, false, 1.0);
    let matrix = dense(&pattern, &regular);
    let v = DVector::from_fn(n, |i, _| if i == 4 { 1.0 } else { 0.8 * random.next() });
    let projected = &matrix - (&matrix * &v) * v.transpose() / v.dot(&v);
    let mut values = regular.clone();
    write(&pattern, &mut values, |r, c| projected[(r, c)]);
    let null = null_vector(&pattern, &values).unwrap();
    for (a, b) in null.vector.iter().zip(v.iter()) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
    assert!(null_vector(&pattern, &regular).is_none());
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
    let mut solver = BlockLu::new();
    let x = solve(&mut solver, &pattern, Symmetry::Symmetric, &values, &b)?;
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
        println!("{elements} elements: tip off by {error:.1e}");
        assert!(error < tolerance, "{elements} elements: {error}");
    }
    // Not dyadic, and from the wrong side: solved to backward stability (the solver checks the
    // residual), with an answer of the right sign and size at best.
    for (elements, clamp_last) in [(10_000, false), (1000, true), (10_000, true)] {
        let error = tip_error(elements, 0.1, 7.3, clamp_last).unwrap();
        println!("{elements} elements, clamp last {clamp_last}: tip off by {error:.1e}");
    }
    let (pattern, values) = cantilever(10_000, 1.0, 1.0, false);
    let mut auto = AutoSolver::new();
    auto.analyse(&pattern, Symmetry::Symmetric).unwrap();
    auto.factorise(&values).unwrap();
    assert_eq!(auto.active(), Some(Chosen::Block));
}

#[test]
fn a_saddle_point_needs_the_fallback_and_gets_it() {
    // Node 0 carries nothing but multipliers; it is eliminated first as a leaf of node 1.
    let pattern = BlockPattern::new(&[3, 2, 3], [[0, 1], [0, 2]]);
    let mut random = Random(5);
    let base = dense(
        &pattern,
        &random_values(&pattern, &mut random, true, false, 1.0),
    );
    let mut values = vec![0.0; pattern.len()];
    write(&pattern, &mut values, |r, c| {
        let multiplier = |i: usize| (3..5).contains(&i);
        if multiplier(r) && multiplier(c) {
            0.0
        } else {
            base[(r, c)]
        }
    });
    let b: Vec<f64> = (0..8).map(|_| random.next()).collect();
    let exact = dense(&pattern, &values)
        .lu()
        .solve(&DVector::from_column_slice(&b))
        .unwrap();
    let mut block = BlockLu::new();
    block.analyse(&pattern, Symmetry::Symmetric).unwrap();
    assert!(matches!(
        block.factorise(&values),
        Err(LinearError::VanishingPivot { unknown: 3, .. })
    ));
    let mut auto = AutoSolver::new();
    auto.analyse(&pattern, Symmetry::Symmetric).unwrap();
    for _ in 0..5 {
        auto.factorise(&values).unwrap();
        assert_eq!(auto.active(), Some(Chosen::Lu));
        let mut x = b.clone();
        auto.solve(Some(&values), &mut x).unwrap();
        let mut at_once = b.clone();
        auto.factorise_and_solve(&values, &mut at_once).unwrap();
        assert_eq!(auto.active(), Some(Chosen::Lu));
        for (k, e) in exact.iter().enumerate() {
            assert!((x[k] - e).abs() < 1e-10 && (at_once[k] - e).abs() < 1e-10);
        }
    }
    let mut cholesky = FaerCholesky::new();
    let x = solve(&mut cholesky, &pattern, Symmetry::Symmetric, &values, &b).unwrap();
    assert!(!cholesky.is_positive_definite());
    assert!(
        x.iter()
            .zip(exact.iter())
            .all(|(x, e)| (x - e).abs() < 1e-10)
    );
    assert!(null_vector(&pattern, &values).is_none());

    // A constraint twice: the multipliers are not unique, and their difference is the null vector.
    let doubled = {
        let mut values = values.clone();
        let m = dense(&pattern, &values);
        write(&pattern, &mut values, |r, c| {
            let same = |i: usize| if i == 4 { 3 } else { i };
            m[(same(r), same(c))]
        });
        values
    };
    let mut auto = AutoSolver::new();
    auto.analyse(&pattern, Symmetry::Symmetric).unwrap();
    let error = auto.factorise(&doubled).unwrap_err();
    assert!(
        matches!(
            error,
            LinearError::VanishingPivot { unknown: 3 | 4, .. }
                | LinearError::Singular { unknown: 3 | 4, .. }
        ),
        "{error}"
    );
    let null = null_vector(&pattern, &doubled).unwrap();
    assert!((null.vector[3] - 1.0).abs() < 1e-8 && (null.vector[4] + 1.0).abs() < 1e-8);
}

#[test]
fn values_that_are_not_finite_are_named() {
    let mut random = Random(6);
    let pattern = BlockPattern::new(&[6, 6], [[0, 1]]);
    let good = random_values(&pattern, &mut random, false, false, 1.0);
    for bad in [f64::NAN, f64::INFINITY] {
        let mut values = good.clone();
        values[pattern.find(1, 0).unwrap() + 2] = bad;
        for (name, mut solver) in solvers() {
            solver.analyse(&pattern, Symmetry::General).unwrap();
            let error = solver.factorise(&values).unwrap_err();
            let expected = LinearError::NonFinite {
                what: "matrix",
                unknown: 8,
            };
            assert_eq!(error, expected, "{name}");
            assert!(matches!(
                solver.solve(Some(&values), &mut [0.0; 12]),
                Err(LinearError::NotReady { .. })
            ));
            let error = solver.factorise_and_solve(&values, &mut [0.0; 12]);
            assert_eq!(error.unwrap_err(), expected, "{name}");
            solver.factorise(&good).unwrap();
            let mut b = [1.0; 12];
            b[5] = bad;
            let error = solver.solve(Some(&good), &mut b).unwrap_err();
            let expected = LinearError::NonFinite {
                what: "right-hand side",
                unknown: 5,
            };
            assert_eq!(error, expected, "{name}");
            assert!(matches!(
                solver.solve(Some(&good), &mut [0.0; 11]),
                Err(LinearError::Length { .. })
            ));
            let error = solver.factorise_and_solve(&good, &mut b).unwrap_err();
            assert_eq!(error, expected, "{name}");
            assert!(b[0] == 1.0 && b[11] == 1.0, "{name} leaves b as it is");
            assert!(matches!(
                solver.factorise_and_solve(&good, &mut [0.0; 11]),
                Err(LinearError::Length { .. })
            ));
        }
    }
}

#[test]
fn the_same_bits_twice() {
    let mut random = Random(7);
    for (_, nodes, edges) in graphs() {
        let sizes: Vec<usize> = (0..nodes).map(|_| random.size()).collect();
        let pattern = BlockPattern::new(&sizes, &edges);
        let values = random_values(&pattern, &mut random, false, true, 1e3);
        let b: Vec<f64> = (0..pattern.dim()).map(|_| random.next()).collect();
        for ((_, mut one), (_, mut two)) in solvers().into_iter().zip(solvers()) {
            let x = solve(&mut *one, &pattern, Symmetry::General, &values, &b).unwrap();
            let y = solve(&mut *two, &pattern, Symmetry::General, &values, &b).unwrap();
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
    let mut block = BlockLu::new();
    block
        .analyse(&BlockPattern::new(&[6; 200], &chain), Symmetry::General)
        .unwrap();
    assert!(block.suits());
    // Per node 144 for the pivots and 2 × 432 for panel and update.
    assert!((block.flops() - (200.0 * 144.0 + 199.0 * 864.0)).abs() < 1e-6);
    block
        .analyse(&BlockPattern::dense(500), Symmetry::General)
        .unwrap();
    assert!(!block.suits());
}
