//! Time per node of the linear solvers on chains and grids of six-dof nodes.
//!
//! `cargo run --release -p pullback-integrators --example linear_solver_bench`

use std::time::Instant;

use pullback_integrators::linear_solver::{
    BlockLu, FaerLdlt, FaerLu, LinearError, LinearSolver, MatrixSymmetry,
};
use pullback_manifold::sparse::BlockPattern;

fn chain(nodes: u32) -> Vec<[u32; 2]> {
    (1..nodes).map(|i| [i - 1, i]).collect()
}

fn grid(side: u32) -> Vec<[u32; 2]> {
    let right = (0..side * side)
        .filter(|i| i % side + 1 < side)
        .map(|i| [i, i + 1]);
    let down = (0..side * (side - 1)).map(|i| [i, i + side]);
    right.chain(down).collect()
}

/// A dense 12 × 12 element matrix on each edge, plus mass.
fn assemble(nodes: usize, groups: &[[u32; 2]]) -> (BlockPattern, Vec<f64>) {
    let pattern = BlockPattern::new(&vec![6; nodes], groups);
    let mut values = vec![0.0; pattern.len()];
    let mut state = 1_u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
    };
    for group in groups {
        // G Gᵀ with 6 columns, difference of the nodes dominating: symmetric, semidefinite.
        let g: Vec<f64> = (0..72).map(|_| random()).collect();
        for a in 0..12 {
            for b in 0..12 {
                let sum: f64 = (0..6).map(|p| g[a + 12 * p] * g[b + 12 * p]).sum();
                let (i, j) = (group[a / 6] as usize, group[b / 6] as usize);
                if let Some(start) = pattern.find(i, j) {
                    values[start + a % 6 + 6 * (b % 6)] += sum;
                }
            }
        }
    }
    for i in 0..nodes {
        if let Some(start) = pattern.find(i, i) {
            for k in 0..6 {
                values[start + 7 * k] += 0.5;
            }
        }
    }
    (pattern, values)
}

/// Best of several runs, in nanoseconds per node: factorise and solve.
fn measure(
    solver: &mut dyn LinearSolver,
    pattern: &BlockPattern,
    values: &[f64],
    symmetry: MatrixSymmetry,
) -> Result<[f64; 2], LinearError> {
    solver.analyse(pattern, symmetry)?;
    let nodes = pattern.blocks() as f64;
    let mut best = [f64::INFINITY; 2];
    let mut b = vec![0.0; pattern.dim()];
    for _ in 0..(1_000_000 / pattern.dim()).clamp(5, 1000) {
        let start = Instant::now();
        solver.factorise(values)?;
        best[0] = best[0].min(start.elapsed().as_nanos() as f64 / nodes);
        b.iter_mut()
            .enumerate()
            .for_each(|(i, b)| *b = (i as f64).sin());
        let start = Instant::now();
        solver.solve(Some(values), &mut b)?;
        best[1] = best[1].min(start.elapsed().as_nanos() as f64 / nodes);
    }
    Ok(best)
}

fn main() -> Result<(), LinearError> {
    println!("nanoseconds per node of 6 unknowns");
    println!(
        "{:>7} {:>24} {:>10} {:>10} {:>10}",
        "nodes", "solver", "factorise", "solve", "sum"
    );
    let shapes = [
        (100, chain(100)),
        (1_000, chain(1_000)),
        (10_000, chain(10_000)),
        (100, grid(10)),
        (900, grid(30)),
        (3_600, grid(60)),
    ];
    for (nodes, groups) in shapes {
        let (pattern, values) = assemble(nodes, &groups);
        let mut block = BlockLu::new();
        block.analyse(&pattern, MatrixSymmetry::General)?;
        let flops = block.flops() / nodes as f64;
        let suits = block.suits();
        println!(
            "{} edges, {flops:.0} operations per node, suits: {suits}",
            groups.len()
        );
        let mut sums = Vec::new();
        let mut run = |name, solver: &mut dyn LinearSolver, symmetry| {
            let [factorise, solve] = measure(solver, &pattern, &values, symmetry)?;
            let sum = factorise + solve;
            sums.push(sum);
            println!("{nodes:>7} {name:>24} {factorise:>10.0} {solve:>10.0} {sum:>10.0}");
            Ok::<(), LinearError>(())
        };
        run("BlockLu", &mut BlockLu::new(), MatrixSymmetry::General)?;
        run(
            "BlockLu symmetric",
            &mut BlockLu::new(),
            MatrixSymmetry::Symmetric,
        )?;
        run("FaerLu", &mut FaerLu::new(), MatrixSymmetry::General)?;
        run("FaerLdlt", &mut FaerLdlt::new(), MatrixSymmetry::Symmetric)?;
        println!("{nodes:>7} FaerLu / BlockLu = {:.1}", sums[2] / sums[0]);
    }
    Ok(())
}
