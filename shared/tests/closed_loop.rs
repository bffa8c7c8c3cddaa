//! The whole controller around the model itself as its plant: it finds the operating frequency and holds it, makes the
//! force that is wanted, keeps its limits and says what it sees.

use shared::control::{ActiveLimits, BootInfo, Command, EventKind, Lockstep, Mode, State, Status};
use shared::fault::{Fault, Origin};
use shared::io::{AdcCode, Channel, DacCode, Frame, Output};
use shared::model::drive::Drive;
use shared::model::params::{PRESETS, RigParams, WIRES};
use shared::model::regime::Regime;
use shared::model::rig::Rig;
use shared::model::step::Corrected;
use shared::model::twin::Twin;
use shared::settings::{DriveKind, Settings, TICK_S};

/// A rig that follows the drive without error, and sensors without noise.
struct Plant {
    params: RigParams,
    twin: Twin<f64, Corrected>,
    /// The set-points have had more than the amplitude of the proof.
    full: bool,
    on: bool,
    last: DacCode,
    /// The cart's motion over the one commanded.
    cart_gain: f64,
    /// Gains of the sensors of force and hammer.
    gains: (f64, f64),
    /// What the force sensor reads at no force, N.
    force_zero_n: f64,
    /// What the cart's sensor reads in the middle, m.
    cart_zero_m: f64,
    /// The largest force so far, N.
    largest_n: f64,
}

impl Plant {
    fn new(params: &RigParams) -> Self {
        let rig = Rig::new(params).unwrap();
        let drive = Drive::new(params.natural_frequency_hz(), TICK_S).unwrap();
        Self {
            params: *params,
            twin: Twin::at_rest(rig, drive, Corrected),
            full: false,
            on: false,
            last: DacCode::MIDDLE,
            cart_gain: 1.0,
            gains: (1.0, 1.0),
            force_zero_n: 0.0,
            cart_zero_m: 0.0,
            largest_n: 0.0,
        }
    }

    /// The cart passes the middle: amplitude and gap are from now on these.
    fn renew(&mut self, amplitude_m: f64) {
        self.params.amplitude_m = amplitude_m.max(1e-7);
        let rig = Rig::new(&self.params).unwrap();
        self.twin = Twin::new(rig, *self.twin.drive(), Corrected, *self.twin.state());
    }

    /// In the proof of the sensors the cart follows the set-points and takes the hammer along, as if it were pressed on. Once
    /// they go further, the cart moves in step with them from where they rise through the middle next; a motor's from the
    /// start.
    fn tick(&mut self, settings: &Settings, output: &Output, amplitude_m: f32) -> Frame {
        let code = |channel: &Channel, value: f64| {
            let code = value / f64::from(channel.unit_per_code) + f64::from(channel.zero_code);
            AdcCode((code + 0.5).clamp(0.0, 4095.0) as u16)
        };
        let set_m = (f64::from(output.dac.0) - 2048.0) * f64::from(settings.drive.m_per_code);
        self.full |= set_m > 0.53 * settings.rig.amplitude_m;
        let rises = self.full && self.last < DacCode::MIDDLE && output.dac >= DacCode::MIDDLE;
        self.last = output.dac;
        let motor = settings.drive.kind == DriveKind::Motor;
        self.on = output.enable && (self.on || rises || motor);
        if rises {
            self.renew(self.cart_gain * f64::from(amplitude_m));
        }
        let mut force_n = 0.0;
        if self.on {
            let hz = f64::from(output.frequency_hz);
            if (hz - self.twin.drive().frequency_hz()).abs() > 1e-5 {
                self.twin.set_frequency(hz, TICK_S).unwrap();
            }
            force_n = self.twin.tick().impulse / TICK_S;
        }
        self.largest_n = self.largest_n.max(force_n);
        let rig = self.twin.rig();
        let relative = rig.relative_displacement(self.twin.state().q.hi);
        let cart = if self.on {
            self.params.amplitude_m * self.twin.drive().sin()
        } else {
            set_m
        };
        Frame {
            force: code(&settings.force, self.gains.0 * force_n + self.force_zero_n),
            hammer: code(&settings.hammer, self.gains.1 * (relative + cart)),
            cart: code(&settings.cart, cart + self.cart_zero_m),
            emergency: false,
        }
    }
}

