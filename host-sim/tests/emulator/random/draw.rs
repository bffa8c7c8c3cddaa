//! Random scenarios, each from its number.

use emulator::cart::{Friction, Stops};
use emulator::motor::MotorParams;
use emulator::scenario::{Scenario, ScenarioAct, StartMode, Stuck, Timed, parse};
use emulator::shaker::ArmatureParams;
use emulator::under_test::Reset;
use shared::settings::DriveKind;

use super::lies::{Random, sensor_fault};

/// When it is stopped, s; the last seconds are for the stop to be obeyed.
const STOP_S: f64 = 11.0;
const OBEYED_S: f64 = 5.0;

/// One scenario in so many is long, and nothing happens in it until Hold may be there: stopped after, and left alone
/// for, s.
pub const LONG: u64 = 4;
const LONG_STOP_S: f64 = 35.0;
const ALONE_S: f64 = 13.0;

/// When `scenario` is stopped, s.
pub fn stop_s(scenario: &Scenario) -> f64 {
    scenario.duration_s - OBEYED_S
}

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

/// Something that happens during the run, if the kind is one of those.
fn mishap(kind: Kind, scenario: &Scenario, r: &mut Random) -> Option<ScenarioAct> {
    let strong_n = f64::from(scenario.settings.limits.force_n) / 2.5;
    let drift = |hz: f64, gap_mm: f64, restitution: Option<f64>, over_s: f64| ScenarioAct::Drift {
        over_s,
        natural_frequency_percent: hz,
        contact_stiffness_percent: 0.0,
        contact_damping_percent: 0.0,
        gap_offset_mm: gap_mm,
        restitution,
    };
    Some(match kind {
        Kind::Emergency => ScenarioAct::EmergencyStop {
            for_s: Some(r.within(1e-4, 1.0)),
        },
        Kind::Link => {
            if r.below(2) == 0 {
                ScenarioAct::Link {}
            } else {
                ScenarioAct::LinkLoss {}
            }
        }
        Kind::Overrun => ScenarioAct::Overrun {
            blocks: r.count(1, 6),
            every: r.count(1, 8),
        },
        Kind::Lost => ScenarioAct::LostBlock {
            blocks: r.count(1, 6),
            every: r.count(1, 8),
        },
        Kind::Reset => ScenarioAct::Reset {
            cause: r.one(&[
                Reset::PowerOn,
                Reset::Watchdog,
                Reset::BrownOut,
                Reset::WhileDriving,
                Reset::Crash,
            ]),
        },
        Kind::Command => match r.below(3) {
            0 => ScenarioAct::ClearFault {},
            1 => ScenarioAct::Start {
                mode: StartMode::Automatic,
            },
            _ => ScenarioAct::Start {
                mode: StartMode::Manual,
            },
        },
        Kind::Push => ScenarioAct::Push {
            speed_m_per_s: r.within(-0.6, 0.6),
        },
        Kind::Drift => drift(
            r.within(-8.0, 8.0),
            r.within(-2.0, 4.0),
            None,
            r.within(0.0, 2.0),
        ),
        Kind::Restitution => drift(0.0, 0.0, Some(r.within(0.15, 0.9)), r.within(0.0, 4.0)),
        Kind::Recede => ScenarioAct::Recede {
            mm_per_j: r.within(0.0, 40.0),
            mm_per_s: r.within(0.0, 0.3),
            up_to_mm: Some(r.within(0.1, 3.0)),
            for_s: None,
        },
        Kind::Tilt => ScenarioAct::Tilt {
            degrees: r.within(-2.0, 2.0),
            over_s: r.within(0.0, 3.0),
        },
        Kind::Friction => {
            let coulomb_n = r.within(0.0, 40.0);
            ScenarioAct::CartFriction {
                coulomb_n: Some(coulomb_n),
                static_n: Some(coulomb_n * r.within(1.0, 3.0)),
                viscous_n_s_per_m: Some(r.within(0.0, 60.0)),
                for_s: Some(r.within(0.5, 8.0)),
            }
        }
        Kind::StuckDrive => ScenarioAct::StuckDrive {
            how: r.one(&[Stuck::RunsOn, Stuck::Powered]),
            for_s: Some(r.within(0.1, 4.0)),
        },
        Kind::ByHand => {
            let natural_hz = scenario.settings.rig.natural_frequency_hz();
            let amplitude_mm = 1e3 * scenario.settings.rig.amplitude_m;
            ScenarioAct::SetPoint {
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
    let long = number % LONG == LONG - 1;
    let (from_s, stop_s) = if long {
        (ALONE_S, LONG_STOP_S)
    } else {
        (2.0, STOP_S)
    };
    let duration_s = stop_s + OBEYED_S;
    let text = format!(
        "duration_s = {duration_s:?}\nblock_ticks = {block_ticks}\n[true_rig]\npreset = \"{rig}\"\ngap_mm = {gap_mm:?}\nnatural_frequency_percent = {hz:?}\ncontact_stiffness_percent = {stiffness:?}\ncontact_damping_percent = {damping:?}\n[sensors]\nnoise_percent = {noise:?}\n"
    );
    let mut scenario = parse("random", &text, "random").unwrap();
    scenario.seed = r.next();
    // The command is there however small the block.
    scenario.slices_per_block = 2 * block_ticks;
    if r.below(2) == 0 {
        trips(&mut scenario, r);
    }
    let mut mode = StartMode::Automatic;
    let mut events = Vec::new();
    for _ in 0..r.count(1, 6) {
        let kind = r.one(kinds);
        hardware(kind, &mut scenario, r);
        if kind == Kind::ByHand {
            mode = StartMode::Manual;
        }
        // One in five is there from the start, also in a long one.
        let from_start = r.below(5) == 0 && kind != Kind::Reset;
        let at_s = r.within(from_s, stop_s);
        if let Some(act) = mishap(kind, &scenario, r) {
            events.push((if from_start { 0.0 } else { at_s }, act));
        }
    }
    if mode == StartMode::Manual {
        // As a person does: several set-points, also soon after one another.
        for _ in 0..r.count(1, 8) {
            let at_s = r.within(1.5, stop_s);
            events.extend(mishap(Kind::ByHand, &scenario, r).map(|act| (at_s, act)));
        }
    }
    events.extend([
        (0.1, ScenarioAct::Start { mode }),
        (stop_s, ScenarioAct::Stop {}),
    ]);
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    scenario.events = events
        .into_iter()
        .map(|(at_s, act)| Timed { at_s, act })
        .collect();
    scenario
}
