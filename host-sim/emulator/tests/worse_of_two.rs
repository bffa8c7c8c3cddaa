//! A sensor that reads a little too little trips nothing. The limits hold all the same, by the plant's truth: they go by the
//! worse of two measurements that contradict each other. A healthy rig uses them fully, but for the 3 and 8 % that are left by hand.

use emulator::local::Local;
use emulator::record::{RunEvent, RunEventKind, RunObserver, TickRow, TrueContact};
use emulator::run::run;
use emulator::scenario::parse;
use rayon::prelude::*;
use shared::fault::Fault;

/// From here on the limits have settled, s.
const SETTLED_S: f64 = 40.0;
const END_S: f64 = 55.0;

/// What truly happened with the drive on, once settled.
#[derive(Debug, Default)]
struct Truth {
    force_n: f64,
    travel_mm: f64,
    /// Largest displacement of the hammer relative to the cart until the limits have settled, mm.
    first_travel_mm: f64,
    cart_mm: f64,
    faults: Vec<Fault>,
    is_on: bool,
}

impl RunObserver for Truth {
    fn tick(&mut self, row: &TickRow) {
        let travel_mm = (row.hammer_m - row.cart_m).abs() * 1e3;
        self.is_on = row.output.enable && row.time_s > SETTLED_S;
        if row.output.enable && row.time_s <= SETTLED_S {
            self.first_travel_mm = self.first_travel_mm.max(travel_mm);
        }
        if self.is_on {
            self.travel_mm = self.travel_mm.max(travel_mm);
            self.cart_mm = self.cart_mm.max(row.cart_m.abs() * 1e3);
        }
    }
    fn contact(&mut self, contact: &TrueContact) {
        if self.is_on {
            self.force_n = self.force_n.max(contact.peak_force_n);
        }
    }
    fn event(&mut self, event: &RunEvent) {
        if let RunEventKind::Fault { fault, .. } = event.what {
            self.faults.push(fault);
        }
    }
}

/// A start, by itself or by hand.
const ITSELF: &str = "[[events]]\nat_s = 0.5\nkind = \"start\"\n";
const BY_HAND: &str = "[[events]]\nat_s = 0.5\nkind = \"start\"\nmode = \"manual\"\n\
                       [[events]]\nat_s = 4.0\nkind = \"set-point\"\nfrequency_hz = 3.66\namplitude_mm = 0.89\n";
/// From the start on, and in the midst of it.
const FIRST: f64 = 0.1;
const LATER: f64 = 20.0;

/// Gains of sensors from `at_s` on.
fn gains(at_s: f64, gains: &[(&str, f64)]) -> String {
    let gain = |(sensor, times): &(&str, f64)| {
        format!(
            "[[events]]\nat_s = {at_s:?}\nkind = \"sensor-fault\"\nsensor = \"{sensor}\"\nfault = \"gain\"\ntimes = {times:?}\n"
        )
    };
    gains.iter().map(gain).collect()
}

fn truth(tables: &str) -> Truth {
    let text = format!(
        "duration_s = {END_S:?}\nseed = 7\n[true_rig]\npreset = \"wires\"\n[sensors]\nnoise_percent = 1.0\n{tables}"
    );
    let scenario = parse("worse", &text, "worse").unwrap();
    let mut truth = Truth::default();
    let mut control = Local::new(&scenario.settings).unwrap();
    run(&scenario, &mut control, &mut truth).unwrap();
    truth
}

/// How it is started, from when on sensors lie, and their gains.
type Case<'a> = (&'a str, f64, &'a [(&'a str, f64)]);

