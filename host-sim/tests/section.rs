//! Sections and bifurcation diagrams against what is known otherwise.

use host_sim::progress::ProgressLine;
use numerics::NamedRig;
use numerics::bifurcation::measured::MeasuredDiagram;
use numerics::bifurcation::{BifurcationDiagram, ChangeKind, DiagramRequest, diagrams, rows};
use numerics::branch::{Branch, BranchEnd};
use numerics::engine::{Engine, Start};
use numerics::lanes::CellPlan;
use numerics::orbit::shoot;
use numerics::poincare::{self, against, portrait};
use numerics::reference::Reference;
use numerics::sweep::{Direction, spread};
use shared::model::params::{RigParams, WIRES};
use shared::model::rig::Rig;

fn quiet() -> ProgressLine {
    ProgressLine::new("", 1, true)
}

fn request(gap_mm: f64, ratios: (f64, f64, usize), directions: &[Direction]) -> DiagramRequest {
    let natural = WIRES.natural_frequency_hz();
    DiagramRequest {
        rig: NamedRig::new("wires", WIRES),
        gaps_mm: vec![gap_mm],
        frequencies_hz: spread(ratios.0 * natural, ratios.1 * natural, ratios.2),
        directions: directions.to_vec(),
        engine: Engine::Event,
        plan: CellPlan {
            cycles: 200,
            recorded: 40,
            early: true,
            strobes: 40,
        },
        locate: true,
    }
}

fn one(request: &DiagramRequest) -> BifurcationDiagram {
    diagrams(request, &quiet()).unwrap().remove(0)
}

/// Following the orbit finds the doubling where a multiplier passes −1. A simulation that is stopped after 200 periods
/// shows it early: what is left of the transient alternates, which looks like the doubled motion. By up to 1 %.
#[test]
fn the_doubling_is_where_the_multiplier_says() {
    let diagram = one(&request(0.0, (2.4, 2.9, 26), &[Direction::Rest]));
    let found = diagram
        .changes
        .iter()
        .find(|c| c.kind == ChangeKind::Doubling);
    let found = found.expect("a doubling");
    assert!(
        found.lasting && found.below.is(1, 1) && found.above.is(2, 2),
        "{found:?}"
    );
    assert!(found.within_hz < 1e-4);

    let params = RigParams {
        gap_m: 0.0,
        ..WIRES
    };
    let hz = 2.4 * params.natural_frequency_hz();
    let mut hammer = Reference::<f64>::at_rest(&params, hz).unwrap();
    (0..300).for_each(|_| {
        hammer.run_period(&mut ());
    });
    let seed = shoot(&params, hz, hammer.state().into()).expect("a settled 1/1");
    let branch = Branch::follow(&params, seed, (hz, 1.3 * hz));
    assert_eq!(branch.high.end, BranchEnd::PeriodDoubling);
    let early = 1.0 - found.frequency_hz / branch.high.frequency_hz;
    println!(
        "doubling at {} Hz, seen {early:+.2e} of it earlier",
        branch.high.frequency_hz
    );
    assert!(early.abs() < 0.01, "{early}");
}

#[test]
fn what_is_carried_goes_on_where_it_was() {
    let both = [Direction::Up, Direction::Down];
    let found = diagrams(&request(2.4, (1.3, 1.8, 11), &both), &quiet()).unwrap();
    let rest = Rig::<f64>::new(&found[0].params).unwrap().rest();
    let [up, down] = [&found[0].stations, &found[1].stations];
    assert_eq!((up[0].start, down[10].start), ([rest, 0.0], [rest, 0.0]));
    for k in 1..11 {
        assert_eq!(up[k].start, up[k - 1].end);
        assert_eq!(down[k - 1].start, down[k].end);
        assert!(up[k].row.frequency_hz > up[k - 1].row.frequency_hz);
    }
}

