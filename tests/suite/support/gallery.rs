//! What cases of the gallery must compare, and how closely.

use super::program::{cells, directory, read};
use pullback::studies::gallery::{self, CaseRow};
use std::collections::BTreeSet;
use std::path::Path;

/// What cases must compare: their names, how quantities or sources begin, the least number of rows of each
/// and the largest tolerance.
fn bounds(table: &'static str) -> impl Iterator<Item = (&'static str, &'static str, usize, f64)> {
    cells(table).flat_map(|[cases, starts, least, largest]| {
        let (least, largest) = (least.parse().unwrap(), largest.parse().unwrap());
        let of = move |case| {
            starts
                .split("; ")
                .map(move |start| (case, start, least, largest))
        };
        cases.split(", ").flat_map(of)
    })
}

/// Of statics: tolerances relative to the published value or to 1.
/// They are those to which the outside values are known or to which a published mesh
/// reaches them, 0.05 to 0.15 for orders of convergence and what is read from figures.
const RELATIVE: &str = "
bend45 | most iterations | 1 | 0.2
bend45-convergence | order, 2-node | 3 | 0.05
bend45-convergence | order, 3-node | 3 | 0.075
bend45-convergence | order, geodesic | 2 | 0.15
bend45-convergence | tip, 64 3-node | 3 | 1e-6
bend45-convergence | tip, 32 4-node; tip, 32 geodesic 4-node | 3 | 1e-8
helix | first maximum | 3 | 0.016
helix | load factor of the first maximum | 3 | 0.002
helix | load factor reached | 3 | 0.0
helix | height of the tip at full load | 1 | 0.2
helix | order of the mean distance | 1 | 0.05
helix | mean distance | 1 | 0.5
rollup | tip displacement after 1; tip displacement after 2 | 3 | 1e-9
rollup | rotation left over | 2 | 1e-9
rollup | strain energy after 1; strain energy after 2 | 1 | 1e-9
rollup | rotation of a single element | 1 | 1e-10
elastica | w/L; u/L; rotation | 11 | 1e-8
cantilever | exact curve | 3 | 1e-9
cantilever | published | 3 | 1e-3
twisted | published: kynema-fmb | 3 | 1e-9
twisted | published: ANSYS solid | 3 | 0.032
# 0.5 % of the largest displacements, 0.0107 and 0.146.
princeton | uy | 7 | 5.36e-5
princeton | uz | 7 | 7.32e-4
shear-flexible | large load | 4 | 1e-6
shear-flexible | exact curve | 5 | 1e-9
shear-flexible | small load | 2 | 1e-12
shear-flexible | order | 3 | 0.05
lee-frame | exact curve | 9 | 1e-5
lee-frame | published: Lee et al.; published: Simo & Vu-Quoc 1986, 10 quadratic | 1 | 2e-3
lee-frame | turning points | 1 | 0.0
deep-arch | exact curve: independent shooting, S12 | 3 | 2e-5
deep-arch | crown deflection at load 500 beyond; crown deflection at load 0 beyond | 1 | 1e-7
deep-arch | crown displacement along e1 at load | 2 | 2e-7
deep-arch | turning points | 1 | 0.0
deep-arch | published | 3 | 6e-4
column | exact | 3 | 1e-5
rotating-blade | published | 12 | 1e-6
bending-torsion | rotation matrix of the tip | 8 | 1e-9
bending-torsion | position of the tip over length at load 0.9 | 4 | 1e-7
bending-torsion | position of the tip over length at load 1, | 4 | 1e-9
follower | ux; uy; rotation | 8 | 1e-7
objectivity | tip after loading and unloading; tip for two orders of two loads | 1 | 1e-9
objectivity | strain energy of the unloaded | 2 | 1e-12
objectivity | relative change of strain energy when the loaded geodesic | 5 | 1e-10
objectivity | relative change of strain energy when the loaded bend | 1 | 1e-3
objectivity | order | 1 | 0.1
";

