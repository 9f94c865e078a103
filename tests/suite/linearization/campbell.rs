//! Modes over the speed of a rotation, by model files.

use super::{assert_near, campbell};
use crate::support::*;
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// Circular frequency Im λ and damping ratio of each line, over the speed.
fn lines(name: &str, text: &str) -> Vec<(f64, Vec<[f64; 2]>)> {
    campbell(&ran(&directory(name), text))
}

/// Circular frequencies from the lowest.
fn sorted(lines: &[[f64; 2]]) -> Vec<f64> {
    let mut found: Vec<f64> = lines.iter().map(|line| line[0]).collect();
    found.sort_by(f64::total_cmp);
    found
}

/// λ of both whirls ζ = x + i y of a mass on a shaft of stiffness k with damping c in it, and d in its fixed bearings.
/// In the frame that rotates m (ζ̈ + 2iΩ ζ̇ − Ω² ζ) + c ζ̇ + d (ζ̇ + iΩ ζ) + k ζ = 0.
fn whirls(speed: f64, [m, k]: [f64; 2], [c, d]: [f64; 2]) -> [Complex64; 2] {
    let i_omega = Complex64::i() * speed;
    let half = (c + d) / (2.0 * m);
    let root = ((i_omega + half).powi(2) - (k + d * i_omega) / m - i_omega.powi(2)).sqrt();
    [root, -root].map(|root| root - i_omega - half)
}

/// Two lines are these whirls in one order or the other; damping ratios where λ is not about zero.
#[track_caller]
fn assert_whirls(speed: f64, found: &[[f64; 2]], mut exact: [Complex64; 2], within: [f64; 2]) {
    let [off, other] = exact.map(|exact| (found[0][0] - exact.im.abs()).abs());
    if other < off {
        exact.reverse();
    }
    for (found, exact) in found.iter().zip(exact) {
        assert_close(found[0], exact.im.abs(), within[0], speed);
        if exact.norm() > 1e-3 {
            assert_close(found[1], -exact.re / exact.norm(), within[1], speed);
        }
    }
}

/// A mass of 3 on a massless vertical shaft that rotates, with these stiffnesses EI and damping.
fn rotor(EI: [f64; 2], damping: f64) -> String {
    [
        &format!(
            "[sections.shaft]\nstiffness = {{ EA = 1e7, GA = [1e7, 1e7], GJ = 1e4, EI = {EI:?} }}\n\
             damping = {{ stiffness = {damping} }}\n"
        ),
        GROUND,
        &hinge("spin", "ground", ""),
        &joint("disc", "free", "spin", "position = [0, 0, 1]"),
        &beam_line("shaft", ["spin", "disc"], 2, "shaft"),
        "order = 3\nrelative_to = \"spin\"\n",
        &body_of("disc", 3.0, ""),
        "[analysis.campbell]\njoint = \"spin\"\nto = 16\nsteps = 8\ncount = 2\n",
    ]
    .concat()
}

/// Stiffness of its free end.
fn stiffness(EI: f64) -> f64 {
    1.0 / (1.0 / (3.0 * EI) + 1.0 / 1e7)
}

/// Internal damping τ k drives the whirl beyond the critical speed, 10. The massless shaft relaxes with λ = −1/τ, which is
/// no line.
#[test]
fn internal_damping_drives_the_whirl() {
    let (tau, k) = (5e-4, stiffness(100.0));
    for (speed, found) in lines("campbell_internal", &rotor([100.0; 2], tau)) {
        let exact = whirls(speed, [3.0, k], [tau * k, 0.0]);
        assert_whirls(speed, &found, exact, [1e-5, 1e-6]);
    }
}

