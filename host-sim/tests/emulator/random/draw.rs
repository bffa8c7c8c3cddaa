//! Random scenarios, each from its number.

use emulator::cart::{Friction, Stops};
use emulator::motor::MotorParams;
use emulator::scenario::{Act, Fault, Mode, Scenario, Stuck, Timed, Which, parse};
use emulator::sensors::End;
use emulator::shaker::ArmatureParams;
use emulator::under_test::Reset;
use shared::settings::DriveKind;

/// Rig time, s; the last seconds are for the stop to be obeyed.
const DURATION_S: f64 = 16.0;
const STOP_S: f64 = 11.0;

macro_rules! kinds {
    ($($kind:ident: $name:literal),* $(,)?) => {
        /// What may be drawn.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Kind {
            $(#[doc = $name] $kind,)*
        }

        impl Kind {
            pub const ALL: &[Self] = &[$(Self::$kind,)*];

            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$kind => $name,)*
                }
            }
        }
    };
}

kinds! {
    // Signals and lines.
    Short: "short",
    Gain: "gain",
    Common: "common",
    Supply: "supply",
    GainDrift: "gain-drift",
    Reversed: "reversed",
    Offset: "offset",
    OffsetDrift: "offset-drift",
    Dead: "dead",
    Delayed: "delayed",
    Intermittent: "intermittent",
    Emergency: "emergency",
    Link: "link",
    // The board.
    Overrun: "overrun",
    Lost: "lost",
    Reset: "reset",
    Command: "command",
    // Rig and ground.
    Push: "push",
    Drift: "drift",
    Restitution: "restitution",
    Recede: "recede",
    Tilt: "tilt",
    Friction: "friction",
    Stops: "stops",
    // The drive.
    Armature: "armature",
    Impedance: "impedance",
    Motor: "motor",
    StuckDrive: "stuck-drive",
    // By hand.
    ByHand: "by-hand",
}

/// Numbers from a number (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn count(&mut self, from: u32, to: u32) -> u32 {
        from + self.below((to - from) as usize) as u32
    }
}

/// A sensor fault without its numbers.
fn fault(sensor: Which, fault: Fault, for_s: Option<f64>) -> Act {
    Act::SensorFault {
        sensor,
        fault,
        times: None,
        for_s,
        percent_per_s: None,
        offset_n: None,
        offset_um: None,
        drift_n_per_s: None,
        drift_um_per_s: None,
        noise_n: None,
        noise_um: None,
        delay_ms: None,
        ticks: None,
        of: None,
        at: None,
    }
}

