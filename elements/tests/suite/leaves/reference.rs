//! The beam against an independent implementation, sections against published numbers.

use crate::support::*;

#[test]
fn beam_is_that_of_the_reference() {
    let rows = reference("beam");
    assert_eq!(rows.len(), 3);
    for row in &rows {
        let nodes = row["nodes"].as_array().expect("nodes").iter();
        let positions: Vec<_> = nodes.map(|p| Vector3::from_vec(numbers(p))).collect();
        let R0: Matrix3<f64> = matrix(&row["R0"]).fixed_view::<3, 3>(0, 0).into_owned();
        let length = row["length"].as_f64().expect("number");
        assert!(((positions[1] - positions[0]).norm() - length).abs() < 1e-14);
        let [N, M] = ["EA_GA2_GA3", "GJ_EI2_EI3"].map(|key| numbers(&row[key]));
        let section = Section::diagonal(N[0], [N[1], N[2]], M[0], [M[1], M[2]]).unwrap();
        let beam = Interpolation::Total
            .beam(&positions, &|_| R0, &section)
            .unwrap();
        let x = numbers(&row["q"]);
        let at = moving(&x, &[], &[]);
        let (r, [K, ..]) = forces(&*beam, &at).unwrap();
        let expected = vector(&row["f_int"]);
        assert!((&r + &expected).amax() < 1e-12 * expected.amax());
        let expected = matrix(&row["K_int"]);
        assert!((&K - &expected).amax() < 1e-12 * expected.amax());
        let energy = row["strain_energy"].as_f64().expect("number");
        assert!((beam.abilities().energy(&at) - energy).abs() < 1e-12 * energy);
        // Strains at the one integration point, in the section axes.
        let mut states = Vec::new();
        beam.abilities().section_states(&at, &mut states);
        assert_eq!(states.len(), 1);
        let (Gamma, K) = (vector(&row["Gamma"]), vector(&row["K_curvature"]));
        for k in 0..3 {
            assert!((states[0].Gamma[k] - Gamma[k]).abs() < 1e-12 * Gamma.amax());
            assert!((states[0].K[k] - K[k]).abs() < 1e-12 * K.amax());
            assert!((states[0].N[k] - N[k] * Gamma[k]).abs() < 1e-12 * N[k] * Gamma.amax());
            assert!((states[0].M[k] - M[k] * K[k]).abs() < 1e-12 * M[k] * K.amax());
        }
    }
}

const STEEL: Material = Material {
    E: 210e9,
    nu: 0.3,
    rho: 7850.0,
};

#[track_caller]
fn near(found: f64, expected: f64, relative: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(error <= relative, "{found:e} for {expected:e}: {error:e}");
}

#[test]
fn torsion_constants_of_rectangles() {
    // Timoshenko & Goodier, Theory of Elasticity, art. 109: k₁ of J = k₁ a b³, four figures or three.
    for (ratio, k1, figures) in [
        (1.0, 0.1406, 5e-5),
        (1.2, 0.166, 5e-4),
        (1.5, 0.196, 5e-4),
        (2.0, 0.229, 5e-4),
        (2.5, 0.249, 5e-4),
        (3.0, 0.263, 5e-4),
        (4.0, 0.281, 5e-4),
        (5.0, 0.291, 5e-4),
        (10.0, 0.312, 5e-4),
    ] {
        let found = rectangle_torsion(ratio, 1.0);
        assert!((found / ratio - k1).abs() <= figures, "{ratio}: {found}");
        // No side is the first; the scale is a length to the fourth power.
        assert_eq!(found, rectangle_torsion(1.0, ratio));
        let small = rectangle_torsion(0.02 * ratio, 0.02);
        near(small, found * 0.02_f64.powi(4), 1e-14);
    }
    // A thin strip: (a b³/3)(1 − 0.63025 b/a) (ibid.; 192/π⁵ Σ 1/n⁵ = 0.630249...).
    let strip = 1e-9 / 3.0 * (1.0 - 0.630_249e-3);
    near(rectangle_torsion(1.0, 1e-3), strip, 1e-8);
}

#[test]
fn torsion_constant_of_the_princeton_beam() {
    // published.json, S08: h = 12.3777 mm, b = 3.2024 mm. Its last digits are those of a truncated
    // series: the sum to 30 digits is 1.134071924826731e-10.
    let found = rectangle_torsion(0.0123777, 0.0032024);
    near(found, 1.134_071_924_843_914e-10, 2e-11);
    near(found, 1.134_071_924_826_731e-10, 1e-13);
}