/// Between √(k₁/m) = 10.0 and √(k₂/m) = 12.2 a shaft of two stiffnesses diverges, as a warning says.
#[test]
fn a_shaft_of_two_stiffnesses_diverges_between_its_critical_speeds() {
    let text = rotor([100.0, 150.0], 0.0);
    let [_, warnings] = told("campbell_diverges", &text);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert_says(&warnings[0], &["line 1 grows at speeds between 10 and 12:"]);
    let both = text.replace("to = 16\nsteps = 8", "from = -16\nto = 16\nsteps = 16");
    let [_, warnings] = told("campbell_both_ways", &both);
    let speeds = "grows at speeds between -12 and -10, and between 10 and 12:";
    assert_says(&warnings[0], &[speeds]);
    for (speed, found) in lines("campbell_two_stiffnesses", &text) {
        let squares = [100.0, 150.0].map(|EI| stiffness(EI) / 3.0 - speed * speed);
        let exact = if squares[0] * squares[1] < 0.0 {
            -1.0
        } else {
            0.0
        };
        let least = found.iter().map(|line| line[1]).fold(0.0, f64::min);
        assert!((least - exact).abs() < 1e-9, "{speed}: {found:?}");
    }
}

/// Flap of a clamped blade without hub, w'''' − η² (T w')' = μ² w, T = (1 − x²)/2: power series, 60 digits;
/// Wright, Smith, Thresher & Wang 1982.
const FLAP: [(f64, [f64; 2]); 3] = [
    (0.0, [3.516015268500151, 22.03449156466677]),
    (2.0, [4.13731957303, 22.6149219565]),
    (6.0, [7.360373019310019, 26.8090816785]),
];

/// The lag of a blade with twice the stiffness in its plane is crossed by its flap, which stays one line.
#[test]
fn lines_cross() {
    let stiffer = "EI = [1.0, 1.0] => EI = [1.0, 2.0]";
    let text = changed(&example("rotating_blade"), stiffer);
    let rows = lines("campbell_crossing", &text);
    assert!(rows[0].1[0] < rows[0].1[1], "flap first");
    assert!(rows[12].1[0] > rows[12].1[1], "flap above lag");
    for (speed, flap) in FLAP {
        let (_, found) = rows.iter().find(|row| row.0 == speed).unwrap();
        assert_near(found[0][0], flap[0], 1e-6);
    }
    // Each line is smooth: its second differences are small.
    for k in 0..5 {
        for three in rows.windows(3) {
            let [a, b, c] = [&three[0].1, &three[1].1, &three[2].1].map(|row| row[k][0]);
            assert!((a - 2.0 * b + c).abs() < 0.3, "line {k} at {}", three[1].0);
        }
    }
}

/// The precession of a disc, J_t λ² ∓ J_p Ω λ − k = 0, crosses its sway, which no speed changes, at a speed of the diagram: shapes
/// of the repeated eigenvalue there are any ones, and both lines go on.
#[test]
fn lines_cross_at_a_speed_of_the_diagram() {
    let (m, J, k) = (2.0, 0.2, 40.0);
    let precession =
        |speed: f64| (J * speed + (J * speed * J * speed + 4.0 * J * k).sqrt()) / (2.0 * J);
    let sway = precession(5.0);
    let stiffness = [sway * sway * m, 50.0, 500.0, k, k, 300.0];
    let text = [
        GROUND,
        &joint("bearing", "free", "ground", "position = [0, 0, 0]"),
        &format!(
            "[[springs]]\nname = \"mount\"\nnodes = [\"ground\", \"bearing\"]\nbushing = {{ stiffness = {stiffness:?} }}\n"
        ),
        &hinge("spin", "bearing", ""),
        &body_of("spin", m, "inertia = [0.2, 0.2, 0.2]"),
        "[analysis.campbell]\njoint = \"spin\"\nto = 10\nsteps = 4\ncount = 6\n",
    ];
    let rows = lines("campbell_meeting", &text.concat());
    let near = |found: f64, exact: f64| (found - exact).abs() < 1e-9 * exact;
    for line in 0..6 {
        let all = || rows.iter().map(|row| (row.0, row.1[line][0]));
        if near(all().next_back().unwrap().1, precession(10.0)) {
            assert!(
                all().all(|(speed, found)| near(found, precession(speed))),
                "precession"
            );
        }
        if near(all().next_back().unwrap().1, sway) {
            assert!(all().all(|(_, found)| near(found, sway)), "sway");
        }
    }
    let end: Vec<f64> = sorted(&rows[4].1);
    assert!(
        [sway, precession(10.0)]
            .iter()
            .all(|exact| end.iter().any(|found| near(*found, *exact)))
    );
}