/// The controller and its plant.
struct Loop {
    settings: Settings,
    node: Lockstep,
    plant: Plant,
    outputs: [Output; 10],
    events: Vec<EventKind>,
}

impl Loop {
    fn new(params: &RigParams, change: impl FnOnce(&mut Settings)) -> Self {
        let mut settings = Settings::for_rig(params);
        change(&mut settings);
        Self {
            settings,
            node: Lockstep::new(&settings, &BootInfo::STORED).unwrap(),
            plant: Plant::new(params),
            outputs: [Output::SAFE; 10],
            events: Vec::new(),
        }
    }

    fn status(&self) -> Status {
        self.node.controller.status()
    }

    fn command(&mut self, command: Command) {
        self.node.controller.command(command).unwrap();
    }

    fn block(&mut self) {
        let amplitude_m = self.status().amplitude_m;
        let settings = self.settings;
        let frames = self
            .outputs
            .map(|output| self.plant.tick(&settings, &output, amplitude_m));
        self.node.exchange(&frames, &mut self.outputs, 20);
        while let Some(event) = self.node.controller.take_event() {
            self.events.push(event.kind);
        }
    }

    fn pass(&mut self, seconds: f64) {
        for _ in 0..(seconds * 2000.0) as u32 {
            self.block();
        }
    }

    /// Runs until `state`; how long that took, s.
    fn until(&mut self, state: State, seconds: f64) -> f64 {
        for block in 0..(seconds * 2000.0) as u32 {
            if self.status().state == state {
                return f64::from(block) / 2000.0;
            }
            self.block();
        }
        panic!("no {state:?} in {seconds} s: {:?}", self.status());
    }

    /// An automatic start, held.
    fn held(params: &RigParams, change: impl FnOnce(&mut Settings)) -> Self {
        let mut held = Self::new(params, change);
        held.command(Command::Start(Mode::Automatic));
        held.until(State::Hold, 120.0);
        held
    }

    fn fault(&self) -> Option<(Fault, Origin)> {
        let record = self.status().fault;
        record.map(|record| (record.fault, record.origin))
    }
}

#[test]
fn every_preset_is_brought_to_hold_at_its_optimum() {
    // Of the reference (`host-sim pick --nominal`), Hz.
    let optima = [3.664, 9.040, 10.536, 13.023];
    for ((name, params), optimum_hz) in PRESETS.into_iter().zip(optima) {
        let mut start = Loop::new(&params, |_| {});
        start.command(Command::Start(Mode::Automatic));
        let seconds = start.until(State::Hold, 120.0);
        assert!(seconds < 60.0, "{name}: {seconds} s");
        let best_hz = start.events.iter().rev().find_map(|event| match event {
            EventKind::Best { frequency_hz, .. } => Some(*frequency_hz),
            _ => None,
        });
        // The force is flat there: 1 % of frequency is 0.1 % of force.
        let off = best_hz.expect(name) / optimum_hz - 1.0;
        assert!(off.abs() < 0.005, "{name}: {best_hz:?} Hz");
    }
}

#[test]
fn one_one_in_hold_is_reported_as_it_is_and_trips_nothing() {
    let mut held = Loop::held(&WIRES, |_| {});
    // Before the first climb.
    held.pass(20.0);
    let status = held.status();
    assert_eq!((status.state, held.fault()), (State::Hold, None));
    let one_one = Regime::Periodic {
        impacts: 1,
        periods: 1,
    };
    assert_eq!(status.regime, one_one);
    assert!((status.peak_n / 96.0 - 1.0).abs() < 0.02, "{status:?}");
    assert!(
        (status.impulse_n_s / 0.0311 - 1.0).abs() < 0.02,
        "{status:?}"
    );
    let a0_m = WIRES.amplitude_m as f32;
    assert!((status.amplitude_m / a0_m - 1.0).abs() < 0.02, "{status:?}");
    assert_eq!(status.limits, ActiveLimits::NONE);
}

