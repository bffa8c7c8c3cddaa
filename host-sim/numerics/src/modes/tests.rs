use std::f64::consts::TAU;

use shared::model::params::{BEAM_135, BEAM_150, BEAM_170, WIRES};

mod contact;
mod flight;
mod hammer;

use flight::Flight;
use hammer::{Hammer, ModesWatch};

use super::linear::{Follower, LinearMotion};
use super::observe::{ModesSampler, watched};
use super::*;
use crate::engine::Plan as Cycles;
use crate::reference::Reference;
use crate::reference::flow::FlowTotals;

const BEAM: Beam = Beam {
    tip: TipJoint::Guided,
    mass_ratio: 0.1,
};

fn at_gap(params: RigParams, gap_m: f64) -> RigParams {
    RigParams { gap_m, ..params }
}

/// For the engine of the tests.
impl ModalRig {
    /// δ, m, and δ̇, m/s.
    pub fn penetration(&self, state: &ModalState) -> (f64, f64) {
        (state.tip() - self.gap_m, state.tip_rate())
    }

    /// F as the law's formula gives it, N: negative where it would pull.
    pub fn force(&self, state: &ModalState) -> f64 {
        let (delta, rate) = self.penetration(state);
        self.law.force(delta, rate, 0.0)
    }

    /// Accelerations of the modes under the inertial acceleration `drive` (A0 Ω² sin Ωt, m/s²) and the contact force
    /// `force` (N), m/s².
    pub fn accelerations(&self, state: &ModalState, drive: f64, force: f64) -> PerMode {
        let mut a = PerMode::default();
        for (i, mode) in self.modes.iter().enumerate() {
            let pushed = (mode.participation_kg * drive - force) / mode.mass_kg;
            let damped = 2.0 * self.damping_ratio * mode.omega * state.v[i];
            a[i] = pushed - damped - mode.omega * mode.omega * state.q[i];
        }
        a
    }

    /// What the inertial force gives all modes, W.
    pub fn inertial_power(&self, state: &ModalState, drive: f64) -> f64 {
        let each = self.modes.iter().zip(state.v);
        each.map(|(mode, v)| mode.participation_kg * drive * v)
            .sum()
    }
}

impl ModesWatch for ModesSampler {
    fn flight(&mut self, flight: &Flight, from: f64, to: f64) {
        // Fine enough for a 900 Hz mode at 4 Hz drive, and for the extremes of the displacement to some 1e-4 of them.
        let every = 1.0 / self.frequency_hz / 512.0;
        let first = (from / every).floor() + 1.0;
        let inside = (to / every - first).ceil().max(0.0) as usize;
        let within = (0..inside).map(|k| (first + k as f64) * every);
        for t in std::iter::once(from).chain(within).chain([to]) {
            self.see(&flight.at(t), 0.0);
        }
    }

    fn contact(&mut self, end: &ModalState, totals: &FlowTotals) {
        self.see(end, 0.0);
        self.worked(totals.contact_work);
    }
}

/// What the engine of the tests, with closed-form flights and integrated contacts, shows of a run from rest.
pub(super) fn observed(rig: ModalRig, frequency_hz: f64, cycles: Cycles) -> ModalObservation {
    let mut hammer = Hammer::at_rest(rig.clone(), frequency_hz);
    for _ in 0..cycles.transient {
        hammer.run_period(&mut ());
    }
    hammer.take_strongest();
    let mut sampler = ModesSampler::new(rig, frequency_hz, hammer.state());
    for _ in cycles.transient..cycles.cycles {
        let period = hammer.run_period(&mut sampler);
        sampler.close(hammer.state(), &period);
    }
    sampler.observation(hammer.take_strongest())
}