/// Among the converged Ritz values of a fine mesh at speed some are no approximations.
#[test]
fn many_modes_of_a_fine_mesh() {
    let fine = "elements = 8 => elements = 24\nsteps = 24 => steps = 2\ncount = 5 => count = 14";
    let rows = lines("campbell_fine", &changed(&example("rotating_blade"), fine));
    assert!(rows.iter().all(|row| row.1.len() == 14), "none is lost");
    let found = sorted(&rows[1].1);
    let (speed, flap) = FLAP[2];
    assert_eq!(rows[1].0, speed);
    assert_near(found[1], flap[0], 1e-5);
    assert_near(found[3], flap[1], 1e-5);
}

/// The equations of a stiff blade that turns slowly are the same after a turn but for rounding errors, and frequencies hardly
/// rise.
#[test]
fn rounding_errors_of_a_fine_mesh_are_no_periodic_coefficients() {
    let slow = "elements = 8 => elements = 60\nto = 12 => to = 0.05\nsteps = 24 => steps = 1";
    let rows = lines("campbell_slow", &changed(&example("rotating_blade"), slow));
    let [rest, slow] = [&rows[0].1, &rows[1].1].map(|row| sorted(row));
    for (rest, slow) in rest.iter().zip(slow) {
        assert_near(slow, *rest, 1e-3);
    }
}

/// A disc that spins at the end of a massless shaft which does not.
fn disc() -> String {
    [
        "[sections.shaft]\nstiffness = { EA = 1e5, GA = [1e5, 1e5], GJ = 1e4, EI = [1.0, 1.0] }\n\
         [nodes]\nwall = [0, 0, 0]\nend = [1, 0, 0]\n",
        &fixed("wall"),
        &(beam_line("shaft", ["wall", "end"], 2, "shaft") + "order = 3\n"),
        &joint("spindle", "revolute", "end", "axis = [1, 0, 0]"),
        &body_of("spindle", 1.0, "inertia = [0.2, 0.1, 0.1]"),
        "[analysis.campbell]\njoint = \"spindle\"\nto = 30\nsteps = 10\ncount = 4\n",
    ]
    .concat()
}

/// With the flexibilities of a cantilever and G = J_p Ω ω − J_t ω²,
/// (1 − δ₁₁ m ω²)(1 + δ₂₂ G) + δ₁₂² m ω² G = 0, for backward whirl with ω < 0 (Den Hartog 1956, section 6.8).
#[test]
fn whirl_of_an_overhung_disc() {
    let rows = lines("campbell_disc", &disc());
    let (m, J_p, J_t) = (1.0, 0.2, 0.1);
    let (d11, d12, d22) = (1.0 / 3.0 + 1e-5, 0.5, 1.0);
    for (speed, found) in &rows {
        let f = |omega: f64| {
            let G = J_p * speed * omega - J_t * omega * omega;
            let inertia = m * omega * omega;
            (1.0 - d11 * inertia) * (1.0 + d22 * G) + d12 * d12 * inertia * G
        };
        // The error of a root by Newton's method.
        let error = |omega: f64| {
            let h = 1e-4 * omega;
            f(omega) / ((f(omega + h) - f(omega - h)) / (2.0 * h)) / omega
        };
        let mut senses = 0;
        for [omega, _] in found {
            let [forward, backward] = [error(*omega).abs(), error(-omega).abs()];
            let found = forward.min(backward) < 1e-6;
            assert!(found, "{speed} {omega} {forward} {backward}");
            senses += usize::from(forward < backward);
        }
        assert!(*speed == 0.0 || senses == 2, "two forward, two backward");
    }
    // The four lines are all different at speed.
    let last = sorted(&rows[10].1);
    let differ = last.windows(2).all(|pair| pair[1] - pair[0] > 1e-3);
    assert!(differ, "{last:?}");
}

