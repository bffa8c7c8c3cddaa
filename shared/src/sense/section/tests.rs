//! The measured regime on made-up periods.

use super::*;

const TICKS: u32 = 1_600;

/// Noise between −1 and 1.
struct Dice(u32);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
    }
}

/// Runs periods, each a list of contacts (phase in turns, impulse) and a displacement on the section;
/// answers after each.
fn run(
    section: &mut SensedSection,
    from: u32,
    periods: impl IntoIterator<Item = Drawn>,
) -> std::vec::Vec<SensedRegime> {
    let mut answers = std::vec::Vec::new();
    for (cycle, (contacts, displacement)) in (from..).zip(periods) {
        section.strobe(cycle, displacement, 0.0);
        for tick in 0..TICKS {
            let phase = tick * (u32::MAX / TICKS);
            section.tick(cycle, phase);
            for (turns, impulse) in &contacts {
                if (turns * TICKS as f32) as u32 == tick {
                    let onset = (turns * 4_294_967_296.0) as u32;
                    section.onset(cycle, onset);
                    section.impulse(cycle, onset, *impulse);
                }
            }
        }
        answers.push(section.measured());
    }
    answers
}

type Drawn = (std::vec::Vec<(f32, f32)>, f32);

/// `count` periods of a pattern with 2 % noise on impulses and 0.001 turns on onsets.
fn noisy(pattern: &[&[(f32, f32)]], count: usize, dice: &mut Dice) -> std::vec::Vec<Drawn> {
    let mut periods = std::vec![(std::vec::Vec::new(), 0.0); count];
    for (k, contacts) in pattern.iter().cycle().take(count).enumerate() {
        for (turns, impulse) in *contacts {
            let turns = turns + 0.001 * dice.roll();
            let impulse = impulse * (1.0 + 0.04 * dice.roll());
            // Before phase 0 is in the period before.
            if turns >= 0.0 {
                periods[k].0.push((turns, impulse));
            } else if k > 0 {
                periods[k - 1].0.push((turns + 1.0, impulse));
            }
        }
        periods[k].1 = 0.02 * dice.roll();
    }
    periods
}

fn settled(pattern: &[&[(f32, f32)]]) -> Regime {
    let mut section = SensedSection::default();
    let answers = run(&mut section, 7, noisy(pattern, 40, &mut Dice(3)));
    let last = answers[39];
    assert_eq!(last.periods, 16);
    assert!(
        answers[25..].iter().all(|a| a.regime == last.regime),
        "{answers:?}"
    );
    last.regime
}

#[test]
fn regimes_are_found() {
    assert!(settled(&[&[(0.3, 1.0)]]).is(1, 1));
    assert!(settled(&[&[(0.3, 1.0), (0.5, 0.2)]]).is(2, 1));
    assert!(settled(&[&[(0.3, 1.1)], &[(0.3, 0.9)]]).is(2, 2));
    assert!(settled(&[&[(0.305, 1.0)], &[(0.295, 1.0)]]).is(2, 2));
    assert!(settled(&[&[(0.3, 1.0)], &[]]).is(1, 2));
    assert!(settled(&[&[(0.3, 1.0)], &[], &[]]).is(1, 3));
    // Four silent periods between contacts are not yet silence.
    assert!(settled(&[&[(0.3, 1.0)], &[], &[], &[], &[]]).is(1, 5));
    assert!(settled(&[&[(0.3, 1.3)], &[(0.3, 0.9)], &[(0.3, 1.1)], &[(0.3, 0.7)]]).is(4, 4));
    assert_eq!(settled(&[&[]]), Regime::None);
}

#[test]
fn an_onset_on_the_cut_does_not_matter() {
    assert!(settled(&[&[(0.0, 1.0)]]).is(1, 1));
    assert!(settled(&[&[(0.5, 1.0)]]).is(1, 1));
    assert!(settled(&[&[(0.0, 1.15)], &[(0.0, 0.85)]]).is(2, 2));
}