/// The chapter's rig whose one mode is the first of `rig`: its mass is the modal mass, its cart moves by what the mode
/// takes part in.
fn one_mode_rig(params: &RigParams, rig: &ModalRig) -> RigParams {
    let mode = &rig.modes[0];
    RigParams {
        mass_kg: mode.mass_kg,
        amplitude_m: params.amplitude_m * mode.participation_kg / mode.mass_kg,
        support: SupportParams::Beams {
            natural_frequency_hz: params.natural_frequency_hz(),
            damping_ratio: rig.damping_ratio,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        ..*params
    }
}

#[test]
fn one_mode_is_the_reference_of_the_beam_rig() {
    // 1/1 at 0.0, 1.0 and 3.0 mm, and several contacts per period at 0.9 of the natural frequency. Both engines keep
    // their steps' errors below 1e-12 of A0; stable motion does not let them grow beyond some thousands of that.
    let cases = [
        (BEAM_170, 0.0, 1.8),
        (BEAM_150, 1e-3, 1.3),
        (BEAM_135, 3e-3, 1.02),
        (BEAM_150, 0.0, 0.9),
    ];
    for (params, gap_m, ratio) in cases {
        let params = at_gap(params, gap_m);
        let rig = ModalRig::new(&params, BEAM, 1).unwrap();
        let hz = ratio * params.natural_frequency_hz();
        let mut one = Hammer::at_rest(rig.clone(), hz);
        let mut reference = Reference::<f64>::at_rest(&one_mode_rig(&params, &rig), hz).unwrap();
        for cycle in 0..60 {
            let (seen, known) = (one.run_period(&mut ()), reference.run_period(&mut ()));
            // The first period at no gap begins in contact: whether that is an onset is a matter of taste.
            if cycle > 0 {
                assert_eq!(seen.onsets, known.onsets, "{gap_m} {ratio} {cycle}");
                let force = (seen.peak_force - known.peak_force).abs();
                assert!(force <= 1e-6 * known.peak_force, "{force} {cycle}");
            }
            let (q, v) = reference.state();
            let q = q + params.gap_m;
            let (dq, dv) = (one.state().tip() - q, one.state().tip_rate() - v);
            let off = (dq / params.amplitude_m).hypot(dv / (params.amplitude_m * TAU * hz));
            assert!(off < 1e-7, "{gap_m} {ratio} {cycle}: {off}");
        }
    }
}

/// Energy balance of a run: what came in, what went, what is left.
struct Audit {
    rig: ModalRig,
    omega: f64,
    totals: FlowTotals,
}

impl ModesWatch for Audit {
    fn flight(&mut self, flight: &Flight, from: f64, to: f64) {
        // Gauss–Legendre with three points, on pieces of 0.15 rad of the fastest mode: the power, at twice its
        // frequency, errs by 0.3⁶/2e6 = 4e-10.
        let fastest = self.rig.modes.iter().map(|m| m.omega).fold(0.0, f64::max);
        let pieces = ((to - from) * fastest / 0.15).ceil().max(1.0);
        let h = (to - from) / pieces;
        let nodes = [
            (-0.6_f64.sqrt(), 5.0 / 9.0),
            (0.0, 8.0 / 9.0),
            (0.6_f64.sqrt(), 5.0 / 9.0),
        ];
        for k in 0..pieces as usize {
            for (x, weight) in nodes {
                let t = from + h * (k as f64 + 0.5 + 0.5 * x);
                let state = flight.at(t);
                let drive = self.rig.amplitude_m * self.omega.powi(2) * (self.omega * t).sin();
                let w = 0.5 * h * weight;
                self.totals.inertial_work += w * self.rig.inertial_power(&state, drive);
                self.totals.damping_work += w * self.rig.losses(&state).iter().sum::<f64>();
            }
        }
    }

    fn contact(&mut self, _: &ModalState, totals: &FlowTotals) {
        self.totals.add(totals, 1.0);
    }
}

#[test]
fn energy_is_accounted_for() {
    for (count, gap_m, ratio) in [(1, 0.0, 1.8), (2, 0.0, 1.8), (5, 1e-3, 1.3), (8, 0.0, 1.2)] {
        let params = at_gap(BEAM_170, gap_m);
        let rig = ModalRig::new(&params, BEAM, count).unwrap();
        let hz = ratio * params.natural_frequency_hz();
        let mut hammer = Hammer::at_rest(rig.clone(), hz);
        let mut audit = Audit {
            rig: rig.clone(),
            omega: TAU * hz,
            totals: FlowTotals::default(),
        };
        for _ in 0..40 {
            hammer.run_period(&mut audit);
        }
        let t = audit.totals;
        let left: f64 = rig.energies(hammer.state()).iter().sum();
        let balance = t.inertial_work - t.damping_work - t.contact_work - left;
        assert!(t.contact_work > 0.0 && t.damping_work > 0.0);
        assert!(
            balance.abs() < 1e-8 * t.inertial_work,
            "{count} modes: {balance} J of {t:?}, {left} J left"
        );
    }
}

#[test]
fn three_modes_move_as_a_plain_integration_says() {
    // Runge and Kutta's method at 1 µs, the contact told at every stage, no location; within 2 µm of the surface at
    // 20 ns. An onset is late by 10 ns on average: at 1200 N·s/m that is some 1e-5 of the impulse, and a few times
    // that after some contacts.
    let params = at_gap(BEAM_170, 0.5e-3);
    let rig = ModalRig::new(&params, BEAM, 3).unwrap();
    let hz = 8.0;
    let omega = TAU * hz;
    let mut hammer = Hammer::at_rest(rig.clone(), hz);
    let rates = |s: &ModalState| {
        let (delta, _) = rig.penetration(s);
        let force = if delta > 0.0 {
            rig.force(s).max(0.0)
        } else {
            0.0
        };
        let drive = rig.amplitude_m * omega * omega * (omega * s.t).sin();
        rig.accelerations(s, drive, force)
    };
    let moved = |s: &ModalState, v: &PerMode, a: &PerMode, h: f64| {
        let mut s = *s;
        s.t += h;
        for i in 0..MAX_MODES {
            s.q[i] += h * v[i];
            s.v[i] += h * a[i];
        }
        s
    };
    let mut s = ModalState::default();
    for _ in 0..4 {
        hammer.run_period(&mut ());
        s.t = 0.0;
        while s.t < 1.0 / hz {
            let near = rig.penetration(&s).0 > -2e-6;
            let h = (1.0 / hz - s.t).min(if near { 2e-8 } else { 1e-6 });
            let a1 = rates(&s);
            let s2 = moved(&s, &s.v, &a1, 0.5 * h);
            let a2 = rates(&s2);
            let s3 = moved(&s, &s2.v, &a2, 0.5 * h);
            let a3 = rates(&s3);
            let s4 = moved(&s, &s3.v, &a3, h);
            let a4 = rates(&s4);
            let mean = |x: [&PerMode; 4], i: usize| {
                (x[0][i] + 2.0 * x[1][i] + 2.0 * x[2][i] + x[3][i]) / 6.0
            };
            let mut next = s;
            next.t += h;
            for i in 0..MAX_MODES {
                next.q[i] += h * mean([&s.v, &s2.v, &s3.v, &s4.v], i);
                next.v[i] += h * mean([&a1, &a2, &a3, &a4], i);
            }
            s = next;
        }
        for i in 0..3 {
            let off = (hammer.state().q[i] - s.q[i]).abs() / params.amplitude_m;
            assert!(off < 2e-4, "mode {i}: {off}");
        }
    }
}

#[test]
fn a_flight_is_never_followed_through_the_surface() {
    // At every contact step and on a fine grid of the flights: δ > 0 with F > 0 is contact, nothing else.
    struct Deepest(ModalRig, f64);
    impl ModesWatch for Deepest {
        fn flight(&mut self, flight: &Flight, from: f64, to: f64) {
            let n = ((to - from) / 5e-6).ceil();
            for k in 1..n as usize {
                let state = flight.at(from + (to - from) * k as f64 / n);
                let (delta, _) = self.0.penetration(&state);
                if delta > 1e-12 && self.0.force(&state) > 1e-6 {
                    self.1 = self.1.max(delta);
                }
            }
        }
    }
    for ratio in [0.8, 1.3, 2.7, 3.3] {
        let params = at_gap(BEAM_150, 0.2e-3);
        let rig = ModalRig::new(
            &params,
            Beam {
                mass_ratio: 0.3,
                ..BEAM
            },
            5,
        )
        .unwrap();
        let mut hammer = Hammer::at_rest(rig.clone(), ratio * 5.25);
        let mut deepest = Deepest(rig, 0.0);
        let onsets: u32 = (0..40)
            .map(|_| u32::from(hammer.run_period(&mut deepest).onsets))
            .sum();
        assert!(onsets > 0);
        assert!(
            deepest.1 == 0.0,
            "{ratio}: {} m inside, in flight",
            deepest.1
        );
    }
}

#[test]
fn contact_feeds_the_higher_modes_and_flight_alone_hardly_does() {
    let cycles = Cycles {
        cycles: 200,
        transient: 150,
    };
    let share = |gap_m: f64, ratio: f64| {
        let params = at_gap(BEAM_170, gap_m);
        let rig = ModalRig::new(&params, BEAM, 3).unwrap();
        let motion = LinearMotion::of(&params, BEAM, 3, ratio * 4.5).unwrap();
        let follower = Follower::at_rest(motion, &rig);
        let seen = watched(follower, &rig, ratio * 4.5, cycles).unwrap();
        let all: f64 = seen.energy_j.iter().sum();
        (seen.force_n, 1.0 - seen.energy_j[0] / all)
    };
    let (force, struck) = share(0.0, 1.8);
    let (none, free) = share(50e-3, 1.8);
    assert!(force > 10.0 && none == 0.0);
    assert!(struck > 100.0 * free, "{struck} against {free}");
}

/// A transient that ends once the motion repeats, and few recorded periods, show what the whole run shows: also where it
/// repeats only every second period, and where it never does.
#[test]
fn what_is_watched_of_a_settled_run_is_what_the_whole_run_shows() {
    let cycles = Cycles {
        cycles: 400,
        transient: 340,
    };
    let mut regimes = Vec::new();
    for (gap_m, hz) in [(0.0, 4.5), (0.0, 8.1), (0.0, 17.0), (0.0, 13.0)] {
        let params = at_gap(BEAM_170, gap_m);
        let rig = ModalRig::new(&params, BEAM, 3).unwrap();
        let motion = LinearMotion::of(&params, BEAM, 3, hz).unwrap();
        let follower = Follower::at_rest(motion, &rig);
        let short = watched(follower.clone(), &rig, hz, cycles).unwrap();
        let mut hammer = follower;
        (0..cycles.transient).for_each(|_| hammer.skip());
        let mut sampler = ModesSampler::new(rig.clone(), hz, &hammer.state());
        for _ in cycles.transient..cycles.cycles {
            let mut work = 0.0;
            let period = hammer.run_period(|z, cart_m| sampler.see(z, cart_m), |w| work += w);
            sampler.worked(work);
            sampler.close(&hammer.state(), &period);
        }
        let whole = sampler.observation(hammer.take_strongest());
        regimes.push(short.regime);
        assert_eq!(short.regime, whole.regime, "{hz}");
        if short.section_m.len() == whole.section_m.len() {
            assert_eq!(short, whole, "{hz}");
            continue;
        }
        let last = |seen: &ModalObservation| seen.section_m[seen.section_m.len() - 1];
        let close =
            |a: f64, b: f64, share: f64| assert!((a / b - 1.0).abs() < share, "{hz}: {a} {b}");
        close(short.force_n, whole.force_n, 1e-9);
        close(last(&short), last(&whole), 1e-8);
        close(short.energy_j[0], whole.energy_j[0], 1e-8);
        close(short.contact_loss_w, whole.contact_loss_w, 1e-8);
    }
    let settled = regimes.iter().filter_map(|regime| regime.periods());
    assert_eq!(settled.collect::<Vec<_>>(), [1, 1, 2], "{regimes:?}");
}

#[test]
fn what_cannot_be_modelled_is_refused() {
    let refused =
        |params: RigParams, beam: Beam, count: usize| match ModalRig::new(&params, beam, count) {
            Err(Error::Modes(error)) => error,
            other => panic!("{other:?}"),
        };
    assert_eq!(refused(WIRES, BEAM, 2), ModesError::NotBeams);
    for count in [0, 9] {
        let most = MAX_MODES;
        let expected = ModesError::Count { count, most };
        assert_eq!(refused(BEAM_170, BEAM, count), expected);
    }
    let pressed = refused(at_gap(BEAM_170, -1e-3), BEAM, 2);
    assert_eq!(pressed, ModesError::Gap(-1e-3));
    let hertz = RigParams {
        contact: shared::model::contact::LAWS[1].1,
        ..BEAM_170
    };
    assert_eq!(refused(hertz, BEAM, 2), ModesError::Law);
}