/// A sensor fault of this kind; `strong_n` is the force of a strong 1/1.
fn sensor_fault(kind: Kind, strong_n: f64, r: &mut Random) -> Act {
    let one = r.one(&[Which::Force, Which::Hammer, Which::Cart]);
    // Half of them stay.
    let stays = r.below(2) == 0;
    let for_s = (!stays).then(|| r.within(0.5, 8.0));
    let numbers = |act: Act, set: &mut dyn FnMut(&mut Numbers)| {
        let mut numbers = Numbers::default();
        set(&mut numbers);
        numbers.put(act)
    };
    let (length, force) = (one != Which::Force, one == Which::Force);
    match kind {
        Kind::Short => {
            let how = r.one(&[
                Fault::Open,
                Fault::Saturated,
                Fault::SaturatedLow,
                Fault::Frozen,
            ]);
            fault(one, how, Some(r.within(1e-4, 2.0)))
        }
        Kind::Gain => {
            let times = r.within(0.3, 1.8);
            numbers(fault(one, Fault::Gain, for_s), &mut |n| {
                n.times = Some(times)
            })
        }
        Kind::Common | Kind::Supply => {
            let which = r.one(&[Which::Displacements, Which::All]);
            let how = if kind == Kind::Common {
                Fault::Gain
            } else {
                Fault::Supply
            };
            let times = r.within(0.4, 1.4);
            numbers(fault(which, how, for_s), &mut |n| n.times = Some(times))
        }
        Kind::GainDrift => {
            let rate = r.within(-12.0, 12.0);
            numbers(fault(one, Fault::GainDrift, for_s), &mut |n| {
                n.percent_per_s = Some(rate)
            })
        }
        Kind::Reversed => fault(one, Fault::Reversed, for_s),
        Kind::Offset => {
            let (um, newtons) = (r.within(-1500.0, 1500.0), strong_n * r.within(-0.5, 0.5));
            numbers(fault(one, Fault::Offset, for_s), &mut |n| {
                n.offset_um = length.then_some(um);
                n.offset_n = force.then_some(newtons);
            })
        }
        Kind::OffsetDrift => {
            let (um, newtons) = (r.within(-300.0, 300.0), strong_n * r.within(-0.1, 0.1));
            numbers(fault(one, Fault::OffsetDrift, for_s), &mut |n| {
                n.drift_um_per_s = length.then_some(um);
                n.drift_n_per_s = force.then_some(newtons);
            })
        }
        Kind::Dead => {
            let (um, newtons) = (r.within(0.0, 60.0), strong_n * r.within(0.0, 0.04));
            numbers(fault(one, Fault::Dead, for_s), &mut |n| {
                n.noise_um = length.then_some(um);
                n.noise_n = force.then_some(newtons);
            })
        }
        Kind::Delayed => {
            let ms = r.within(0.1, 120.0);
            numbers(fault(one, Fault::Delayed, for_s), &mut |n| {
                n.delay_ms = Some(ms)
            })
        }
        _ => {
            let of = r.count(2, 400);
            let ticks = r.count(1, of + 1);
            let at = r.one(&[End::Open, End::High, End::Low]);
            numbers(fault(one, Fault::Intermittent, for_s), &mut |n| {
                n.ticks = Some(ticks);
                n.of = Some(of);
                n.at = Some(at);
            })
        }
    }
}

/// The numbers of a sensor fault.
#[derive(Default)]
struct Numbers {
    times: Option<f64>,
    percent_per_s: Option<f64>,
    offset_n: Option<f64>,
    offset_um: Option<f64>,
    drift_n_per_s: Option<f64>,
    drift_um_per_s: Option<f64>,
    noise_n: Option<f64>,
    noise_um: Option<f64>,
    delay_ms: Option<f64>,
    ticks: Option<u32>,
    of: Option<u32>,
    at: Option<End>,
}

impl Numbers {
    fn put(self, act: Act) -> Act {
        match act {
            Act::SensorFault {
                sensor,
                fault,
                for_s,
                ..
            } => Act::SensorFault {
                sensor,
                fault,
                for_s,
                times: self.times,
                percent_per_s: self.percent_per_s,
                offset_n: self.offset_n,
                offset_um: self.offset_um,
                drift_n_per_s: self.drift_n_per_s,
                drift_um_per_s: self.drift_um_per_s,
                noise_n: self.noise_n,
                noise_um: self.noise_um,
                delay_ms: self.delay_ms,
                ticks: self.ticks,
                of: self.of,
                at: self.at,
            },
            act => act,
        }
    }
}