/// (ρA + ρI κ²) ω² ∓ 2 ρI κ² Ω ω = EI κ⁴ with κ = nπ/L for forward and backward whirl, seen from a shaft between
/// hinges that rotates about its line.
#[test]
fn whirl_of_a_spinning_shaft() {
    let hinges = "axis = [0, 1, 0]\nsecond_axis = [0, 0, 1]";
    let text = [
        "[sections.shaft]\nstiffness = { EA = 1e6, GA = [1e8, 1e8], GJ = 1e6, EI = [1.0, 1.0] }\n\
         mass = { A_rho = 1.0, J = [2e-3, 1e-3, 1e-3] }\n",
        GROUND,
        &joint("hub", "revolute", "ground", "axis = [1, 0, 0]"),
        &joint("root", "universal", "hub", hinges),
        &joint("tip", "free", "hub", "position = [1, 0, 0]"),
        &arm("wall", "ground", [1.0, 0.0, 0.0]),
        "[[springs]]\nname = \"bearing\"\nnodes = [\"wall\", \"tip\"]\n\
         bushing = { stiffness = [0, 1e9, 1e9, 0, 0, 0] }\n",
        &beam_line("shaft", ["root", "tip"], 12, "shaft"),
        "order = 3\nrelative_to = \"hub\"\n",
        "[analysis.campbell]\njoint = \"hub\"\nto = 5\nsteps = 5\ncount = 4\n",
    ];
    for (speed, found) in lines("campbell_shaft", &text.concat()) {
        for (n, found) in [1.0, 2.0].into_iter().zip(sorted(&found).chunks(2)) {
            let k = n * PI;
            let (m, g) = (1.0 + 1e-3 * k * k, 1e-3 * k * k * speed);
            let whirl = |s: f64| (s * g + (g * g + m * k.powi(4)).sqrt()) / m;
            assert_near(found[0], whirl(1.0) - speed, 1e-6);
            assert_near(found[1], whirl(-1.0) + speed, 1e-6);
        }
        let damped = found.iter().any(|line| line[1].abs() > 1e-10);
        assert!(!damped, "{speed}: {found:?}");
    }
}

/// Beyond Ω = √(k/m) both whirls turn back, and beyond (1 + d/c) times that the forward one grows.
#[test]
fn whirl_beyond_the_critical_speed() {
    // Without damping in the bearings the stiffness is singular at the critical speed, 10, and motions grow beyond it.
    for (d, growing) in [(1.0, 6), (0.0, 8)] {
        let bearings = match d {
            0.0 => "",
            _ => {
                "[[springs]]\nname = \"bearings\"\nnodes = [\"ground\", \"disc\"]\n\
                 bushing = { stiffness = [0, 0, 0, 0, 0, 0], damping = [1, 1, 0, 0, 0, 0] }\n"
            }
        };
        let text = [
            GROUND,
            &hinge("hub", "ground", ""),
            &joint("disc", "free", "hub", "position = [0, 0, 0]"),
            &body_of("disc", 2.0, "inertia = [0.1, 0.1, 0.15]"),
            "[[springs]]\nname = \"shaft\"\nnodes = [\"hub\", \"disc\"]\n\
             bushing = { stiffness = [200, 200, 300, 40, 40, 50], damping = [1.5, 1.5, 0, 0, 0, 0] }\n\
             [analysis.campbell]\njoint = \"hub\"\nto = 30\nsteps = 12\ncount = 6\n",
            bearings,
        ]
        .concat();
        let mut grows = 0;
        for (speed, found) in lines("campbell_whirl", &text) {
            // Both lines begin with one frequency, and keep to their whirl.
            let exact = whirls(speed, [2.0, 200.0], [1.5, d]);
            assert_whirls(speed, &found[..2], exact, [1e-9; 2]);
            grows += usize::from(found[..2].iter().any(|line| line[1] < 0.0));
        }
        assert_eq!(grows, growing);
    }
}