#[test]
fn wandering_contacts_are_aperiodic() {
    let mut section = SensedSection::default();
    let mut dice = Dice(5);
    let periods = (0..40).map(|_| (std::vec![(0.4 + 0.1 * dice.roll(), 1.0)], dice.roll()));
    let answers = run(&mut section, 0, periods);
    assert_eq!(answers[39].regime, Regime::Aperiodic { impacts: 16 });
}

#[test]
fn one_missed_contact_changes_nothing_and_two_do() {
    let mut dice = Dice(3);
    let mut section = SensedSection::default();
    let mut periods = noisy(&[&[(0.3, 1.0)]], 60, &mut dice);
    periods[30].0.clear();
    let answers = run(&mut section, 0, periods.clone());
    assert!(
        answers[20..].iter().all(|a| a.regime.is(1, 1)),
        "{answers:?}"
    );
    periods[33].0.clear();
    let mut section = SensedSection::default();
    let answers = run(&mut section, 0, periods);
    assert!(!answers[35].regime.is(1, 1));
}

#[test]
fn a_change_is_reported_within_nine_periods_and_silence_within_five() {
    let mut section = SensedSection::default();
    let mut dice = Dice(3);
    run(&mut section, 0, noisy(&[&[(0.3, 1.0)]], 30, &mut dice));
    let answers = run(
        &mut section,
        30,
        noisy(&[&[(0.3, 1.2)], &[(0.3, 0.8)]], 30, &mut dice),
    );
    let first = answers.iter().position(|a| a.regime.is(2, 2)).unwrap();
    assert!(first <= 9, "{first}");
    assert!(answers[first..].iter().all(|a| a.regime.is(2, 2)));
    let answers = run(&mut section, 60, noisy(&[&[]], 30, &mut dice));
    let first = answers
        .iter()
        .position(|a| a.regime == Regime::None)
        .unwrap();
    assert!(first <= 5, "{first}");
}

#[test]
fn the_first_answer_after_a_change_of_frequency_needs_five_or_six_periods() {
    let mut section = SensedSection::default();
    let mut dice = Dice(3);
    run(&mut section, 0, noisy(&[&[(0.3, 1.0)]], 30, &mut dice));
    section.restart();
    let answers = run(&mut section, 30, noisy(&[&[(0.3, 1.0)]], 30, &mut dice));
    let first = answers.iter().position(|a| a.regime.is(1, 1)).unwrap();
    assert!(first <= 5, "{first}");
}

#[test]
fn silence_is_reported_once_it_is_three_periods_longer_than_any_before() {
    for n in [2, 3, 4] {
        let mut section = SensedSection::default();
        let mut dice = Dice(3);
        let mut pattern: [&[(f32, f32)]; 4] = [&[]; 4];
        pattern[0] = &[(0.3, 1.0)];
        let count = 10 * n;
        let answers = run(&mut section, 0, noisy(&pattern[..n], count, &mut dice));
        assert!(answers[count - 1].regime.is(1, n as u8));
        // n − 1 periods are silent already. An answer comes a period after what it rests on.
        let silence = noisy(&[&[]], 10, &mut dice);
        let answers = run(&mut section, count as u32, silence);
        let first = answers.iter().position(|a| a.regime == Regime::None);
        assert_eq!(first, Some(3), "1/{n}");
    }
}

#[test]
fn a_regime_of_n_is_not_claimed_before_three_times_n_periods() {
    let four: [&[(f32, f32)]; 4] = [&[(0.3, 1.3)], &[(0.3, 0.9)], &[(0.3, 1.1)], &[(0.3, 0.7)]];
    let two: [&[(f32, f32)]; 2] = [&[(0.3, 1.3)], &[(0.3, 0.7)]];
    for (pattern, n) in [(&four[..], 4), (&two[..], 2)] {
        let mut section = SensedSection::default();
        let answers = run(&mut section, 0, noisy(pattern, 30, &mut Dice(3)));
        let first = answers.iter().find(|a| a.regime.is(n, n as u8)).unwrap();
        assert_eq!(u16::from(first.periods), 3 * n);
    }
}

