//! Every fault tripped by injection, the drive off within its stated ticks; and a twin just below the threshold
//! in which nothing trips.

use emulator::scenario::{Act, Scenario, load};
use shared::control::State;
use shared::fault::Fault;

use crate::builtin::verdict;

/// The scenarios run here: each fault has one of its name.
pub fn names() -> [&'static str; 17] {
    Fault::ALL.map(Fault::name)
}

/// Ticks from a condition complete to the drive off: the rest of its block and one more.
const BLOCKS: u64 = 20;
const TICKS_PER_S: f64 = 20_000.0;

/// `name` trips as it says it does; the drive is off within `ticks` of the injection.
fn trips(name: &str, ticks: Option<u64>) {
    let scenario = load(name).unwrap();
    let verdict = verdict(&scenario);
    assert_eq!(verdict.verdict, "pass", "{name}: {:?}", verdict.why);
    let [fault] = &verdict.faults[..] else {
        panic!("{name}: {:?}", verdict.faults);
    };
    assert_eq!(fault.name, name);
    let off = fault.drive_off_after_injection_ticks.unwrap();
    println!("{name}: off {off} ticks after the injection");
    if let Some(ticks) = ticks {
        assert!(off <= ticks, "{name}: {off} ticks, stated {ticks}");
    }
}

/// `name` with its events changed by `below` trips nothing and goes on.
fn does_not_trip(name: &str, below: impl Fn(&mut Scenario)) {
    let mut scenario = load(name).unwrap();
    scenario.expect.faults.clear();
    scenario.expect.final_state = None;
    below(&mut scenario);
    let verdict = verdict(&scenario);
    assert_eq!(verdict.verdict, "pass", "{name}: {:?}", verdict.why);
    assert!(
        ["seek", "hold"].contains(&verdict.final_state),
        "{name}: {}",
        verdict.final_state
    );
}

/// Changes the events of a scenario one by one; those for which `change` is false are left out.
fn each(change: impl Fn(&mut Act) -> bool) -> impl Fn(&mut Scenario) {
    move |scenario| scenario.events.retain_mut(|timed| change(&mut timed.act))
}

fn for_ticks(ticks: f64) -> impl Fn(&mut Scenario) {
    each(move |act| {
        if let Act::SensorFault { for_s, .. } = act {
            *for_s = Some(ticks / TICKS_PER_S);
        }
        true
    })
}

#[test]
fn emergency_stop() {
    trips("emergency-stop", Some(1 + BLOCKS));
    does_not_trip(
        "emergency-stop",
        each(|act| matches!(act, Act::Start { .. })),
    );
}

#[test]
fn over_force() {
    trips("over-force", None);
    // The blow of this push stays below the trip level of 384 N.
    does_not_trip(
        "over-force",
        each(|act| {
            if let Act::Push { speed_m_per_s } = act {
                *speed_m_per_s = 0.1;
            }
            true
        }),
    );
}

#[test]
fn over_travel() {
    trips("over-travel", None);
    does_not_trip(
        "over-travel",
        each(|act| {
            if let Act::Push { speed_m_per_s } = act {
                *speed_m_per_s = -0.03;
            }
            true
        }),
    );
}

#[test]
fn sensor_saturated() {
    trips("sensor-saturated", Some(20 + BLOCKS));
    does_not_trip("sensor-saturated", for_ticks(19.0));
}

#[test]
fn sensor_open() {
    trips("sensor-open", Some(3 + BLOCKS));
    does_not_trip("sensor-open", for_ticks(2.0));
}

#[test]
fn sensor_frozen() {
    // A drive period is 5458 ticks; the slowest drive allowed would have 14652.
    trips("sensor-frozen", Some(5500 + BLOCKS));
    does_not_trip("sensor-frozen", for_ticks(5000.0));
}

#[test]
fn sensor_out_of_family() {
    // Six contacts in a row, read as less than 0.4 of themselves.
    trips("sensor-out-of-family", Some(9 * 5500 + BLOCKS));
    // 0.75 of the momentum trips.
    does_not_trip(
        "sensor-out-of-family",
        each(|act| {
            if let Act::SensorFault { times, .. } = act {
                *times = Some(0.8);
            }
            true
        }),
    );
}

#[test]
fn no_contact() {
    trips("no-contact", None);
    does_not_trip(
        "no-contact",
        each(|act| {
            if let Act::Drift { gap_offset_mm, .. } = act {
                *gap_offset_mm = 0.3;
            }
            true
        }),
    );
}

#[test]
fn regime_lost() {
    trips("regime-lost", None);
    does_not_trip(
        "regime-lost",
        each(|act| {
            if let Act::Drift { gap_offset_mm, .. } = act {
                *gap_offset_mm = 0.3;
            }
            true
        }),
    );
}

fn two_blocks(scenario: &mut Scenario) {
    each(|act| {
        if let Act::Overrun { blocks, .. } | Act::LostBlock { blocks, .. } = act {
            *blocks = 2;
        }
        true
    })(scenario);
}

#[test]
fn overrun() {
    trips("overrun", Some(30 + BLOCKS));
    does_not_trip("overrun", two_blocks);
}

#[test]
fn stale_samples() {
    trips("stale-samples", Some(30 + BLOCKS));
    does_not_trip("stale-samples", two_blocks);
}

#[test]
fn link_timeout() {
    // 2 s, the link having last been heard up to half a second before.
    trips("link-timeout", Some((2.0 * TICKS_PER_S) as u64 + BLOCKS));
    does_not_trip("link-timeout", each(|act| !matches!(act, Act::LinkLoss {})));
}

/// A controller that starts with a fault has its drive off from the first tick; after a plain power-on it waits
/// without one.
fn born_faulty(name: &str) {
    use emulator::under_test::Reset;
    trips(name, Some(0));
    let mut scenario = load(name).unwrap();
    scenario.expect.faults.clear();
    scenario.expect.final_state = Some(State::Idle);
    scenario.events.retain_mut(|timed| {
        if let Act::Reset { cause } = &mut timed.act {
            *cause = Reset::PowerOn;
        }
        // And no start after it.
        timed.at_s < 15.5
    });
    let verdict = verdict(&scenario);
    assert_eq!(verdict.verdict, "pass", "{name}: {:?}", verdict.why);
}

#[test]
fn corrupt_settings() {
    born_faulty("corrupt-settings");
}

#[test]
fn watchdog_reset() {
    born_faulty("watchdog-reset");
}

#[test]
fn brown_out() {
    born_faulty("brown-out");
}

#[test]
fn crash() {
    born_faulty("crash");
}
