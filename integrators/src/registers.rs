//! The vector registers after a call of faer.

use std::hint::black_box;

/// Clears the upper halves of the vector registers of x86 processors, which products of matrices in faer leave in use
/// (private-gemm-x86 0.1, written in assembler, without `vzeroupper`). As long as they are, code compiled for SSE2, as all of
/// this library, takes up to twice the time.
pub(crate) fn clear_upper_halves() {
    // The compiler clears them at the end of a function that uses them.
    let x = black_box([1.0_f64; 8]);
    black_box(pulp::Arch::new().dispatch(|| x.map(|x| x + x)));
}
