//! Snap-through: paths followed through their limit points.

use super::case::{Case, CaseError, Context, Record};
use crate::output::plot::Curve;
use pullback_elements::model::Dof;
use pullback_integrators::statics::{ArcLengthOptions, Event};

/// S11: Lee's frame.
pub const LEE_FRAME: Case = Case {
    name: "lee-frame",
    run: lee_frame,
};

/// S12: the deep circular arch.
pub const DEEP_ARCH: Case = Case {
    name: "deep-arch",
    run: deep_arch,
};

fn lee_frame(context: &mut Context) -> Result<(), CaseError> {
    const EXACT: &str = "exact curve: independent shooting, S11";
    const FORCE: f64 = 20000.0;
    let file = context.file(include_str!("../../examples/models/lee_frame.toml"))?;
    let mut frame = context.build(&file, "load")?;
    let points = [
        (20.0, 13448.637234, 5.250298),
        (40.0, 17795.965941, 17.543385),
        (60.0, 14829.873945, 52.19503),
    ];
    let mut events = vec![(Event::TurningPoint, false)];
    for (v, ..) in points {
        events.push((frame.passes(Dof::Y, -v)?, false));
    }
    events.push((Event::Load(1.0), true));
    let records = frame.trace(&ArcLengthOptions {
        first_step: 0.02,
        max_step: 0.04,
        events,
        ..ArcLengthOptions::default()
    })?;
    let first = |event: usize| records.iter().find(|r| r.event == Some(event));
    let turns: Vec<_> = records.iter().filter(|r| r.event == Some(0)).collect();
    let nan = f64::NAN;
    let (p, v, u) = turns.first().map_or((nan, nan, nan), |r| {
        (r.t * FORCE, -r.state.d.y, r.state.d.x)
    });
    context.compare("limit load", p, 18546.558, 0.2, EXACT);
    context.compare("deflection at the limit load", v, 48.751, 5e-3, EXACT);
    context.compare("displacement along e1 there", u, 26.8786, 5e-3, EXACT);
    let source = "published: Lee et al. 1968, 0.2 %";
    context.compare("limit load", p, 18552.0, 37.0, source);
    let source = "published: Simo & Vu-Quoc 1986, 10 quadratic elements, 0.2 %";
    context.compare("limit load", p, 18532.0, 37.0, source);
    for (k, (v, load, u)) in points.into_iter().enumerate() {
        let (p, x) = first(k + 1).map_or((nan, nan), |r| (r.t * FORCE, r.state.d.x));
        context.compare(format!("load at deflection {v}"), p, load, 0.2, EXACT);
        context.compare(
            format!("displacement along e1 at deflection {v}"),
            x,
            u,
            1e-4,
            EXACT,
        );
    }
    context.compare(
        "turning points of the load on the way to 20 000",
        turns.len() as f64,
        2.0,
        0.0,
        "published: Simo & Vu-Quoc 1986, figure",
    );
    let path = |pick: fn(&Record) -> f64| -> Vec<(f64, f64)> {
        std::iter::once((0.0, 0.0))
            .chain(records.iter().map(|r| (pick(r), r.t * FORCE)))
            .collect()
    };
    context.figure(
        "Lee's frame",
        ["displacement of the loaded point", "load"],
        vec![
            Curve::new("along e1", path(|r| r.state.d.x)),
            Curve::new("along −e2", path(|r| -r.state.d.y)),
            Curve::points(
                "exact curve",
                points
                    .iter()
                    .map(|&(v, p, _)| (v, p))
                    .chain(points.iter().map(|&(_, p, u)| (u, p)))
                    .collect(),
            ),
        ],
    )
}

fn deep_arch(context: &mut Context) -> Result<(), CaseError> {
    const EXACT: &str = "exact curve: independent shooting, S12";
    let file = context.file(include_str!("../../examples/models/deep_arch.toml"))?;
    let limit = |elements: usize, order: usize| -> Result<[f64; 3], CaseError> {
        let mut file = file.clone();
        for line in &mut file.lines {
            line.elements = elements;
            line.order = order;
        }
        let records = context.build(&file, "crown")?.trace(&ArcLengthOptions {
            first_step: 0.01,
            max_step: 0.03,
            events: vec![(Event::TurningPoint, true)],
            ..ArcLengthOptions::default()
        })?;
        let end = records.iter().find(|r| r.event == Some(0));
        Ok(end.map_or([f64::NAN; 3], |r| [1000.0 * r.t, -r.state.d.y, r.state.d.x]))
    };
    let fine = limit(30, 3)?;
    let linear = limit(20, 1)?;
    let curved = limit(10, 2)?;
    context.compare("limit load", fine[0], 897.2891, 1e-3, EXACT);
    context.compare("crown deflection there", fine[1], 113.7308, 1e-3, EXACT);
    context.compare(
        "crown displacement along e1",
        fine[2],
        -61.1417,
        1e-3,
        EXACT,
    );
    let source = "published: DaDeppo & Schmidt 1975";
    context.compare("limit load", fine[0], 897.0, 0.5, source);
    let source = "published: Simo & Vu-Quoc 1986, the same mesh";
    context.compare(
        "limit load, 40 2-node elements",
        linear[0],
        905.28,
        0.5,
        source,
    );
    let source = "published: Ibrahimbegovic 1995, the same mesh";
    context.compare(
        "limit load, 20 3-node elements",
        curved[0],
        897.3,
        0.5,
        source,
    );
    Ok(())
}