/// Of dynamics mostly: tolerances as they are. They are those to which published.json and cases.md trust
/// their values; 0.1 for orders but where a jerk hides them; of energies and gaps what the scheme and
/// round-off leave.
const ABSOLUTE: &str = "
# Each component, whatever its size.
bend45 | tip displacement, 8 elements | 3 | 1e-3
top | smallest nutation; largest nutation | 1 | 1e-5
top | nutation period; precession rate | 1 | 1e-4
top | axis at t | 9 | 1e-4
# A hundredth of the nutation; the digits of its range.
top | stiff beam off | 1 | 2.67e-4
top | plot:  | 2 | 5e-5
hooke | largest error after the moment; amplitude; angle of the input at t = 30 | 1 | 1e-3
elbow | height of 20 elements; time of 20 elements | 4 | 0.1
elbow | height of 4 quadratic | 5 | 0.1
# A step.
elbow | time of 4 quadratic | 5 | 0.25
arm-spherical, arm-revolute | meshes apart until t = 1, | 1 | 0.03
arm-spherical | meshes apart until t = 3, | 1 | 0.1
arm-revolute | meshes apart until t = 1.5, | 1 | 0.1
arm-spherical, arm-revolute | independent | 9 | 0.02
arm-spherical, arm-revolute | order in the mesh, from 8 to 40 | 1 | 0.2
arm-spherical, arm-revolute | order in the step, 4; order in the step, driven smoothly | 1 | 0.1
arm-spherical, arm-revolute | order in the mesh, driven smoothly | 1 | 0.1
heavy-top | fixed point, extrapolated position; fixed point, body axis | 9 | 1e-5
heavy-top | fixed point, body rate; spherical joint, body rate | 3 | 1e-5
heavy-top | fixed point, order; spherical joint, order | 1 | 0.1
heavy-top | spherical joint, extrapolated position; spherical joint, body axis | 9 | 1e-5
free-body | extrapolated body rate | 3 | 1e-5
free-body | extrapolated body axis | 9 | 1e-5
free-body | extrapolated period | 1 | 1e-4
free-body | order | 2 | 0.1
free-body | energy-momentum scheme | 2 | 1e-11
pendulum | extrapolated position | 6 | 1e-6
pendulum | order in the step | 1 | 0.05
pendulum | energy error | 1 | 1e-5
pendulum | turns after; speed after | 3 | 1e-6
universal-joint | exact: tan β; exact: cos γ | 2 | 1e-7
universal-joint | output (degrees) | 5 | 1e-5
universal-joint | ratio of speeds of shafts | 5 | 1e-7
elbow-converged | height of | 6 | 2e-3
# Those before t = 10.
elbow-converged | height of tip, first; height of elbow, second | 1 | 5e-4
elbow-converged | height of elbow, first | 2 | 5e-4
elbow-converged | time of | 6 | 0.02
elbow-converged | other code: Exudyn | 3 | 0.007
elbow-converged | other code: AeroBeams | 3 | 0.01
spin-up | largest lag, extrapolated; largest shortening, extrapolated; steady extension | 1 | 1e-5
spin-up | largest lag: time; largest shortening: time | 1 | 0.01
flying-beam | loaded end; free end | 8 | 1e-2
flying-beam | momentum | 1 | 1e-9
double-pendulum | order | 2 | 0.1
double-pendulum | energy error | 1 | 1e-4
double-pendulum | out of the plane | 1 | 1e-9
rubber-rod | order | 1 | 0.1
rubber-rod | energy error | 1 | 1e-4
rubber-rod | 8 and 16 quadratic elements | 1 | 1e-3
four-bar | coupler tip | 2 | 1e-5
four-bar | its velocity | 2 | 1e-4
four-bar, slider-crank, four-bar-misaligned | largest gap | 1 | 1e-14
four-bar, parallelograms | largest relative change of energy | 1 | 1e-4
four-bar-flexible | tip at t = 2 along | 2 | 1e-5
# Twice what steps and mesh make of them.
four-bar-flexible | tip at t | 8 | 1e-5
four-bar-flexible, slider-crank-flexible | middle off the line | 3 | 1e-4
four-bar-flexible, slider-crank-flexible, bricard | largest gap | 1 | 1e-13
four-bar-flexible, slider-crank, bricard | largest relative change of energy | 1 | 1e-3
slider-crank | slider at t = 2 | 1 | 1e-5
slider-crank-flexible | slider at t | 4 | 1e-5
slider-crank-flexible | middle off the line between the ends at t = 0.5 | 1 | 3e-5
slider-crank-flexible | largest relative energy defect | 1 | 1e-3
parallelograms | last coupler | 2 | 1e-5
slider-crank, parallelograms | its velocity | 1 | 1e-4
parallelograms | largest gap | 1 | 2e-14
# 1e-9 of each angle; of each rate, and what 1.4e-11 s make of it: see SQUEEZER below.
squeezer | angle | 7 | 1.6e-8
squeezer | rate | 7 | 8e-6
squeezer | acceleration | 7 | 0.0681
squeezer | following acceleration | 7 | 0.021
squeezer | largest gap | 1 | 1e-15
bricard | exact: threefold | 2 | 1e-12
bricard | exact: equation of its one freedom | 4 | 1e-4
four-bar-misaligned | aligned: angle | 1 | 1e-3
four-bar-misaligned | aligned: largest deflection | 1 | 1e-12
four-bar-hardly-misaligned | deflection at C over misalignment | 3 | 3e-10
four-bar-misaligned | order in the mesh | 1 | 0.05
four-bar-misaligned | C in equilibrium | 18 | 3e-8
four-bar-misaligned | largest deflection | 1 | 3e-7
four-bar-misaligned | angle of bar 3 | 1 | 1e-7
";

