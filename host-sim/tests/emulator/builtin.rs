//! Every scenario that comes with the program, run with the controller in this process: each must come to what
//! it says it expects.

use emulator::local::Local;
use emulator::run::run;
use emulator::scenario::{BUILTIN, Scenario, load};
use emulator::summary::RunSummary;
use emulator::verdict::{Best, Verdict, judge, judge_by};

/// A run, unwatched.
pub fn ran(scenario: &Scenario) -> RunSummary {
    let mut control = Local::new(&scenario.settings).unwrap();
    run(scenario, &mut control, &mut ()).unwrap()
}

/// The verdict, the optimum left out where nothing asks for it.
pub fn verdict(scenario: &Scenario) -> Verdict {
    let summary = ran(scenario);
    let expect = &scenario.expect;
    let shares = [
        expect.min_force_share,
        expect.max_force_share,
        expect.min_share_from_start,
    ];
    if shares.iter().any(Option::is_some) {
        judge(scenario, &summary)
    } else {
        judge_by(scenario, &summary, Best::default())
    }
}

fn passes(name: &str) {
    let scenario = load(name).unwrap();
    let verdict = verdict(&scenario);
    println!("{verdict:#?}");
    assert_eq!(verdict.verdict, "pass", "{name}: {:?}", verdict.why);
}

macro_rules! scenarios {
    ($($test:ident: $name:literal),* $(,)?) => {
        $(
            #[test]
            fn $test() {
                passes($name);
            }
        )*

        /// Those that another file runs.
        #[test]
        fn none_is_forgotten() {
            let here = [$($name),*];
            let faults = super::faults::names();
            for (name, _) in BUILTIN {
                assert!(here.contains(&name) || faults.contains(&name), "{name}");
            }
        }
    };
}

scenarios! {
    field: "field",
    held_wires: "held-wires",
    held_beam_170: "held-beam-170",
    held_beam_150: "held-beam-150",
    held_beam_135: "held-beam-135",
    push: "push",
    push_stays: "push-stays",
    drift: "drift",
    softening: "softening",
    receding: "receding",
    drill: "drill",
    hardening: "hardening",
    dropouts: "dropouts",
    preload: "preload",
    force_wanted: "force-wanted",
    jump: "jump",
    sudden_softening: "sudden-softening",
    sudden_gap: "sudden-gap",
}

/// The filters that docs/wiring.md builds: the same for all three sensors, 4.9 kHz.
#[test]
fn the_wiring_pages_filters_hold_as_well() {
    let mut scenario = load("field").unwrap();
    scenario.sensors.force_filter_hz = 4_900.0;
    scenario.sensors.displacement_filter_hz = 4_900.0;
    let verdict = verdict(&scenario);
    assert_eq!(verdict.verdict, "pass", "{:?}", verdict.why);
}
