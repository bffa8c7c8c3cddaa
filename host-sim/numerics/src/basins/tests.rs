use std::f64::consts::TAU;

use shared::model::cart::{ASSUMED_SHAKER, CartDrive};
use shared::model::params::{BEAM_170, RigParams, WIRES};
use shared::model::rig::Rig;

use super::*;
use crate::engine::Start;
use crate::lanes::{Cell, CellPlan, each_by_engine};
use crate::reference::{Reference, Segment, TrajectoryObserver};

fn rig(name: &str, params: RigParams, gap_over_amplitude: f64) -> NamedRig {
    NamedRig::new(
        name.to_owned(),
        RigParams {
            gap_m: gap_over_amplitude * params.amplitude_m,
            ..params
        },
    )
}

/// Linear motion relative to the cart from `start`, without contact: m x″ + c x′ + k x = m A0 Ω² sin Ωt.
struct Linear {
    decay: f64,
    swing: f64,
    omega: f64,
    forced: [f64; 2],
    free: [f64; 2],
}

impl Linear {
    fn new(natural_hz: f64, damping: f64, amplitude_m: f64, hz: f64, start: [f64; 2]) -> Self {
        let (natural, omega) = (TAU * natural_hz, TAU * hz);
        // Sine and cosine part of the steady answer.
        let (stiff, damp) = (
            natural.powi(2) - omega.powi(2),
            2.0 * damping * natural * omega,
        );
        let size = amplitude_m * omega.powi(2) / (stiff.powi(2) + damp.powi(2));
        let forced = [size * stiff, -size * damp];
        let (decay, swing) = (damping * natural, natural * (1.0 - damping.powi(2)).sqrt());
        let x = start[0] - forced[1];
        let v = start[1] - forced[0] * omega;
        let free = [(v + decay * x) / swing, x];
        Self {
            decay,
            swing,
            omega,
            forced,
            free,
        }
    }

    fn at(&self, t: f64) -> f64 {
        let (a, b) = (self.omega * t, self.swing * t);
        let free = self.free[0] * b.sin() + self.free[1] * b.cos();
        self.forced[0] * a.sin() + self.forced[1] * a.cos() + (-self.decay * t).exp() * free
    }

