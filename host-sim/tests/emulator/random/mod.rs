//! Random rigs, beliefs, sensors, drives and mishaps, judged by the plant's truth: whatever happens and whatever the
//! sensors say, true force, true cart amplitude and true travel of the hammer on the cart beyond 110 % of a trip level
//! switch the drive off in time, nothing that is not a number comes out, and a stop is obeyed.
//!
//! A scenario is its number. `RANDOM_CASES=5000` runs more of them, `RANDOM_FIRST=100000` others, and
//! `RANDOM_DRAWS=reversed,supply` (or `all`) draws from these kinds instead of those that pass. What fails is told with its
//! number and with the events that it takes.
//!
//!     RANDOM_CASES=5000 cargo test -p host-sim --test emulator random

mod draw;
mod lies;
mod watch;

use std::env;

use emulator::local::Local;
use emulator::log::{Header, LogReader, Logs};
use emulator::run::run;
use emulator::scenario::Scenario;
use emulator::under_test::FixedFrequency;
use host_sim::progress::ProgressLine;
use host_sim::replay::replay;
use rayon::prelude::*;
use shared::control::{BootInfo, State};

use draw::Kind;
use watch::Watch;

/// Scenarios run where the environment does not say: with `LONG_CHECKS`, and without.
const CASES: (u64, u64) = (100, 30);

/// Draws with which the controller fails today: holes that are known and not mended yet. A kind moves from here to
/// [`MENDED`] with the mend that closes it.
pub const OPEN_HOLES: &[Kind] = &[];

/// Draws with which every scenario must pass.
pub const MENDED: &[Kind] = Kind::ALL;

fn asked<T: std::str::FromStr>(key: &str, otherwise: T) -> T {
    let value = env::var(key).ok();
    value.and_then(|v| v.parse().ok()).unwrap_or(otherwise)
}

fn kinds() -> Vec<Kind> {
    match env::var("RANDOM_DRAWS").as_deref() {
        Err(_) => MENDED.to_vec(),
        Ok("all") => Kind::ALL.to_vec(),
        Ok("holes") => OPEN_HOLES.to_vec(),
        Ok(names) => names
            .split(',')
            .map(|name| {
                let known = Kind::ALL.iter().find(|kind| kind.name() == name);
                *known.unwrap_or_else(|| panic!("no draw is called {name}"))
            })
            .collect(),
    }
}

/// One scenario in so many is also logged, and its log replayed.
const LOGGED: u64 = 9;

/// At least one in so many must be in Hold until its end: Hold, too, is to be judged.
const HELD_ONE_IN: u64 = 20;

/// What came of a run.
struct Outcome {
    /// What is wrong, if anything is.
    wrong: Option<String>,
    /// Whether it was in Hold until the stop at its end.
    held: bool,
}

fn wrong(scenario: &Scenario, logged: bool) -> Option<String> {
    outcome(scenario, logged).wrong
}

fn outcome(scenario: &Scenario, logged: bool) -> Outcome {
    let mut control = Local::new(&scenario.settings).unwrap();
    let mut watch = Watch::new(scenario);
    let summary = if logged {
        let dir = tempfile::tempdir().unwrap();
        let mut logs = Logs::create(dir.path(), "run", &header(scenario)).unwrap();
        let summary = run(scenario, &mut control, &mut (&mut watch, &mut logs)).unwrap();
        let paths = logs.finish().unwrap();
        let mut log = LogReader::open(&paths[0]).unwrap();
        let replayed = replay(&mut log, &ProgressLine::new("", 0, true)).unwrap();
        if let Some(difference) = replayed.difference {
            watch.wrong = Some(format!("the replay differs: {difference:?}"));
        }
        summary
    } else {
        run(scenario, &mut control, &mut watch).unwrap()
    };
    let last = summary.final_state();
    let stuck = !matches!(last, State::Idle | State::Fault);
    Outcome {
        wrong: watch
            .wrong
            .or_else(|| stuck.then(|| format!("stuck in {last:?}"))),
        held: watch.held,
    }
}

fn header(scenario: &Scenario) -> Header {
    Header {
        source: "emulator".into(),
        settings: scenario.settings,
        birth: BootInfo::STORED,
        block_ticks: scenario.block_ticks as u32,
        scenario: None,
        made_from: None,
    }
}

/// `scenario` without the events that it can do without and still fail.
fn smallest(mut scenario: Scenario, logged: bool) -> Scenario {
    let mut k = 0;
    while k < scenario.events.len() {
        let mut without = scenario.clone();
        without.events.remove(k);
        if wrong(&without, logged).is_some() {
            scenario = without;
        } else {
            k += 1;
        }
    }
    scenario
}

/// A failed scenario in words.
fn told(number: u64, kinds: &[Kind]) -> String {
    let logged = number.is_multiple_of(LOGGED);
    let small = smallest(draw::scenario(number, kinds), logged);
    let why = wrong(&small, logged).unwrap_or_default();
    let mut text = format!("number {number}: {why}\n");
    for event in &small.events {
        text += &format!("  {:.4} s  {}\n", event.at_s, event.act.text());
    }
    text + &format!(
        "  {:?}, {:?}, trips {:?}\n",
        small.drive(),
        small.mounting,
        small.settings.trips
    )
}

