//! The pull-back of tangents in place.

use crate::support::*;
use pullback_manifold::pullback;

const N: usize = 10;

/// Bᵀ (K B + C Ḃ + M B̈) − K_σ and so on, with B, Ḃ and B̈ of all coordinates as whole matrices.
#[test]
fn the_pull_back_in_place_is_that_of_whole_matrices() {
    let mut random = Random::default();
    let mut matrix = || DMatrix::from_fn(N, N, |_, _| random.range(-1.0, 1.0));
    let (given, [B, B_dot, B_ddot, own]) = ([(); 3].map(|()| matrix()), [(); 4].map(|()| matrix()));
    let block = |B: &DMatrix<f64>| Matrix3::from(B.fixed_view::<3, 3>(4, 4));
    let whole = |B: &DMatrix<f64>, outside: DMatrix<f64>| {
        let mut all = outside;
        all.fixed_view_mut::<3, 3>(4, 4).copy_from(&block(B));
        all
    };
    let (one, none) = (DMatrix::identity(N, N), DMatrix::zeros(N, N));
    let [Z, Z_dot, Z_ddot] = [(&B, one), (&B_dot, none.clone()), (&B_ddot, none.clone())]
        .map(|(B, outside)| whole(B, outside));
    let K_sigma = whole(&own, none);
    let [K, C, M] = &given;
    let exact = [
        Z.transpose() * (K * &Z + C * &Z_dot + M * &Z_ddot) - &K_sigma,
        Z.transpose() * (C * &Z + M * &Z_dot * 2.0),
        Z.transpose() * M * &Z,
    ];
    let operators = [&B, &B_dot, &B_ddot].map(block);
    let mut found = given.clone();
    let mut slices = found.each_mut().map(|part| part.as_mut_slice());
    pullback::tangents(&mut slices, N, 4, &operators, &block(&own));
    for (found, exact) in found.iter().zip(&exact) {
        assert!((found - exact).amax() < 1e-14);
    }
    let mut K = K.clone();
    pullback::tangents(&mut [K.as_mut_slice()], N, 4, &operators, &block(&own));
    let at_rest = Z.transpose() * &given[0] * &Z - K_sigma;
    assert!((K - at_rest).amax() < 1e-14);
}