/// Checks that `share` (of a limit, truly) is at most 110 % in every case, from 90 % on where the sensors are healthy, and
/// that nothing trips.
fn check(tables: &str, cases: &[Case], share: impl Fn(&Truth) -> f64 + Sync) {
    let wrong: Vec<String> = cases
        .par_iter()
        .filter_map(|&(start, at_s, lies)| {
            let truth = truth(&format!("{tables}{start}{}", gains(at_s, lies)));
            let share = share(&truth);
            let least = if lies.is_empty() { 0.9 } else { 0.85 };
            let holds = (least..=1.1).contains(&share) && truth.faults.is_empty();
            (!holds).then(|| format!("{share:.3} {at_s} {lies:?}: {truth:?}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_force_limit_is_not_passed_by_a_force_that_reads_less() {
    // It was 119 % with a gain of 0.8, 120 % by hand, 122 % of a sensor that becomes weak in Hold, 112 % of two that lie
    // alike.
    check(
        "[limits]\nforce_n = 60.0\n",
        &[
            (ITSELF, FIRST, &[]),
            (BY_HAND, FIRST, &[]),
            (ITSELF, FIRST, &[("force", 0.8)]),
            (BY_HAND, FIRST, &[("force", 0.8)]),
            (ITSELF, LATER, &[("force", 0.78)]),
            (BY_HAND, LATER, &[("force", 0.78)]),
            (ITSELF, FIRST, &[("force", 0.9)]),
            // Two that lie alike.
            (ITSELF, FIRST, &[("force", 0.86), ("hammer", 0.86)]),
        ],
        |truth| truth.force_n / 60.0,
    );
}

#[test]
fn a_force_that_falls_in_hold_gives_nothing_back_that_its_limit_took() {
    // It was 112 %, 109 % and 106 % of the limit, while readings were 4 % above the true peak (the limit then acted at 94 %
    // of it, now at 98 %).
    for (falls_s, times, faults) in [
        (41.0, 0.6, &[Fault::SensorOutOfFamily][..]),
        (42.0, 0.7, &[Fault::SensorOutOfFamily]),
        (42.0, 0.8, &[]),
    ] {
        let lies = gains(falls_s, &[("force", times)]);
        let truth = truth(&format!("[limits]\nforce_n = 65.0\n{ITSELF}{lies}"));
        let share = truth.force_n / 65.0;
        assert!((0.9..1.06).contains(&share), "{times}: {share:.3}");
        assert_eq!(truth.faults, faults);
    }
}

#[test]
fn no_harder_than_asked_by_either_measurement() {
    // It was 121 % of the force wanted.
    check(
        "[aim]\nforce_n = 60.0\n",
        &[(ITSELF, FIRST, &[]), (ITSELF, FIRST, &[("force", 0.8)])],
        |truth| truth.force_n / 60.0,
    );
}

#[test]
fn the_travel_limit_is_not_passed_by_a_hammer_that_reads_less() {
    // It was 113 %.
    check(
        "[limits]\ntravel_mm = 3.4\n",
        &[
            (ITSELF, FIRST, &[]),
            (ITSELF, FIRST, &[("hammer", 0.85)]),
            (ITSELF, LATER, &[("hammer", 0.85)]),
            (BY_HAND, LATER, &[("hammer", 0.88)]),
        ],
        |truth| truth.travel_mm / 3.4,
    );
}

/// A shaker whose loop makes more of its command than asked.
const EAGER: &str = "[shaker]\nloop_hz = 9.0\nloop_damping_ratio = 0.2\nfeed_forward = 0.0\n";

#[test]
fn the_amplitude_limit_is_not_passed_by_a_cart_that_reads_less() {
    // It was 121 % and 118 %. Blows shake the cart of such a soft loop by 4 %.
    check(
        &format!("[limits]\namplitude_mm = 0.9\n{EAGER}"),
        &[
            (ITSELF, FIRST, &[]),
            (ITSELF, FIRST, &[("cart", 0.85)]),
            (ITSELF, LATER, &[("cart", 0.87)]),
        ],
        |truth| truth.cart_mm / 0.9,
    );
}

#[test]
fn a_trip_level_of_a_cart_that_reads_less_trips_by_the_truth() {
    // 1.09 mm with a trip level of 0.95 mm.
    let tables = format!("[limits]\namplitude_mm = 0.9\n[trips]\ncart_mm = 0.95\n{EAGER}{ITSELF}");
    let found = truth(&(tables.clone() + &gains(FIRST, &[("cart", 0.85)])));
    assert_eq!(found.faults, [Fault::OverTravel]);
    assert_eq!(truth(&tables).faults, []);
}

#[test]
fn a_trip_level_is_not_passed_by_a_hammer_whose_zero_is_off() {
    // A push makes the travel 3.7 mm. With a zero that was 1.2 mm off, such a travel tripped nothing.
    let push = "[[events]]\nat_s = 15.0\nkind = \"push\"\nspeed_m_per_s = -0.014\n";
    let with = |trip_mm: f64, offset_um: f64| {
        truth(&format!(
            "hammer_offset_um = {offset_um:?}\n[limits]\ntravel_mm = 3.4\n[trips]\ntravel_mm = {trip_mm:?}\n{BY_HAND}{push}"
        ))
    };
    for offset_um in [0.0, 1200.0, -1200.0] {
        let faults = with(3.6, offset_um).faults;
        assert_eq!(faults, [Fault::OverTravel], "{offset_um}");
    }
}

#[test]
fn a_healthy_rig_on_its_way_to_a_set_point_is_not_doubted() {
    // Contacts too weak to be seen hid in the flights at low frequencies: the hammer seemed to read a tenth less. A travel
    // of 4.5 mm is reached.
    let tables = "[limits]\ntravel_mm = 5.05\n[trips]\ntravel_mm = 5.1\n";
    let truth = truth(&format!("{tables}{BY_HAND}"));
    assert_eq!(truth.faults, []);
    assert!(truth.travel_mm > 4.4, "{}", truth.travel_mm);
}

#[test]
fn a_travel_limit_is_kept_from_the_first_contact_on_and_while_the_hammer_s_zero_drifts() {
    // It was 126 % in the first second, and 135 % after a minute of drift.
    let drift = "[[events]]\nat_s = 0.1\nkind = \"sensor-fault\"\nsensor = \"hammer\"\nfault = \"offset-drift\"\n\
                 drift_um_per_s = ";
    // A surface that seems to recede may be a zero that moves: such a travel may be 7 % beyond its limit, and a little more.
    for (drift, most, least) in [
        (String::new(), 1.05, 0.9),
        (format!("{drift}20.0\n"), 1.1, 0.8),
    ] {
        let truth = truth(&format!("[limits]\ntravel_mm = 3.4\n{ITSELF}{drift}"));
        let (first, settled) = (truth.first_travel_mm / 3.4, truth.travel_mm / 3.4);
        assert!(first < most, "{first}");
        assert!((least..1.1).contains(&settled), "{settled}");
        assert_eq!(truth.faults, []);
    }
}