/// Something that happens during the run, if the kind is one of those.
fn mishap(kind: Kind, scenario: &Scenario, r: &mut Random) -> Option<Act> {
    let strong_n = f64::from(scenario.settings.limits.force_n) / 2.5;
    let drift = |hz: f64, gap_mm: f64, restitution: Option<f64>, over_s: f64| Act::Drift {
        over_s,
        natural_frequency_percent: hz,
        contact_stiffness_percent: 0.0,
        contact_damping_percent: 0.0,
        gap_offset_mm: gap_mm,
        restitution,
    };
    Some(match kind {
        Kind::Emergency => Act::EmergencyStop {
            for_s: Some(r.within(1e-4, 1.0)),
        },
        Kind::Link => {
            if r.below(2) == 0 {
                Act::Link {}
            } else {
                Act::LinkLoss {}
            }
        }
        Kind::Overrun => Act::Overrun {
            blocks: r.count(1, 6),
            every: r.count(1, 8),
        },
        Kind::Lost => Act::LostBlock {
            blocks: r.count(1, 6),
            every: r.count(1, 8),
        },
        Kind::Reset => Act::Reset {
            cause: r.one(&[
                Reset::PowerOn,
                Reset::Watchdog,
                Reset::BrownOut,
                Reset::Crash,
            ]),
        },
        Kind::Command => match r.below(3) {
            0 => Act::ClearFault {},
            1 => Act::Start {
                mode: Mode::Automatic,
            },
            _ => Act::Start { mode: Mode::Manual },
        },
        Kind::Push => Act::Push {
            speed_m_per_s: r.within(-0.6, 0.6),
        },
        Kind::Drift => drift(
            r.within(-8.0, 8.0),
            r.within(-2.0, 4.0),
            None,
            r.within(0.0, 2.0),
        ),
        Kind::Restitution => drift(0.0, 0.0, Some(r.within(0.15, 0.9)), r.within(0.0, 4.0)),
        Kind::Recede => Act::Recede {
            mm_per_j: r.within(0.0, 40.0),
            mm_per_s: r.within(0.0, 0.3),
            up_to_mm: Some(r.within(0.1, 3.0)),
            for_s: None,
        },
        Kind::Tilt => Act::Tilt {
            degrees: r.within(-2.0, 2.0),
            over_s: r.within(0.0, 3.0),
        },
        Kind::Friction => {
            let coulomb_n = r.within(0.0, 40.0);
            Act::CartFriction {
                coulomb_n: Some(coulomb_n),
                static_n: Some(coulomb_n * r.within(1.0, 3.0)),
                viscous_n_s_per_m: Some(r.within(0.0, 60.0)),
                for_s: Some(r.within(0.5, 8.0)),
            }
        }
        Kind::StuckDrive => Act::StuckDrive {
            how: r.one(&[Stuck::RunsOn, Stuck::Powered]),
            for_s: Some(r.within(0.1, 4.0)),
        },
        Kind::ByHand => {
            let natural_hz = scenario.settings.rig.natural_frequency_hz();
            let amplitude_mm = 1e3 * scenario.settings.rig.amplitude_m;
            Act::SetPoint {
                frequency_hz: natural_hz * r.within(0.5, 4.5),
                amplitude_mm: amplitude_mm * r.within(0.0, 2.0),
            }
        }
        Kind::Stops | Kind::Armature | Kind::Impedance | Kind::Motor => return None,
        sensor => sensor_fault(sensor, strong_n, r),
    })
}

/// What a kind is from the start on.
fn hardware(kind: Kind, scenario: &mut Scenario, r: &mut Random) {
    let (m, cart_kg) = (
        scenario.true_rig.amplitude_m,
        scenario.true_rig.cart_mass_kg,
    );
    match kind {
        Kind::Stops => {
            scenario.mounting.stops = Some(Stops {
                at_m: m * r.within(0.7, 3.0),
                stiffness_n_per_m: 1e6,
                damping_s_per_m: r.within(0.0, 3.0),
            });
        }
        Kind::Tilt => scenario.mounting.tilt_rad = r.within(-0.03, 0.03),
        Kind::Friction => {
            let coulomb_n = r.within(0.0, 30.0);
            scenario.mounting.friction = Some(Friction {
                coulomb_n,
                static_n: coulomb_n * r.within(1.0, 3.0),
                viscous_n_s_per_m: r.within(0.0, 40.0),
            });
        }
        Kind::Armature => {
            scenario.shaker.armature = Some(ArmatureParams {
                mass_kg: cart_kg * r.within(0.02, 0.3),
                hz: r.within(2.0, 120.0),
                damping_ratio: r.within(0.005, 0.2),
            });
        }
        Kind::Impedance => scenario.shaker.impedance_n_s_per_m = r.within(0.0, 200.0),
        Kind::Motor => {
            let mass_kg = cart_kg + scenario.true_rig.mass_kg;
            let motor = MotorParams::for_cart(m * r.within(0.7, 1.5), mass_kg);
            scenario.motor = Some(MotorParams {
                rod_ratio: r.within(0.0, 0.4),
                lag_s: r.within(0.01, 0.5),
                slip_hz_per_n_m: motor.slip_hz_per_n_m * r.within(0.1, 5.0),
                ..motor
            });
            scenario.settings.drive.kind = DriveKind::Motor;
        }
        _ => {}
    }
}