#[test]
fn sections_of_known_shapes() {
    let (b, h) = (0.02, 0.05);
    let G = 210e9 / 2.6;
    let s = Section::rectangle(STEEL, b, h).unwrap();
    let area = b * h;
    // Cowper 1966, ν = 0.3: 10·1.3/(12 + 3.3) = 0.84967, tabulated as 0.850.
    near(s.C[(1, 1)] / (G * area), 13.0 / 15.3, 1e-14);
    near(s.C[(1, 1)] / (G * area), 0.850, 5e-4);
    near(s.C[(0, 0)], 210e9 * area, 1e-14);
    // Bending about E₂ bends the height (along E₃), about E₃ the width.
    near(s.C[(4, 4)], 210e9 * b * h.powi(3) / 12.0, 1e-14);
    near(s.C[(5, 5)], 210e9 * h * b.powi(3) / 12.0, 1e-14);
    near(s.C[(3, 3)], G * rectangle_torsion(b, h), 1e-14);
    let (mass, J) = (7850.0 * area, s.inertia.J);
    near(s.inertia.mass, mass, 1e-14);
    near(J[(0, 0)], mass * (b * b + h * h) / 12.0, 1e-14);
    near(J[(1, 1)], mass * h * h / 12.0, 1e-14);

    let r: f64 = 0.03;
    let s = Section::circle(STEEL, r).unwrap();
    near(s.C[(2, 2)] / (G * PI * r * r), 7.8 / 8.8, 1e-14);
    near(s.C[(2, 2)] / (G * PI * r * r), 0.886, 5e-4);
    near(s.C[(3, 3)], G * PI * r.powi(4) / 2.0, 1e-14);
    near(s.C[(4, 4)], 210e9 * PI * r.powi(4) / 4.0, 1e-14);

    // A tube is the difference of two circles; thin ones have Cowper's 2(1+ν)/(4+3ν) = 0.531.
    let inner = Section::circle(STEEL, 0.02).unwrap();
    let tube = Section::tube(STEEL, 0.02, r).unwrap();
    for k in [0, 3, 4, 5] {
        near(tube.C[(k, k)], s.C[(k, k)] - inner.C[(k, k)], 1e-13);
    }
    let [of_tube, outer, hole] = [&tube, &s, &inner].map(|s| [s.inertia.mass, s.inertia.J[(0, 0)]]);
    for k in 0..2 {
        near(of_tube[k], outer[k] - hole[k], 1e-13);
    }
    let thin = Section::tube(STEEL, 0.02999, r).unwrap();
    let area = PI * (r * r - 0.02999_f64.powi(2));
    near(thin.C[(1, 1)] / (G * area), 2.6 / 4.9, 1e-5);
    // And a tube with hardly a hole is a circle.
    let full = Section::tube(STEEL, 1e-9, r).unwrap();
    near(full.C[(1, 1)], s.C[(1, 1)], 1e-13);
}

#[test]
fn impossible_sections_are_refused_with_their_reason() {
    let message = |r: Result<Section, SectionError>| r.unwrap_err().to_string();
    let positive = |quantity: &str, value: &str| {
        format!("{quantity} must be positive and finite, got {value}")
    };
    let of = |material: Material| Section::circle(material, 1.0);
    refused! {
        Section::rectangle(STEEL, 0.0, 1.0) => positive("width", "0"),
        Section::rectangle(STEEL, 1.0, f64::NAN) => positive("height", "NaN"),
        Section::circle(STEEL, -1.0) => positive("radius", "-1"),
        of(Material { E: f64::INFINITY, ..STEEL }) => positive("Young's modulus E", "inf"),
    }
    assert!(message(of(Material { rho: -1.0, ..STEEL })).contains("density rho"));
    for (inner, outer) in [(0.5, 0.5), (0.0, 0.5), (-0.1, 0.5), (f64::NAN, 0.5)] {
        refused! {
            Section::tube(STEEL, inner, outer) =>
                format!("a tube needs 0 < inner radius < outer radius, got {inner} and {outer}"),
        }
    }
    for nu in [-1.0, 0.51, f64::NAN] {
        refused! {
            of(Material { nu, ..STEEL }) => format!("Poisson's ratio must lie in (-1, 0.5], got {nu}"),
        }
    }
    // Each stiffness has its name.
    let names = [
        "axial stiffness EA",
        "shear stiffness GA2",
        "shear stiffness GA3",
        "torsional stiffness GJ",
        "bending stiffness EI2",
        "bending stiffness EI3",
    ];
    for (k, name) in names.into_iter().enumerate() {
        let mut c = [1.0; 6];
        c[k] = 0.0;
        refused! {
            Section::diagonal(c[0], [c[1], c[2]], c[3], [c[4], c[5]]) => positive(name, "0"),
        }
    }
    let pair = |upper: f64, lower: f64| {
        let mut C = Matrix6::identity();
        (C[(1, 4)], C[(4, 1)]) = (upper, lower);
        Section::new(C)
    };
    refused! {
        pair(0.5, 0.0) =>
            "the section stiffness must be symmetric, but entries (2, 5) and (5, 2) are 0.5 and 0",
    }
    assert!(pair(0.5, 0.5).is_ok());
    for c in [1.0, 1.5] {
        assert!(message(pair(c, c)).contains("must be positive definite"));
    }
    // Rounding errors of a symmetric law are no asymmetry, and a law that is hardly definite is one: both
    // relative to the diagonal, whatever the units of its entries.
    let coupled = |upper: f64, lower: f64| {
        let mut C = Matrix6::from_diagonal(&[1.0, 1e8, 1.0, 1.0, 1e-4, 1.0].into());
        (C[(1, 4)], C[(4, 1)]) = (100.0 * upper, 100.0 * lower);
        Section::new(C)
    };
    assert!(coupled(0.5, 0.5 + 1e-13).is_ok());
    assert!(message(coupled(0.5, 0.5 + 1e-11)).contains("must be symmetric"));
    assert!(coupled(1.0 - 1e-12, 1.0 - 1e-12).is_ok());
    assert!(message(coupled(1.0 - 1e-15, 1.0 - 1e-15)).contains("must be positive definite"));
}
