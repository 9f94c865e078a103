//! The block solver allocates when it is made only.

use crate::support::*;
use allocation_counter::measure;

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
    type Make = fn(&BlockPattern) -> Box<dyn LinearSolver>;
    let solvers: [Make; 2] = [
        |pattern| Box::new(BlockLu::new(pattern, MatrixSymmetry::General).unwrap()),
        |pattern| Box::new(AutoSolver::new(pattern, MatrixSymmetry::General).unwrap()),
    ];
    for make in solvers {
        let mut made = None;
        let counted = measure(|| made = Some(make(&pattern)));
        assert!(counted.count_total > 0, "the counter counts");
        let mut solver = made.unwrap();
        let counted = measure(|| {
            for _ in 0..3 {
                solver.factorise(&values).expect("factorise");
                solver.solve(Some(&values), &mut b).expect("solve");
            }
        });
        assert_eq!(counted.count_total, 0);
    }
}
