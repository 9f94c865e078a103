//! The block solver allocates in `analyse` only.

use std::alloc::System;

use pullback_integrators::linear_solver::{AutoSolver, BlockLu, LinearSolver, Symmetry};
use pullback_manifold::sparse::BlockPattern;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static GLOBAL: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

#[test]
fn factorise_and_solve_do_not_allocate() {
    let groups: Vec<[u32; 2]> = (1..100).map(|i| [i / 2, i]).collect();
    let pattern = BlockPattern::new(&[6; 100], &groups);
    let mut values = vec![0.01; pattern.len()];
    for j in 0..100 {
        if let Some(start) = pattern.find(j, j) {
            for k in 0..6 {
                // Some zero diagonals inside the blocks: interchanges and equilibration.
                values[start + 7 * k] = if k == 2 { 0.0 } else { 3.0 };
            }
            values[start + 2 + 6 * 3] = 5.0;
            values[start + 3 + 6 * 2] = 5.0;
        }
    }
    let mut b = vec![1.0; pattern.dim()];
    let solvers: [fn() -> Box<dyn LinearSolver>; 2] =
        [|| Box::new(BlockLu::new()), || Box::new(AutoSolver::new())];
    for make in solvers {
        // What solvers allocate they allocate every time; the test's own thread does so now and then.
        let mut allocations = (0..4).map(|_| {
            let mut solver = make();
            solver
                .analyse(&pattern, Symmetry::General)
                .expect("analyse");
            let region = Region::new(GLOBAL);
            for _ in 0..3 {
                solver.factorise(&values).expect("factorise");
                solver.solve(Some(&values), &mut b).expect("solve");
            }
            let change = region.change();
            change.allocations + change.reallocations
        });
        assert!(allocations.any(|n| n == 0));
    }
}
