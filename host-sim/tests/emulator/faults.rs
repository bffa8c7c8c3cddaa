//! Every fault tripped by injection, the drive off within its stated ticks; and a twin just below the threshold
//! in which nothing trips.

use emulator::scenario::{Scenario, ScenarioAct, Timed, load};
use shared::control::State;
use shared::fault::Fault;

use crate::builtin::verdict;

/// The scenarios run here: each fault has one of its name.
pub fn names() -> [&'static str; 19] {
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
fn each(change: impl Fn(&mut ScenarioAct) -> bool) -> impl Fn(&mut Scenario) {
    move |scenario| scenario.events.retain_mut(|timed| change(&mut timed.act))
}

fn for_ticks(ticks: f64) -> impl Fn(&mut Scenario) {
    each(move |act| {
        if let ScenarioAct::SensorFault(how) = act {
            how.for_s = Some(ticks / TICKS_PER_S);
        }
        true
    })
}

/// The scenario `emergency-stop` with the chain opening again at each of these times for 0.3 ms.
fn opens_again(at_s: &[f64]) -> Scenario {
    let mut scenario = load("emergency-stop").unwrap();
    let again = at_s.iter().map(|at_s| Timed {
        at_s: *at_s,
        act: ScenarioAct::EmergencyStop { for_s: Some(3e-4) },
    });
    scenario.events.extend(again);
    scenario.events.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
    scenario
}

/// The chain's filter lets 0.139 ms pass unseen, however that lies to the samples; on the way back, the fault is cleared
/// only after a whole block of samples (0.5 ms) in which the chain was closed.
#[test]
fn emergency_stop() {
    // The filter's three ticks, and the sample.
    trips("emergency-stop", Some(3 + 1 + BLOCKS));
    let open_for = |ms: f64| {
        each(move |act| {
            if let ScenarioAct::EmergencyStop { for_s } = act {
                *for_s = Some(1e-3 * ms);
            }
            true
        })
    };
    let mut short = load("emergency-stop").unwrap();
    open_for(0.142)(&mut short);
    let seen = verdict(&short);
    assert_eq!(seen.verdict, "pass", "{:?}", seen.why);
    let off = seen.faults[0].drive_off_after_injection_ticks.unwrap();
    assert!(off <= 3 + 1 + BLOCKS, "{off}");
    does_not_trip("emergency-stop", |scenario| {
        open_for(0.136)(scenario);
        // Nothing to clear, and no second start.
        scenario.events.retain(|timed| timed.at_s < 16.0);
    });
    // The contacts bounce when they close, the last time until 0.7 ms before the fault is cleared at 18 s: nothing
    // trips after.
    let bounces = opens_again(&[17.0005, 17.002, 17.01, 17.9990]);
    let goes_on = verdict(&bounces);
    assert_eq!(goes_on.verdict, "pass", "{:?}", goes_on.why);
    // Until 0.2 ms before it: the fault is not cleared.
    let mut refused = opens_again(&[17.9995]);
    refused.expect.final_state = Some(State::Fault);
    let refused = verdict(&refused);
    assert_eq!(refused.verdict, "pass", "{:?}", refused.why);
    // And after it: another fault.
    let mut another = opens_again(&[18.0010]);
    another.expect.faults = vec![Fault::EmergencyStop; 2];
    another.expect.final_state = Some(State::Fault);
    let another = verdict(&another);
    assert_eq!(another.verdict, "pass", "{:?}", another.why);
}

#[test]
fn over_force() {
    trips("over-force", None);
    // The blow of this push, at this phase of the drive, is 360 N; 386 N trip.
    does_not_trip(
        "over-force",
        each(|act| {
            if let ScenarioAct::Push { speed_m_per_s } = act {
                *speed_m_per_s = 0.245;
            }
            true
        }),
    );
}

#[test]
fn over_travel() {
    trips("over-travel", None);
    // The hammer goes to 9.4 mm; 10 mm trip.
    does_not_trip(
        "over-travel",
        each(|act| {
            if let ScenarioAct::Push { speed_m_per_s } = act {
                *speed_m_per_s = -0.1;
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
    // A drive period is 5458 ticks; the slowest drive allowed would have 36630.
    trips("sensor-frozen", Some(5500 + BLOCKS));
    does_not_trip("sensor-frozen", for_ticks(5000.0));
}

#[test]
fn sensor_out_of_family() {
    // Six contacts in a row, read as less than 0.4 of themselves.
    trips("sensor-out-of-family", Some(6 * 5500 + BLOCKS));
    // 0.75 of the momentum trips.
    does_not_trip(
        "sensor-out-of-family",
        each(|act| {
            if let ScenarioAct::SensorFault(how) = act {
                how.times = Some(0.8);
            }
            true
        }),
    );
}

/// The surface begins to come back, as slowly, this long after it began to go. (Within 0.2 s it throws a hammer that is on its way, or
/// not.)
fn back_after(seconds: f64) -> impl Fn(&mut Scenario) {
    move |scenario| {
        let mut back = vec![];
        for timed in &scenario.events {
            let mut back_again = timed.clone();
            if let ScenarioAct::Drift { gap_offset_mm, .. } = &mut back_again.act {
                *gap_offset_mm = -*gap_offset_mm;
                back_again.at_s += seconds;
                back.push(back_again);
            }
        }
        scenario.events.extend(back);
    }
}

#[test]
fn no_contact() {
    trips("no-contact", None);
    // 4.7 s without a contact; 5 s trip.
    does_not_trip("no-contact", back_after(4.4));
}

#[test]
fn regime_lost() {
    trips("regime-lost", None);
    // 16 s without a contact, and two until 1/1 is regained after; 20 s trip.
    does_not_trip("regime-lost", back_after(16.0));
}

fn two_blocks(scenario: &mut Scenario) {
    each(|act| {
        if let ScenarioAct::Overrun { blocks, .. } | ScenarioAct::LostBlock { blocks, .. } = act {
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
    // Heard again 1.9 s after it was last heard, half a second before it fell silent.
    does_not_trip("link-timeout", |scenario| {
        scenario.events.push(Timed {
            at_s: 16.4,
            act: ScenarioAct::Link {},
        });
    });
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
        if let ScenarioAct::Reset { cause } = &mut timed.act {
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
fn reset_while_driving() {
    born_faulty("reset-while-driving");
}

#[test]
fn crash() {
    born_faulty("crash");
}

#[test]
fn board_unfit() {
    born_faulty("board-unfit");
}

#[test]
fn not_off() {
    let verdict = crate::builtin::verdict(&load("not-off").unwrap());
    assert_eq!(verdict.verdict, "pass", "{:?}", verdict.why);
    let [stopped, found] = &verdict.faults[..] else {
        panic!("{:?}", verdict.faults);
    };
    assert_eq!((stopped.name, found.name), ("emergency-stop", "not-off"));
    // A window in which the cart may come to rest, and one that shows that it does not.
    let seconds = found.at_s - stopped.at_s;
    println!("not-off: {seconds} s after the emergency stop");
    assert!((1.0..2.3).contains(&seconds), "{seconds}");
    // The enable line obeys, and the cart comes to rest.
    let mut obeys = load("not-off").unwrap();
    obeys
        .events
        .retain(|timed| !matches!(timed.act, ScenarioAct::StuckDrive { .. }));
    obeys.expect.faults = vec![Fault::EmergencyStop];
    let verdict = crate::builtin::verdict(&obeys);
    assert_eq!(verdict.verdict, "pass", "{:?}", verdict.why);
}