#[test]
fn whatever_happens_the_drive_goes_off_in_time() {
    let kinds = kinds();
    let first: u64 = asked("RANDOM_FIRST", 0);
    let long = env::var_os("LONG_CHECKS").is_some();
    let cases: u64 = asked("RANDOM_CASES", if long { CASES.0 } else { CASES.1 });
    let outcomes: Vec<(u64, Outcome)> = (first..first + cases)
        .into_par_iter()
        .map(|number| {
            let scenario = draw::scenario(number, &kinds);
            (number, outcome(&scenario, number.is_multiple_of(LOGGED)))
        })
        .collect();
    let failed: Vec<u64> = outcomes
        .iter()
        .filter(|(_, outcome)| outcome.wrong.is_some())
        .map(|(number, _)| *number)
        .collect();
    let held = outcomes.iter().filter(|(_, outcome)| outcome.held).count();
    println!("{held} of {cases} were in Hold until their end");
    let all_kinds = env::var("RANDOM_DRAWS").is_err();
    let enough = !all_kinds || held as u64 >= cases / HELD_ONE_IN;
    assert!(
        enough,
        "only {held} of {cases} were in Hold until their end"
    );
    let shown: Vec<_> = failed.iter().take(8).map(|n| told(*n, &kinds)).collect();
    assert!(
        failed.is_empty(),
        "{} of {cases} fail: {failed:?}\n{}",
        failed.len(),
        shown.join("")
    );
}

#[test]
fn every_kind_of_draw_is_mended_or_an_open_hole() {
    for kind in Kind::ALL {
        let mended = MENDED.contains(kind);
        assert_ne!(mended, OPEN_HOLES.contains(kind), "{}", kind.name());
        let text = draw::scenario(1, &[*kind]);
        assert!(!text.events.is_empty(), "{}", kind.name());
    }
}

/// The judge sees what is wrong: a controller that watches nothing but the emergency chain fails.
#[test]
fn a_controller_that_watches_nothing_is_found_out() {
    let short = |number: &u64| number % draw::LONG != draw::LONG - 1;
    let numbers: Vec<u64> = (0..40).filter(short).collect();
    let tried = numbers.len();
    let found = numbers.into_par_iter().filter(|number| {
        let kinds = [Kind::ByHand, Kind::Armature];
        let scenario = draw::scenario(*number, &kinds);
        let hz = 2.0 * scenario.true_rig.natural_frequency_hz();
        let mut control = FixedFrequency::new(scenario.settings, hz);
        let mut watch = Watch::new(&scenario);
        run(&scenario, &mut control, &mut watch).unwrap();
        watch.wrong.is_some_and(|why| why.contains("true"))
    });
    let found = found.count();
    println!("{found} of {tried}");
    assert!(10 * found >= tried, "{found} of {tried}");
}

/// Commands before and after resets within one block of 32 ticks, in every order of four.
#[test]
fn a_log_replays_whatever_the_order_of_inputs_within_a_block() {
    use emulator::scenario::{ScenarioAct, StartMode, Timed, parse};
    use emulator::under_test::Reset;

    let text = "duration_s = 3.0\nblock_ticks = 32\n[true_rig]\npreset = \"wires\"\n[sensors]\nnoise_percent = 1.0\n";
    let acts = [
        ScenarioAct::ClearFault {},
        ScenarioAct::Reset {
            cause: Reset::Watchdog,
        },
        ScenarioAct::Start {
            mode: StartMode::Automatic,
        },
        ScenarioAct::Reset {
            cause: Reset::BrownOut,
        },
    ];
    let mut order: Vec<usize> = (0..acts.len()).collect();
    let mut tried = 0;
    loop {
        let mut scenario = parse("orders", text, "orders").unwrap();
        let at = |at_s: f64, act: ScenarioAct| Timed { at_s, act };
        let start = ScenarioAct::Start {
            mode: StartMode::Manual,
        };
        let mut events = vec![at(0.1, start.clone())];
        // A fault stands when the block comes.
        events.push(at(1.2, ScenarioAct::EmergencyStop { for_s: Some(0.1) }));
        let orders = order.iter().enumerate();
        events.extend(orders.map(|(k, i)| at(2.0 + 5e-5 * k as f64, acts[*i].clone())));
        events.push(at(2.2, start));
        scenario.events = events;
        assert_eq!(wrong_replay(&scenario), None, "{order:?}");
        tried += 1;
        // The next permutation.
        let Some(i) = (1..order.len()).rev().find(|i| order[i - 1] < order[*i]) else {
            break;
        };
        let j = (i..order.len()).rev().find(|j| order[*j] > order[i - 1]);
        order.swap(i - 1, j.unwrap_or(i));
        order[i..].reverse();
    }
    assert_eq!(tried, 24);
}

fn wrong_replay(scenario: &Scenario) -> Option<String> {
    wrong(scenario, true).filter(|why| why.contains("replay"))
}