    /// The farthest it swings towards the surface in `cycles`.
    fn farthest(&self, cycles: u32) -> f64 {
        const PER_CYCLE: u32 = 400;
        let dt = TAU / self.omega / f64::from(PER_CYCLE);
        let all = (0..=cycles * PER_CYCLE).map(|i| self.at(f64::from(i) * dt));
        all.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Which starts never touch is known in closed form: those whose linear motion stays short of the gap. (The
/// pendulum's and the spring's nonlinearity move the edge by far less than the margin left here.)
#[test]
fn the_starts_that_never_touch_are_those_of_the_closed_form() {
    const CYCLES: u32 = 40;
    for (name, params, natural_hz, damping) in [
        ("beam-170", BEAM_170, 4.5, 0.004),
        ("wires", WIRES, (9.81_f64 / 0.075).sqrt() / TAU, 0.0),
    ] {
        let rig = rig(name, params, 2.0);
        let hz = 2.1 * natural_hz;
        // About the steady answer's own state: what starts there hardly swings besides.
        let steady = Linear::new(natural_hz, damping, params.amplitude_m, hz, [0.0; 2]);
        let rate = steady.forced[0] * steady.omega;
        let speed = 1.2e-3 * TAU * natural_hz;
        let query = BasinsRequest {
            window: StartWindow {
                displacement_m: [-1.2e-3, 1.2e-3],
                velocity_m_per_s: [rate - speed, rate + speed],
                columns: 12,
                rows: 12,
            },
            cycles: CYCLES,
            recorded: 1,
            samples: 0,
            until: CYCLES,
            ..BasinsRequest::usual(rig.clone(), hz, 1, 1)
        };
        let found = explore(Engine::Event, &query, &()).unwrap();
        let (mut free, mut near) = (0, 0);
        for fate in &found.grid {
            let linear = Linear::new(natural_hz, damping, params.amplitude_m, hz, fate.start);
            let farthest = linear.farthest(CYCLES);
            // 0.2 % of the gap: 400 samples a cycle miss 3e-5 of a crest, the frequency's shift with amplitude
            // (below 1e-4) turns the free part by 0.02 rad in 40 cycles.
            if (farthest / rig.params.gap_m - 1.0).abs() < 2e-3 {
                near += 1;
                continue;
            }
            let never = farthest < rig.params.gap_m;
            assert_eq!(
                fate.last_contact.is_none(),
                never,
                "{name} {fate:?} {farthest}"
            );
            free += usize::from(never);
        }
        assert!(
            (10..120).contains(&free) && near < 5,
            "{name}: {free} {near}"
        );
    }
}

/// Where the hammer is at `turns` within the next period.
struct At {
    turns: f64,
    hz: f64,
    found: Option<(f64, f64)>,
}

impl TrajectoryObserver for At {
    fn segment(&mut self, segment: &Segment) {
        let t = self.turns / self.hz;
        if (segment.start.t..=segment.end.t).contains(&t) {
            self.found = Some(segment.at(t));
        }
    }
}

/// From the state an orbit has at phase φ, the same orbit goes on: also from within a contact.
#[test]
fn a_start_at_a_phase_is_the_later_part_of_an_orbit_from_phase_0() {
    let params = rig("wires", WIRES, 0.0).params;
    let hz = 1.5 * params.natural_frequency_hz();
    let scale = params.amplitude_m / 0.075;
    for turns in [0.1, 0.25, 0.5, 0.75, 0.99] {
        let mut whole = Reference::<f64>::new(&params, hz, -2e-2, 0.3).unwrap();
        let mut at = At {
            turns,
            hz,
            found: None,
        };
        whole.run_period(&mut at);
        let (q, v) = at.found.unwrap();
        let mut part = Reference::<f64>::new(&params, hz, q, v)
            .unwrap()
            .from_phase(turns);
        part.run_period(&mut ());
        for cycle in 0..4 {
            let ((a, b), (c, d)) = (whole.state(), part.state());
            // The observer's quintic is good to some 1e-9 of A0; contacts stretch it a little.
            assert!((a - c).abs() < 1e-7 * scale, "{turns} {cycle}: {a} {c}");
            assert!(
                (b - d).abs() < 1e-7 * scale * TAU * hz,
                "{turns} {cycle}: {b} {d}"
            );
            assert_eq!(
                whole.run_period(&mut ()).onsets,
                part.run_period(&mut ()).onsets
            );
        }
    }
}

/// The flow carries the basins of phase 0 onto those of phase φ: a start, and where it has got to by then, have one fate.
#[test]
fn a_start_and_where_it_is_later_share_their_fate() {
    let rig = rig("wires", WIRES, 2.0);
    let (hz, phase) = (2.0 * rig.params.natural_frequency_hz(), 0.3);
    let model = Rig::<f64>::new(&rig.params).unwrap();
    let first = BasinDrive {
        params: rig.params,
        frequency_hz: hz,
        phase: 0.0,
    };
    let starts = StartWindow::usual(&rig.params, 5, 5).starts();
    let later: Vec<[f64; 2]> = starts
        .iter()
        .map(|[x, v]| {
            let q = model.coordinate_at(*x);
            let rate = model.coordinate_rate_at(q, *v);
            let mut at = At {
                turns: phase,
                hz,
                found: None,
            };
            let mut hammer = Reference::<f64>::new(&rig.params, hz, q, rate).unwrap();
            hammer.run_period(&mut at);
            let (q, rate) = at.found.unwrap();
            let there = model.kinematics(q, rate);
            [model.relative_displacement(q), there.rate]
        })
        .collect();
    let run = |drive: &BasinDrive, starts: &[[f64; 2]]| {
        start::fates(Engine::Event, drive, starts, 121, 60, &()).unwrap()
    };
    let a = run(&first, &starts);
    let b = run(&BasinDrive { phase, ..first }, &later);
    let same = a.iter().zip(&b).filter(|(a, b)| a.impacts() == b.impacts());
    // One start of 25 may lie so near the boundary that the quintic's 1e-9 decides it.
    assert!(same.count() >= 24);
    assert!(a.iter().any(Fate::impacts) && !a.iter().all(Fate::impacts));
}

/// In a cart that recoils and is on its course at the start, by the lanes and by the reference; over few cycles, so that
/// chaos does not part them.
#[test]
fn starts_in_a_cart_that_recoils_go_as_the_reference_has_them() {
    const CYCLES: u32 = 6;
    for (params, phase) in [(WIRES, 0.0), (WIRES, 0.3), (BEAM_170, 0.7)] {
        let mut rig = rig("recoiling", params, 1.5);
        let hz = 1.8 * rig.params.natural_frequency_hz();
        let starts = StartWindow::usual(&rig.params, 5, 5).starts();
        let fates = |params: RigParams| {
            let drive = BasinDrive {
                params,
                frequency_hz: hz,
                phase,
            };
            start::fates(Engine::Event, &drive, &starts, CYCLES, CYCLES, &()).unwrap()
        };
        let prescribed = fates(rig.params);
        rig.params.cart = CartDrive::Loop(ASSUMED_SHAKER);
        let found = fates(rig.params);
        let model = Rig::<f64>::new(&rig.params).unwrap();
        let cell = |[x, v]: &[f64; 2]| Cell {
            params: rig.params,
            frequency_hz: hz,
            start: Start::Moving(*x, *v).section(&model, TAU * hz).unwrap(),
            phase,
        };
        let cells: Vec<_> = starts.iter().map(cell).collect();
        let plan = CellPlan {
            cycles: CYCLES,
            recorded: CYCLES,
            early: false,
            strobes: 0,
        };
        let reference = each_by_engine(Engine::Event, &cells, &plan).into_iter();
        let reference: Vec<_> = reference.map(Result::unwrap).collect();
        let mut moved = 0;
        for ((a, b), rigid) in found.iter().zip(&reference).zip(&prescribed) {
            assert_eq!(a.last_contact, b.last_contact, "{a:?} {b:?}");
            assert!((a.force_n / b.force_n - 1.0).abs() < 1e-3, "{a:?} {b:?}");
            moved += usize::from((a.force_n / rigid.force_n - 1.0).abs() > 0.02);
        }
        assert!(moved > 5, "{moved}");
    }
}

#[test]
fn shares_agree_between_grid_sample_and_looks() {
    let rig = rig("wires", WIRES, 2.0);
    let query = BasinsRequest {
        cycles: 60,
        recorded: 30,
        samples: 100,
        until: 130,
        ..BasinsRequest::usual(rig.clone(), 2.0 * rig.params.natural_frequency_hz(), 10, 10)
    };
    let found = explore(Engine::Event, &query, &()).unwrap();
    assert_eq!((found.grid.len(), found.random.len()), (100, 100));
    let counts: usize = found.attractors.iter().map(|a| a.count).sum();
    assert_eq!(counts, 200);
    let sampled = found.random_share(|f, _| f.impacts());
    let (on_grid, mesh) = found.grid_share(|f, _| f.impacts());
    let slack = mesh.unwrap() + 0.05;
    assert!(on_grid > sampled.low - slack && on_grid < sampled.high + slack);
    let at: Vec<u32> = found.over_cycles.iter().map(|after| after.cycles).collect();
    assert_eq!(at, [50, 100, 130]);
    // Looked at when the grid is, the long run says what the short one says.
    let query = BasinsRequest { until: 60, ..query };
    let again = explore(Engine::Event, &query, &()).unwrap();
    let last = again.over_cycles.last().unwrap();
    assert_eq!((last.cycles, last.impact), (60, sampled));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let alone = pool.install(|| explore(Engine::Event, &query, &()).unwrap());
    assert_eq!((alone.grid, alone.which), (found.grid, found.which));
}

#[test]
fn what_cannot_be_is_refused_before_anything_runs() {
    let usual = BasinsRequest::usual(rig("wires", WIRES, 2.0), 3.6, 4, 4);
    let refused = |query: BasinsRequest| match explore(Engine::Event, &query, &()) {
        Err(error) => error,
        Ok(_) => panic!("what cannot be has been explored"),
    };
    let mut turned = usual.clone();
    turned.window.displacement_m.reverse();
    let [to, from] = usual.window.displacement_m;
    let side = "displacement";
    let window = BasinsError::Window { side, from, to };
    assert_eq!(refused(turned), window.into());
    let mut empty = usual.clone();
    empty.window.rows = 0;
    let no_cells = |error| {
        matches!(
            error,
            Error::Basins(BasinsError::Cells {
                columns: 4,
                rows: 0,
                ..
            })
        )
    };
    assert!(no_cells(refused(empty)));
    for (recorded, until) in [(0, 1000), (301, 1000)] {
        let query = BasinsRequest {
            recorded,
            until,
            ..usual.clone()
        };
        let cycles = 300;
        assert_eq!(refused(query), Error::Recorded { recorded, cycles });
    }
    let query = BasinsRequest {
        until: 299,
        ..usual.clone()
    };
    let (until, cycles) = (299, 300);
    assert_eq!(refused(query), BasinsError::Until { until, cycles }.into());
    let query = BasinsRequest {
        phase: 1.0,
        ..usual
    };
    assert_eq!(refused(query), StartError::Phase(1.0).into());
}
