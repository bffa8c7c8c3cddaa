//! What a scenario may expect, judged by the plant's truth: each expectation met, and missed by a little.

use emulator::optimum::Optimum;
use emulator::run::run;
use emulator::scenario::{Scenario, parse};
use emulator::summary::RunSummary;
use emulator::under_test::FixedFrequency;
use emulator::verdict::{Best, Verdict, judge_by};

/// Wires at 3.66 Hz by hand from 1 s to 12 s, with `more` of a scenario.
fn scenario(more: &str) -> Scenario {
    let text = format!(
        "duration_s = 12.0\n[true_rig]\npreset = \"wires\"\n[[events]]\nat_s = 1.0\nkind = \"start\"\nmode = \"manual\"\n{more}"
    );
    parse("by-hand", &text, "by-hand.toml").unwrap()
}

fn ran(scenario: &Scenario) -> RunSummary {
    let mut control = FixedFrequency::new(scenario.settings, 3.66);
    run(scenario, &mut control, &mut ()).unwrap()
}

/// The verdict if the optimum were `force_n`, with the expectations `expect` of TOML.
fn verdict(more: &str, expect: &str, force_n: f64) -> Verdict {
    let scenario = scenario(&format!("{more}[expect]\n{expect}\n"));
    let best = Some(Optimum {
        frequency_hz: 3.66,
        force_n,
    });
    let best = Best {
        held: best,
        asked: best,
        prescribed: best,
    };
    judge_by(&scenario, &ran(&scenario), best)
}

#[test]
fn each_number_passes_just_beyond_what_was_and_fails_just_short_of_it() {
    let plain = verdict("", "", 90.0);
    assert_eq!(plain.verdict, "pass", "{:?}", plain.why);
    let share = plain.share_from_start.unwrap();
    // Ramped up in a second, and a few periods until it strikes at each.
    assert!((0.5..1.02).contains(&share), "{share}");
    assert!(plain.largest_force_n > 50.0 && plain.largest_cart_mm > 0.3);
    for (key, value, upper) in [
        ("max_true_force_n", plain.largest_force_n, true),
        ("max_true_cart_mm", plain.largest_cart_mm, true),
        ("min_share_from_start", share, false),
    ] {
        for (part, passes) in [(1.001, upper), (0.999, !upper)] {
            let judged = verdict("", &format!("{key} = {:?}", part * value), 90.0);
            assert_eq!(judged.verdict == "pass", passes, "{key}: {:?}", judged.why);
            assert_eq!(judged.why.len(), usize::from(!passes), "{:?}", judged.why);
        }
    }
}

#[test]
fn a_drive_that_stays_on_with_a_dead_sensor_is_counted_and_one_that_goes_off_is_not() {
    let broken = "[[events]]\nat_s = 5.0\nkind = \"sensor-fault\"\nsensor = \"force\"\nfault = \"open\"\nfor_s = 2.5\n";
    let judged = verdict(broken, "max_driven_with_fault_s = 2.4", 90.0);
    assert!(
        (judged.driven_with_fault_s - 2.5).abs() < 1e-3,
        "{judged:?}"
    );
    assert_eq!(judged.verdict, "fail");
    assert_eq!(
        verdict(broken, "max_driven_with_fault_s = 2.51", 90.0).verdict,
        "pass"
    );
    // The controller of this test obeys the chain a block later.
    let chain = "[[events]]\nat_s = 5.0\nkind = \"emergency-stop\"\nfor_s = 2.5\n";
    let judged = verdict(chain, "max_driven_with_fault_s = 0.002", 90.0);
    assert_eq!(judged.verdict, "pass", "{:?}", judged.why);
    assert!(judged.driven_with_fault_s > 0.0);
    // A silence counts once the link has been in command.
    let link =
        "[[events]]\nat_s = 2.0\nkind = \"link\"\n[[events]]\nat_s = 9.0\nkind = \"link-loss\"\n";
    let judged = verdict(link, "", 90.0);
    assert!(
        (judged.driven_with_fault_s - 3.0).abs() < 1e-3,
        "{judged:?}"
    );
}

#[test]
fn time_without_drive_counts_until_a_stop_and_not_after_it() {
    let share = |more: &str| verdict(more, "", 90.0).share_from_start.unwrap();
    let whole = share("");
    let stopped = share("[[events]]\nat_s = 6.5\nkind = \"stop\"\n");
    let tripped = share("[[events]]\nat_s = 6.5\nkind = \"emergency-stop\"\n");
    // Half of the time without force; the first seconds weigh twice as much.
    assert!(
        (tripped / stopped - 0.5).abs() < 0.01,
        "{tripped} of {stopped}"
    );
    assert!(stopped > 0.9 * whole, "{stopped} of {whole}");
}

#[test]
fn more_force_than_there_can_be_fails_unless_it_is_expected() {
    use emulator::record::{TickRow, TrueContact};
    use shared::control::{Controller, State};
    // Ten seconds of Hold at 4 Hz, each blow 103 N where 100 are the optimum.
    let judged = |expect: &str| {
        let scenario = scenario(&format!("[expect]\n{expect}\n"));
        let mut summary = RunSummary::new(&scenario);
        let mut status = Controller::new(&scenario.settings, &Default::default())
            .unwrap()
            .status();
        status.state = State::Hold;
        summary.started(0.0);
        summary.block(0, &status);
        for tick in 0..200_000_u64 {
            if tick % 5000 == 2500 {
                summary.contact(&TrueContact {
                    peak_force_n: 103.0,
                    ..TrueContact::default()
                });
            }
            summary.tick(&TickRow {
                tick,
                time_s: tick as f64 * 5e-5,
                frame: Default::default(),
                output: shared::io::Output {
                    enable: true,
                    frequency_hz: 4.0,
                    ..shared::io::Output::SAFE
                },
                true_force_n: 0.0,
                hammer_m: 0.0,
                cart_m: 0.0,
                powered: true,
                faulty: false,
            });
        }
        let best = Some(Optimum {
            frequency_hz: 4.0,
            force_n: 100.0,
        });
        let best = Best {
            held: best,
            ..Best::default()
        };
        judge_by(&scenario, &summary, best)
    };
    let plain = judged("");
    assert!((plain.force_share.unwrap() - 1.03).abs() < 1e-9);
    assert_eq!(plain.verdict, "fail");
    assert_eq!(judged("max_force_share = 1.04").verdict, "pass");
    assert_eq!(judged("max_force_share = 1.029").verdict, "fail");
}
