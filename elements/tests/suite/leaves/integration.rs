//! Interpolation and integration over a beam element: exact for polynomials of the degrees they should be.

use crate::support::*;

/// K and M of a straight beam of unit shear stiffness along e2 and unit mass per length at rest, with its
/// nodes at these positions on e1.
fn tangents(positions: &[f64]) -> [DMatrix<f64>; 2] {
    let along = positions.iter().map(|&x| Vector3::new(x, 0.0, 0.0));
    let section = Section::diagonal(1.0, [1.0, 1.0], 1.0, [1.0, 1.0]).unwrap();
    let section = section.with_mass(1.0, Matrix3::identity()).unwrap();
    let positions: Vec<_> = along.collect();
    let beam = Interpolation::Total
        .beam(&positions, &|_| Matrix3::identity(), &section)
        .unwrap();
    let zero = vec![0.0; beam.dim()];
    let (_, [K, _, M]) = forces(&*beam, &moving(&zero, &zero, &zero)).unwrap();
    [K, M]
}

/// Equidistant values of ξ at `nodes` nodes.
fn equidistant(nodes: usize) -> Vec<f64> {
    let last = (nodes - 1) as f64;
    (0..nodes).map(|i| -1.0 + 2.0 * i as f64 / last).collect()
}

/// Coordinates of an element whose degree of freedom `dof` is ξᵏ at all nodes.
fn power(nodes: usize, dof: usize, k: i32) -> DVector<f64> {
    let mut x = DVector::zeros(6 * nodes);
    for (i, xi) in equidistant(nodes).into_iter().enumerate() {
        x[6 * i + dof] = xi.powi(k);
    }
    x
}

/// ∫ ξᵏ dξ over the element.
fn exact(k: i32) -> f64 {
    if k % 2 == 0 {
        2.0 / (f64::from(k) + 1.0)
    } else {
        0.0
    }
}

const Y: usize = 1;
const RZ: usize = 5;

/// Shear strains of a displacement u are u′, those of a rotation ψ are −ψ: with n points for n + 1 nodes, all
/// degrees up to 2n − 1 = (n − 1) + n.
#[test]
fn stiffnesses_are_exact_to_degree_2n_minus_1() {
    for n in 1..=3 {
        let [K, _] = tangents(&equidistant(n + 1));
        for j in 1..=n as i32 {
            for k in 0..=n as i32 {
                let (u, psi) = (power(n + 1, Y, j), power(n + 1, RZ, k));
                let (found, degree) = (u.dot(&(&K * psi)), j - 1 + k);
                let exact = -f64::from(j) * exact(degree);
                let gap = (found - exact).abs();
                assert!(gap < 1e-14, "{n} points, degree {degree}: {gap:e}");
            }
        }
    }
}

/// With n points for n nodes: products of two velocities, times a length that varies along the element if it
/// has more than two nodes.
#[test]
fn masses_are_exact_to_degree_2n_minus_1() {
    for n in 2..=4 {
        let stretch = if n > 2 { 0.2 } else { 0.0 };
        // x = ξ + stretch ξ², dx = (1 + 2 stretch ξ) dξ.
        let nodes = equidistant(n).into_iter().map(|xi| xi + stretch * xi * xi);
        let [_, M] = tangents(&nodes.collect::<Vec<_>>());
        for j in 0..n as i32 {
            for k in 0..n as i32 {
                let found = power(n, Y, j).dot(&(&M * power(n, Y, k)));
                let exact = exact(j + k) + 2.0 * stretch * exact(j + k + 1);
                let (gap, degree) = ((found - exact).abs(), j + k);
                assert!(gap < 1e-14, "{n} points, degree {degree}: {gap:e}");
            }
        }
    }
}