/// Trip levels near what the rig really does, so that a small lie matters.
fn trips(scenario: &mut Scenario, r: &mut Random) {
    let before = scenario.settings;
    let strong_n = before.limits.force_n / 2.5;
    let amplitude_m = before.limits.amplitude_m / 1.5;
    let settings = &mut scenario.settings;
    settings.trips.force_n = strong_n * r.within(0.7, 3.0) as f32;
    settings.limits.force_n = settings.trips.force_n * r.within(0.5, 0.9) as f32;
    settings.limits.amplitude_m = amplitude_m * r.within(1.05, 1.5) as f32;
    let room = r.within(1.1, 1.6) as f32;
    settings.trips.cart_m = (settings.limits.amplitude_m * room).min(before.trips.cart_m);
    if settings.check().is_err() {
        *settings = before;
    }
}

/// The scenario of this number, with draws of these kinds.
pub fn scenario(number: u64, kinds: &[Kind]) -> Scenario {
    let r = &mut Random(number.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x5851_f42d);
    let rig = r.one(&["wires", "beam-170", "beam-150", "beam-135"]);
    let gap_mm = r.within(0.0, 3.0);
    let (hz, stiffness) = (r.within(-10.0, 10.0), r.within(-30.0, 30.0));
    let (damping, noise) = (r.within(-30.0, 30.0), r.within(0.0, 3.0));
    let block_ticks = r.count(1, 11);
    let text = format!(
        "duration_s = {DURATION_S:?}\nblock_ticks = {block_ticks}\n[true_rig]\npreset = \"{rig}\"\ngap_mm = {gap_mm:?}\nnatural_frequency_percent = {hz:?}\ncontact_stiffness_percent = {stiffness:?}\ncontact_damping_percent = {damping:?}\n[sensors]\nnoise_percent = {noise:?}\n"
    );
    let mut scenario = parse("random", &text, "random").unwrap();
    scenario.seed = r.next();
    // The command is there however small the block.
    scenario.slices_per_block = 2 * block_ticks;
    if r.below(2) == 0 {
        trips(&mut scenario, r);
    }
    let mut mode = Mode::Automatic;
    let mut events = Vec::new();
    for _ in 0..r.count(1, 6) {
        let kind = r.one(kinds);
        hardware(kind, &mut scenario, r);
        if kind == Kind::ByHand {
            mode = Mode::Manual;
        }
        // One in five is there from the start.
        let from_start = r.below(5) == 0 && kind != Kind::Reset;
        let at_s = r.within(2.0, STOP_S);
        if let Some(act) = mishap(kind, &scenario, r) {
            events.push((if from_start { 0.0 } else { at_s }, act));
        }
    }
    if mode == Mode::Manual {
        // As a person does: several set-points, also soon after one another.
        for _ in 0..r.count(1, 8) {
            let at_s = r.within(1.5, STOP_S);
            events.extend(mishap(Kind::ByHand, &scenario, r).map(|act| (at_s, act)));
        }
    }
    events.extend([(0.1, Act::Start { mode }), (STOP_S, Act::Stop {})]);
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    scenario.events = events
        .into_iter()
        .map(|(at_s, act)| Timed { at_s, act })
        .collect();
    scenario
}