/// Andrews' mechanism: largest tolerances of each component, relative.
const SQUEEZER: [(&str, [f64; 7]); 3] = [
    ("angle", [1e-9; 7]),
    // And the accelerations in the 1.4e-11 s that 1e-9 of beta takes.
    (
        "rate",
        [1.4e-9, 1.6e-9, 4.1e-7, 4.1e-7, 4.1e-7, 4.1e-7, 4.3e-7],
    ),
    (
        "following acceleration",
        [5e-7, 4e-7, 3.2e-9, 3.2e-9, 2e-8, 3.2e-9, 5e-8],
    ),
];

/// Runs cases; see [`assert_bounded`].
pub fn assert_computed(cases: &[&str], name: &str) {
    let out = directory(name);
    let names: Vec<String> = cases.iter().map(|&c| c.to_owned()).collect();
    let rows = gallery::run(&names, Some(&out), &mut |_| {}).unwrap();
    assert_bounded(cases, &rows, &out);
}

/// Each comparison of the cases meets its tolerance, none is lost or loosened, and their figures in the
/// directory `out` are as they should be.
pub fn assert_bounded(cases: &[&str], rows: &[CaseRow], out: &Path) {
    let relative: fn(&CaseRow) -> f64 = |row| row.published.abs().max(1.0);
    let mut bounded = vec![false; rows.len()];
    for (table, scale) in [(RELATIVE, relative), (ABSOLUTE, |_| 1.0)] {
        for (case, start, least, largest) in bounds(table).filter(|b| cases.contains(&b.0)) {
            let mut count = 0;
            for (row, bounded) in rows.iter().zip(&mut bounded) {
                if row.case == case
                    && (row.quantity.starts_with(start) || row.source.starts_with(start))
                {
                    // The last digit of a product may be rounded.
                    let largest = largest * scale(row) * (1.0 + 1e-9);
                    assert!(row.tolerance <= largest, "{row:?}");
                    *bounded = true;
                    count += 1;
                }
            }
            assert!(count >= least, "{case} has {count} rows {start:?}");
        }
    }
    for (row, bounded) in rows.iter().zip(bounded) {
        assert!(row.passed(), "{row:?}");
        assert!(bounded, "nothing bounds the tolerance of {row:?}");
    }
    for (start, largest) in SQUEEZER {
        let found = rows.iter().filter(|r| r.case == "squeezer");
        let found = found.filter(|r| r.quantity.starts_with(start));
        for (row, largest) in found.zip(largest) {
            assert!(row.tolerance <= largest * row.published.abs(), "{row:?}");
        }
    }
    let named: BTreeSet<&str> = (bounds(RELATIVE).chain(bounds(ABSOLUTE)).map(|b| b.0)).collect();
    let known: BTreeSet<&str> = gallery::case_names().collect();
    assert_eq!(named, known);
    for case in super::drawings::cases().filter(|c| cases.contains(c)) {
        super::drawings::check(case, &read(out.join(format!("{case}.svg"))));
    }
}