/// A blade on a hinge at a distance e from the axis: ω² = k/(m r²) + Ω² (1 + e/r), without damping in any equation, with
/// or without a spring.
#[test]
fn a_hinge_in_flap() {
    for k in [100.0, 0.0] {
        let spring = if k == 0.0 { "" } else { "spring = { k = 100 }" };
        let flap = format!("axis = [0, 1, 0]\n{spring}");
        let text = [
            GROUND,
            &hinge("hub", "ground", ""),
            &arm("arm", "hub", [0.5, 0.0, 0.0]),
            &joint("flap", "revolute", "arm", &flap),
            &body_of("flap", 2.0, "center = [1.5, 0, 0]"),
            "[analysis.campbell]\njoint = \"hub\"\nfrom = 2\nto = 10\nsteps = 4\ncount = 1\n",
        ]
        .concat();
        for (speed, found) in lines("campbell_hinge", &text) {
            let square = k / (2.0 * 2.25) + speed * speed * (1.0 + 0.5 / 1.5);
            assert_near(found[0][0], square.sqrt(), 1e-12);
        }
    }
}

/// Masses at a distance of 1.5 on 24 times three flap hinges with springs and dampers: m r² (s² + Ω²) + c s + k = 0. Of
/// the lowest eigenvalue there are 24 lines, of which none is cut.
#[test]
fn modes_of_many_equal_blades() {
    let blade = |i: u32| {
        let (y, x) = (f64::from(i) * TAU / 24.0).sin_cos();
        let hinge = |(name, k): (&str, f64)| {
            let c = 1e-3 * k;
            let keys = format!(
                "axis = [{:?}, {x:?}, 0]\nspring = {{ k = {k:?}, c = {c:?} }}",
                -y
            );
            let name = format!("{name} {i}");
            let centre = format!("center = [{:?}, {:?}, 0]", 1.5 * x, 1.5 * y);
            joint(&name, "revolute", "hub", &keys) + &body_of(&name, 2.0, &centre)
        };
        [("soft", 100.0), ("stiff", 300.0), ("stiffer", 700.0)]
            .map(hinge)
            .concat()
    };
    let text = [
        GROUND,
        &hinge("hub", "ground", ""),
        &(0..24).map(blade).collect::<String>(),
        "[analysis.campbell]\njoint = \"hub\"\nto = 4\nsteps = 1\ncount = 4\n",
    ]
    .concat();
    for (speed, found) in lines("campbell_many", &text) {
        assert_eq!(found.len(), 24);
        let square = 100.0 / 4.5 + speed * speed;
        for [omega, damping] in found {
            assert_near(damping, 0.1 / (2.0 * 4.5 * square.sqrt()), 1e-9);
            assert_near(omega, (square * (1.0 - damping * damping)).sqrt(), 1e-9);
        }
    }
}

/// A mass m at the end of a rod of length l, on a flap hinge with a spring at a distance e from the axis, under gravity. With
/// V(β) = m g l sin β + ½ k β² − ½ m Ω² (e + l cos β)², V' = 0 at the equilibrium, and m l² ω² = V''. Without a spring there is
/// no equilibrium near the reference configuration at rest; with a soft one it is far below.
#[test]
fn a_diagram_begins_at_its_first_speed() {
    let [m, e, l, g] = [3.0, 0.3, 1.5, 9.81];
    let text = |k: f64, speeds: [f64; 2]| {
        let spring = match k {
            0.0 => String::new(),
            k => format!("spring = {{ k = {k:?} }}"),
        };
        [
            GROUND,
            GRAVITY,
            &hinge("hub", "ground", ""),
            &arm("arm", "hub", [e, 0.0, 0.0]),
            &joint("flap", "revolute", "arm", &format!("axis = [0, -1, 0]\n{spring}")),
            &body_of("flap", m, &format!("center = [{l:?}, 0, 0]")),
            &format!(
                "[analysis.campbell]\njoint = \"hub\"\nfrom = {:?}\nto = {:?}\nsteps = 40\ncount = 1\n",
                speeds[0], speeds[1]
            ),
        ]
        .concat()
    };
    let omega = |k: f64, speed: f64| {
        let w = m * speed * speed;
        let mut beta = 0.0;
        let [mut first, mut second] = [f64::INFINITY; 2];
        while first.abs() > 1e-10 {
            let (sin, cos) = f64::sin_cos(beta);
            first = m * g * l * cos + k * beta + w * (e + l * cos) * l * sin;
            second = -m * g * l * sin + k + w * ((e + l * cos) * l * cos - l * l * sin * sin);
            beta -= first / second;
        }
        (second / (m * l * l)).sqrt()
    };
    for (k, speeds) in [
        (0.0, [15.0, 40.0]),
        (30.0, [40.0, 40.0]),
        (30.0, [0.0, 40.0]),
    ] {
        let all = lines("campbell_begins", &text(k, speeds));
        let (last, found) = all.last().unwrap();
        assert_near(found[0][0], omega(k, *last), 1e-9);
        let (first, found) = &all[0];
        if *first > 0.0 {
            assert_near(found[0][0], omega(k, *first), 1e-9);
        }
    }
    // The matrices at a speed are those of the diagram.
    let out = directory("campbell_at");
    write(&out, &text(30.0, [0.0, 40.0]));
    for at in [20.0, 40.0] {
        printed(&out, &format!("linearize model.toml --at {at}"));
        let [K, M] = ["K", "M"].map(|name| matrix(&out.join(format!("model.linear/{name}.mtx"))));
        assert_near((K[(0, 0)] / M[(0, 0)]).sqrt(), omega(30.0, at), 1e-9);
    }
}

