//! Patterns of block-sparse matrices.

#![allow(clippy::unwrap_used)]

use pullback_manifold::sparse::BlockPattern;

#[test]
fn a_chain_finds_its_blocks_and_multiplies() {
    let pattern = BlockPattern::new(&[2, 1, 3], [[0, 1], [1, 2]]);
    assert_eq!(pattern.dim(), 6);
    assert_eq!(pattern.blocks(), 3);
    assert_eq!(pattern.len(), 4 + 2 + 2 + 1 + 3 + 3 + 9);
    assert_eq!(pattern.find(0, 2), None);
    let mut values = vec![0.0; pattern.len()];
    // Entry (global row 1, global column 2) = 5.
    let start = pattern.find(0, 1).unwrap();
    values[start + 1] = 5.0;
    let mut y = vec![0.0; 6];
    pattern.multiply_add(2.0, &values, &[0.0, 0.0, 3.0, 0.0, 0.0, 0.0], &mut y);
    assert_eq!(y, [0.0, 30.0, 0.0, 0.0, 0.0, 0.0]);
}