#[test]
fn an_onset_and_its_impulse_belong_to_the_period_of_the_onset() {
    let mut window = PeriodWindow::NEW;
    window.onset(6, 0.9);
    window.onset(7, 0.05);
    window.impulse(7, 2.0);
    window.impulse(6, 3.0);
    window.impulse(6, 0.5);
    window.close(6);
    // Period 6 is closed: what comes late for it is dropped, as period 8 has no contact yet.
    window.impulse(6, 9.0);
    window.close(7);
    window.onset(8, 0.5);
    window.close(8);
    let [eighth, seventh, sixth, ..] = window.entries;
    assert_eq!((window.count, window.near_cut()), (3, 1));
    assert_eq!((sixth.contacts, sixth.near_cut), (1, 0));
    assert_eq!(sixth.features, [3.5, 0.9, 0.0, 0.0]);
    assert_eq!((seventh.contacts, seventh.near_cut), (1, 1));
    assert_eq!(seventh.features, [2.0, 0.05, 0.0, 0.0]);
    assert_eq!(eighth.features, [0.0, 0.5, 0.0, 0.0]);
    for (turns, near) in [(0.0, 1), (0.07, 1), (0.09, 0), (0.91, 0), (0.93, 1)] {
        let mut window = PeriodWindow::NEW;
        window.onset(0, turns);
        window.close(0);
        assert_eq!(window.near_cut(), near, "{turns}");
    }
}

#[test]
fn only_whole_periods_are_entered_wherever_in_a_period_it_starts() {
    // One contact per period, at 0.3 turns; the first period is cut short at its beginning.
    for from in [0.01, 0.2, 0.26, 0.4, 0.51, 0.6, 0.74, 0.76, 0.9] {
        let entered = |section: &mut SensedSection| {
            for cycle in 10..16 {
                for tick in 0..TICKS {
                    if cycle == 10 && f64::from(tick) < from * f64::from(TICKS) {
                        continue;
                    }
                    section.tick(cycle, tick * (u32::MAX / TICKS));
                    if tick == 3 * TICKS / 10 {
                        section.onset(cycle, (0.3 * 4_294_967_296.0) as u32);
                    }
                }
            }
            [&section.at_zero, &section.at_half].map(|window| {
                let entries = &window.entries[..window.count];
                assert!(
                    entries.iter().all(|e| e.contacts == 1),
                    "{from}: {entries:?}"
                );
                window.count
            })
        };
        // Period 15 is still open. Cut at 0, periods 11 to 14 are whole; cut at a half, one more if the start lies before it.
        let before_half = usize::from(from < 0.5);
        let mut started_anew = SensedSection::default();
        started_anew.restart();
        assert_eq!(entered(&mut started_anew), [4, 4 + before_half], "{from}");
        // After a start, the observer does not know the cart for one period more.
        assert_eq!(
            entered(&mut SensedSection::default()),
            [3, 3 + before_half],
            "{from}"
        );
    }
}

#[test]
fn the_work_on_a_period_is_spread_over_many_ticks() {
    let mut section = SensedSection::default();
    section.at_zero.close(0);
    section.at_half.close(0);
    section.tick(0, 0);
    let (mut parts, mut last, mut pauses) = (0, 0, std::vec::Vec::new());
    for tick in 1..2_000_u32 {
        let before = (section.at_zero.next, section.at_half.next);
        section.tick(0, 0);
        if (section.at_zero.next, section.at_half.next) != before {
            parts += 1;
            pauses.push(tick - last);
            last = tick;
        }
    }
    // An answer takes 17 parts, and there are two windows.
    assert_eq!(parts, 2 * 17);
    assert!(
        pauses[1..].iter().all(|p| *p == u32::from(PAUSE) + 1),
        "{pauses:?}"
    );
}