#[test]
fn a_force_that_is_wanted_is_made_and_never_passed() {
    for wanted_n in [60.0, 120.0] {
        let mut held = Loop::held(&WIRES, |settings| {
            settings.aim.force_n = wanted_n;
            // More than what the first contacts may hide.
            settings.limits.force_n = 1.5 * wanted_n;
            settings.limits.amplitude_m = 1.6 * WIRES.amplitude_m as f32;
        });
        // Before the first climb, and after it.
        held.pass(24.0);
        let early_n = held.status().peak_n;
        assert!((early_n / wanted_n - 1.0).abs() < 0.03, "{early_n}");
        held.pass(60.0);
        let status = held.status();
        assert!((status.peak_n / wanted_n - 1.0).abs() < 0.03, "{status:?}");
        // Nothing has to be clamped for it, on the way or later.
        let clamps = |event: &EventKind| matches!(event, EventKind::Limits(_));
        assert!(!held.events.iter().any(clamps));
        let largest_n = held.plant.largest_n;
        assert!(
            largest_n < 1.1 * f64::from(wanted_n),
            "{wanted_n}: {largest_n}"
        );
    }
}

#[test]
fn a_search_that_a_frequency_limit_holds_says_so() {
    let mut held = Loop::held(&WIRES, |settings| settings.limits.max_frequency_hz = 3.3);
    held.pass(5.0);
    let status = held.status();
    assert_eq!(status.state, State::Hold);
    // The forecast ends at the limit, and the search keeps clear of its end.
    assert!((3.2..=3.3).contains(&status.frequency_hz), "{status:?}");
    assert_eq!(status.limits, ActiveLimits::FREQUENCY);
    let said = EventKind::Limits(ActiveLimits::FREQUENCY);
    assert!(held.events.contains(&said));
}

/// By hand at the rig's amplitude and 3.6 Hz: 96 N once per drive period; with these gains of the sensors of force and hammer.
fn by_hand_with(gains: (f64, f64), change: impl FnOnce(&mut Settings)) -> Loop {
    let mut hand = Loop::new(&WIRES, change);
    hand.plant.gains = gains;
    // Two sensors have a zero of their own, found before the start.
    hand.plant.cart_zero_m = 0.3e-3;
    hand.plant.force_zero_n = 5.0;
    hand.command(Command::Start(Mode::Manual));
    hand.until(State::Manual, 20.0);
    hand.command(Command::SetPoint {
        frequency_hz: 3.6,
        amplitude_m: WIRES.amplitude_m as f32,
    });
    hand.pass(20.0);
    assert_eq!(hand.fault(), None);
    hand
}

fn by_hand() -> Loop {
    let hand = by_hand_with((1.0, 1.0), |_| {});
    assert_eq!(hand.status().state, State::Manual);
    hand
}

#[test]
fn a_motor_that_strikes_harder_or_swings_further_than_allowed_is_switched_off() {
    let run = |gains: (f64, f64), change: fn(&mut Settings)| {
        let motor = by_hand_with(gains, |settings| {
            settings.drive.kind = DriveKind::Motor;
            change(settings);
        });
        let limits = motor.events.iter().find_map(|event| match event {
            EventKind::Limits(limits) => Some(*limits),
            _ => None,
        });
        (motor.status().state, limits)
    };
    let off = |limit| (State::Idle, Some(limit));
    let right = (1.0, 1.0);
    assert_eq!(run(right, |_| {}), (State::Manual, None));
    let force = run(right, |settings| settings.limits.force_n = 80.0);
    assert_eq!(force, off(ActiveLimits::FORCE));
    let travel = run(right, |settings| settings.limits.travel_m = 1e-3);
    assert_eq!(travel, off(ActiveLimits::TRAVEL));
    // A force or a travel that reads too little is taken for what it may be: 82 N for 87 N.
    let force = run((0.85, 1.0), |settings| settings.limits.force_n = 85.0);
    assert_eq!(force, off(ActiveLimits::FORCE));
    let travel = run((1.0, 0.85), |settings| settings.limits.travel_m = 3e-3);
    assert_eq!(travel, off(ActiveLimits::TRAVEL));
}