/// A motion of n periods shows n points; one that does not repeat shows all recorded.
#[test]
fn a_station_has_as_many_points_as_branches() {
    let diagram = one(&request(1.0, (1.5, 3.3, 10), &[Direction::Rest]));
    for station in &diagram.stations {
        let branches = station.row.periods.map_or(40, usize::from);
        assert_eq!(station.points.len(), branches, "{}", station.row.regime);
        let contacts: u16 = station.points.iter().map(|p| p.contacts).sum();
        if station.row.periods.is_some() {
            assert_eq!(
                contacts,
                station.row.regime.impacts(),
                "{}",
                station.row.regime
            );
        }
    }
    let table = rows(std::slice::from_ref(&diagram));
    let all: usize = diagram.stations.iter().map(|s| s.points.len()).sum();
    assert_eq!(table.len(), all);
    assert!(diagram.stations.iter().any(|s| s.row.periods == Some(2)));
}

#[test]
fn points_measured_from_the_diagram_lie_on_it() {
    let diagram = one(&request(1.0, (1.4, 1.6, 5), &[Direction::Rest]));
    let points = || {
        diagram
            .stations
            .iter()
            .map(|s| (s.row.frequency_hz, s.points[0].displacement_mm))
    };
    let on = MeasuredDiagram {
        displacement_mm: points().chain([(99.0, 0.0)]).collect(),
        force_n: Vec::new(),
    };
    let distance = on.displacement_distance(&diagram);
    assert_eq!((distance.points_compared, distance.points_outside), (5, 1));
    assert!(distance.largest < 1e-12);
    let off = MeasuredDiagram {
        displacement_mm: points().map(|(hz, x)| (hz, x + 0.1)).collect(),
        force_n: Vec::new(),
    };
    assert!((off.displacement_distance(&diagram).rms - 0.1).abs() < 1e-9);
}

fn chaos(points: u32) -> poincare::SectionRequest {
    let params = RigParams {
        gap_m: 1e-3,
        ..WIRES
    };
    poincare::SectionRequest {
        params,
        frequency_hz: 2.7 * params.natural_frequency_hz(),
        start: Start::Rest,
        phases: vec![0.0, 0.3, 0.8],
        transient: 100,
        points,
    }
}

/// A point of the section at any phase, integrated on from that phase, comes to the next point at phase 0. The
/// points are read off a quintic, good to 1e-8 of A0; chaos stretches that by less than a thousand in a period.
#[test]
fn a_point_at_any_phase_leads_to_the_next_at_phase_0() {
    let request = chaos(30);
    let found = portrait(&request, &quiet()).unwrap();
    let rig = Rig::<f64>::new(&request.params).unwrap();
    for k in 1..3 {
        for (from, next) in found.sections[k].iter().zip(&found.sections[0][1..]) {
            let q = rig.coordinate_at(from.relative_displacement_mm * 1e-3);
            let v = rig.coordinate_rate_at(q, from.relative_velocity_m_per_s);
            let hammer =
                Reference::<f64>::new(&request.params, request.frequency_hz, q, v).unwrap();
            let mut hammer = hammer.from_phase(from.phase_turns);
            hammer.run_period(&mut ());
            let (q, _) = hammer.state();
            let off_mm = rig.relative_displacement(q) * 1e3 - next.relative_displacement_mm;
            assert!(
                off_mm.abs() < 1e-5 * 0.89,
                "{off_mm} at {}",
                from.phase_turns
            );
        }
    }
    assert_eq!(found.sections.iter().map(Vec::len).sum::<usize>(), 90);
}

/// The smoothing method on a chaotic section: the widest sticks to the surface, which the switch never does; the
/// narrower, the nearer, never nearer than two runs of the switch by much; and it takes more steps.
#[test]
fn smoothing_changes_the_section_and_costs_more_steps() {
    let found = against::against(&chaos(400), &[1e-6, 1e-7], &quiet()).unwrap();
    let [wide, narrow] = [&found.smoothed[0].summary, &found.smoothed[1].summary];
    assert_eq!(wide.section_periods, Some(1));
    assert_eq!(
        (narrow.section_periods, found.summary.section_periods),
        (None, None)
    );
    assert!(
        wide.carried > 1.0 && wide.boxes_not_shared > 0.99,
        "{wide:?}"
    );
    assert!(
        narrow.carried < 0.1 && narrow.boxes_not_shared < 0.5,
        "{narrow:?}"
    );
    assert!(found.again.carried < 0.1, "{:?}", found.again);
    for smoothed in [wide, narrow] {
        assert!(
            smoothed.steps_per_period > 2.0 * found.summary.steps_per_period,
            "{smoothed:?}"
        );
    }
}
