//! Dense kernels on small column-major blocks.
//!
//! [`by_size!`] calls a kernel with constant extents for common sizes (1: joint coordinates, 3: planar
//! or spherical, 6: nodes), where the compiler unrolls. Kernels that keep a column in registers have
//! a version of their own for these sizes.
//!
//! A panel's blocks below the diagonal are kept as `L` (m × n) and those to its right transposed,
//! `Uᵀ` (m × n too), so that all kernels run down contiguous columns of length m.

// Fixed extents index several arrays at once; iterators would hide the mathematics.
#![allow(clippy::needless_range_loop)]

mod lu;
mod products;
mod scale;
mod triangular;

pub(super) use lu::lu;
pub(super) use products::{subtract, subtract_transposed, update};
pub(super) use scale::scale;
pub(super) use triangular::{left_lower, right_upper, right_upper_pair, solve_lower, solve_upper};

/// Calls `$fixed::<m, n>` for common sizes, `$any(m, n, ...)` otherwise; or `$kernel(m, n, ...)`, with
/// literals for common sizes.
macro_rules! by_size {
    ($m:expr, $n:expr, $kernel:ident, ($($argument:expr),*)) => {
        match ($m, $n) {
            (6, 6) => $kernel(6, 6, $($argument),*),
            (3, 3) => $kernel(3, 3, $($argument),*),
            (1, 1) => $kernel(1, 1, $($argument),*),
            (6, 3) => $kernel(6, 3, $($argument),*),
            (3, 6) => $kernel(3, 6, $($argument),*),
            (6, 1) => $kernel(6, 1, $($argument),*),
            (1, 6) => $kernel(1, 6, $($argument),*),
            (2, 2) => $kernel(2, 2, $($argument),*),
            (m, n) => $kernel(m, n, $($argument),*),
        }
    };
    ($m:expr, $n:expr, $fixed:ident, $any:ident, ($($argument:expr),*)) => {
        match ($m, $n) {
            (6, 6) => $fixed::<6, 6>($($argument),*),
            (3, 3) => $fixed::<3, 3>($($argument),*),
            (1, 1) => $fixed::<1, 1>($($argument),*),
            (6, 3) => $fixed::<6, 3>($($argument),*),
            (3, 6) => $fixed::<3, 6>($($argument),*),
            (6, 1) => $fixed::<6, 1>($($argument),*),
            (1, 6) => $fixed::<1, 6>($($argument),*),
            (2, 2) => $fixed::<2, 2>($($argument),*),
            (m, n) => $any(m, n, $($argument),*),
        }
    };
}
use by_size;

/// Columns of a block with constant extents.
#[inline(always)]
fn columns<const M: usize, const N: usize>(x: &[f64]) -> Option<&[[f64; M]; N]> {
    x.as_chunks::<M>().0.first_chunk()
}

#[inline(always)]
fn columns_mut<const M: usize, const N: usize>(x: &mut [f64]) -> Option<&mut [[f64; M]; N]> {
    x.as_chunks_mut::<M>().0.first_chunk_mut()
}