#[test]
fn a_hammer_that_no_longer_strikes_where_it_must_is_missed_after_five_seconds() {
    let mut hand = by_hand();
    // The surface is taken away.
    hand.plant.params.gap_m = 5e-3;
    hand.pass(4.6);
    assert_eq!(hand.fault(), None);
    // The last contact may be a drive period later or earlier.
    hand.pass(0.8);
    assert_eq!(hand.fault(), Some((Fault::NoContact, Origin::System)));
}

#[test]
fn the_zero_of_the_force_is_followed_and_one_that_is_far_off_is_found() {
    let mut hand = by_hand();
    // It drifts by 8 N.
    for _ in 0..16 {
        hand.plant.force_zero_n += 0.5;
        hand.pass(0.3);
    }
    assert_eq!(hand.fault(), None);
    assert!(
        (hand.status().peak_n / 96.0 - 1.0).abs() < 0.03,
        "{:?}",
        hand.status()
    );
    // Beyond 5 % of the force limit of 240 N it trips.
    hand.plant.force_zero_n += 5.0;
    hand.pass(1.5);
    assert_eq!(
        hand.fault(),
        Some((Fault::SensorOutOfFamily, Origin::Force))
    );
}

#[test]
fn a_surface_that_recedes_is_followed_and_then_the_tool_is_to_be_fed() {
    let mut held = Loop::held(&WIRES, |_| {});
    held.pass(5.0);
    held.events.clear();
    let fed = |held: &Loop| held.status().limits.contains(ActiveLimits::FEED);
    // 50 µm/s, to 1.4 and 1.6 amplitudes.
    for (gap, feed) in [(1.4, false), (1.6, true)] {
        while held.plant.params.gap_m < gap * 0.89e-3 {
            held.plant.params.gap_m += 5e-6;
            held.pass(0.1);
        }
        held.pass(30.0);
        assert_eq!((held.status().state, held.fault()), (State::Hold, None));
        assert_eq!(fed(&held), feed, "{gap}");
    }
    let identified = |event: &EventKind| matches!(event, EventKind::Identified { .. });
    assert!(held.events.iter().any(identified));
}

#[test]
fn a_cart_that_suddenly_goes_too_far_is_met_within_half_a_drive_period() {
    let mut hand = by_hand();
    let a0_m = WIRES.amplitude_m;
    let share = |hand: &Loop| f64::from(hand.status().amplitude_m) / a0_m;
    assert!((share(&hand) - 1.0).abs() < 0.03, "{:?}", hand.status());
    // Just short of what is taken for a fault of the sensor.
    hand.plant.cart_gain = 1.28;
    while hand.plant.params.amplitude_m < 1.2 * a0_m {
        hand.block();
    }
    hand.pass(0.5 / 3.6);
    assert!(share(&hand) < 0.95, "{:?}", hand.status());
    // The answer is little less than seven tenths of the command that makes the amplitude.
    for _ in 0..2000 {
        hand.block();
        assert!(share(&hand) > 0.45, "{:?}", hand.status());
    }
    hand.pass(10.0);
    // Now less of a command makes the amplitude.
    assert!(
        (1.28 * share(&hand) - 1.0).abs() < 0.05,
        "{:?}",
        hand.status()
    );
    for gain in [1.12, 1.0] {
        hand.plant.cart_gain = gain;
        hand.pass(10.0);
    }
    assert!((share(&hand) - 1.0).abs() < 0.03, "{:?}", hand.status());
    assert_eq!(hand.fault(), None);
}

#[test]
fn a_force_that_may_be_larger_than_it_reads_is_limited_by_what_it_may_be() {
    for (gain, limits) in [(1.0, ActiveLimits::NONE), (0.85, ActiveLimits::FORCE)] {
        let hand = by_hand_with((gain, 1.0), |settings| {
            // By hand 97 % of a limit is used.
            settings.limits.force_n = ((96.0 * gain + 4.0) / 0.97) as f32;
        });
        assert_eq!(hand.status().limits, limits, "{gain}");
    }
}