/// A blade on a flapping hinge under gravity along the shaft hangs down at rest.
#[test]
fn a_blade_that_only_rotation_holds_needs_another_first_speed() {
    let text = |from: f64| {
        [
            GROUND,
            &hinge("hub", "ground", ""),
            &arm("end", "hub", [0.3, 0.0, 0.0]),
            &joint("flap", "revolute", "end", "axis = [0, 1, 0]"),
            &body_of("flap", 3.0, "center = [2, 0, 0]\ninertia = [0.1, 4, 4]"),
            "[[loads]]\ngravity = [0, 0, -9.81]\n",
            &format!("[analysis.campbell]\njoint = \"hub\"\nfrom = {from}\nto = 12\ncount = 1\n"),
        ]
        .concat()
    };
    let words = [
        "found at a speed of 0",
        "at the start, speed 0",
        "begin at a speed that holds it",
    ];
    assert_says(&failed("campbell_hanging", &text(0.0)), &words);
    assert_eq!(lines("campbell_held", &text(4.0))[0].0, 4.0);
}

#[test]
fn periodic_coefficients_are_refused() {
    let disc = disc().replace("[0.2, 0.1, 0.1]", "[0.2, 0.1, 0.12]");
    let gravity = "[[loads]]\ngravity = [0, -1, 0]\ntime = { constant = 1 }\n";
    let blade = format!("{}\n{gravity}", example("rotating_blade"));
    // Beside stiffnesses of 1e10 as well.
    let shaft = [
        "[sections.s]\nstiffness = { EA = 1e10, GA = [4e9, 4e9], GJ = 1e3, EI = [100, 400] }\n",
        "[nodes]\na = [0, 0, 0]\nb = [1, 0, 0]\n",
        &fixed("a"),
        &beam_line("l", ["a", "b"], 4, "s"),
        "order = 3\n",
        &joint("S", "revolute", "b", "axis = [1, 0, 0]"),
        &body_of("S", 5.0, "inertia = [0.7, 0.6, 0.2]"),
        "[analysis.campbell]\njoint = \"S\"\nfrom = 20\nto = 20\ncount = 4\n",
    ]
    .concat();
    for (name, text) in [
        ("campbell_unsymmetric", disc),
        ("campbell_gravity", blade),
        ("campbell_stiff", shaft),
    ] {
        assert_says(&failed(name, &text), &["needs Floquet theory"]);
    }
}

#[test]
fn joints_that_do_not_rotate_are_refused() {
    for (changes, words) in [
        ("joint = \"spindle\" => joint = \"axle\"", "spindle"),
        (
            "\"revolute\" => \"spherical\"\naxis = [1, 0, 0] =>",
            "does not release one angle",
        ),
        ("axis = [1, 0, 0] => &\\nspring = { k = 1 }", "spring"),
    ] {
        let model = write(&directory("campbell_refused"), &changed(&disc(), changes));
        assert_says(&ended(&program(&[&model]), 2), &[words]);
    }
}
