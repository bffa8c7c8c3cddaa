//! Who must be there, in scenarios: a program that is heard, and somebody who acknowledges an emergency stop. Each with a
//! twin just below the threshold.

use emulator::scenario::{Scenario, parse};
use emulator::verdict::Verdict;

use crate::builtin::verdict;

/// Wires started at 1 s, with the last and `operator` of a scenario.
fn scenario(operator: &str, events: &str, expect: &str) -> Scenario {
    let text = format!(
        "duration_s = 14.0\nseed = 3\n[true_rig]\npreset = \"wires\"\n[sensors]\nnoise_percent = 1.0\n[operator]\n{operator}\n[[events]]\nat_s = 1.0\nkind = \"start\"\n{events}[expect]\n{expect}\n"
    );
    parse("operator", &text, "operator.toml").unwrap()
}

fn at(at_s: f64, kind: &str) -> String {
    format!("[[events]]\nat_s = {at_s}\nkind = \"{kind}\"\n")
}

fn passes(scenario: &Scenario) -> Verdict {
    let verdict = verdict(scenario);
    assert_eq!(verdict.verdict, "pass", "{:?}", verdict.why);
    verdict
}

const LOST: &str = "final_state = \"fault\"\nfaults = [\"link-timeout\"]";

#[test]
fn with_a_heartbeat_automatic_mode_ends_when_nobody_is_heard() {
    // Signs of life come twice a second, the last at 7.7 s; the timeout is 2 s.
    let link = at(1.2, "link") + &at(8.1, "link-loss");
    let lost = passes(&scenario("heartbeat = true", &link, LOST));
    let off = lost.faults[0].drive_off_after_injection_ticks.unwrap();
    assert!((32_000..=32_020).contains(&off), "{off}");
    // Heard again 0.1 s before the timeout, or never needed: nothing trips.
    let again = link + &at(9.6, "link");
    passes(&scenario("heartbeat = true", &again, ""));
    passes(&scenario("", "", ""));
}

#[test]
fn with_a_heartbeat_a_start_with_nobody_there_never_drives() {
    let alone = passes(&scenario("heartbeat = true", "", LOST));
    assert_eq!(alone.driven_with_fault_s, 0.0);
    assert_eq!(alone.largest_force_n, 0.0);
}

/// The chain is open from 5 s to 6 s; then the fault is cleared and the drive started again.
fn again(acknowledged_s: Option<f64>) -> String {
    let stop = "[[events]]\nat_s = 5.0\nkind = \"emergency-stop\"\nfor_s = 1.0\n".to_owned();
    let press = acknowledged_s.map_or(String::new(), |s| at(s, "acknowledge"));
    stop + &press + &at(8.0, "clear-fault") + &at(8.1, "start")
}

#[test]
fn an_emergency_stop_is_cleared_only_after_it_was_acknowledged() {
    let required = "acknowledge = true";
    let stays = "final_state = \"fault\"\nfaults = [\"emergency-stop\"]";
    let goes_on = "faults = [\"emergency-stop\"]";
    let driving = |verdict: Verdict| !["idle", "fault"].contains(&verdict.final_state);
    // Never, while the chain is open, and 19 ms after it has closed, of 20: refused.
    for pressed in [None, Some(5.5), Some(6.019)] {
        passes(&scenario(required, &again(pressed), stays));
    }
    // 21 ms after it, or not required.
    assert!(driving(passes(&scenario(
        required,
        &again(Some(6.021)),
        goes_on
    ))));
    assert!(driving(passes(&scenario("", &again(None), goes_on))));
}
