//! How well drive periods repeat after n.

use super::{FEWEST, LONGEST};

/// Features that describe a period.
pub const FEATURES: usize = 4;

/// One drive period of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Entry {
    pub contacts: u8,
    pub near_cut: u8,
    /// Impulse (N·s), first onset (turns after the cut), displacement (A0), rate (A0 Ω).
    pub features: [f32; FEATURES],
}

/// The scatter that one n leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SectionFit {
    /// Contact counts agree, with at most the allowed exception.
    pub consistent: bool,
    pub contacts: u16,
    /// Scatter within classes, squared, per degree of freedom.
    pub variance: [f32; FEATURES],
}

/// Sorts periods into n classes and measures what is left within them.
pub fn fit_of(entries: &[Entry], n: usize) -> SectionFit {
    // Steps by 0 would panic; this shows the compiler that there are none.
    let n = n.max(1);
    let mut fit = SectionFit::default();
    if entries.len() < 2 * n {
        return fit;
    }
    let (mut typical, mut total) = ([0_u8; LONGEST], 0_u16);
    for (class, typical) in typical.iter_mut().take(n).enumerate() {
        *typical = median(entries.iter().skip(class).step_by(n).map(|e| e.contacts));
        total += u16::from(*typical);
    }
    let mut classes = (0..n).cycle();
    let mut odd = None;
    let mut odds = 0;
    for (i, entry) in entries.iter().enumerate() {
        let class = classes.next().unwrap_or(0);
        if typical.get(class) != Some(&entry.contacts) {
            odds += 1;
            odd = Some(i);
        }
    }
    fit.consistent = odds == 0 || (odds == 1 && n <= 5 && entries.len() >= FEWEST.max(3 * n));
    fit.contacts = total;
    if fit.consistent {
        fit.variance = scatter(entries, n, &typical, odd);
    }
    fit
}

/// Variance within classes of every feature, the period `odd` and its successor (one newer) left out.
fn scatter(
    entries: &[Entry],
    n: usize,
    typical: &[u8; LONGEST],
    odd: Option<usize>,
) -> [f32; FEATURES] {
    let n = n.max(1);
    let counts = |i: usize| odd.is_none_or(|odd| i != odd && i + 1 != odd);
    let mut squares = [0.0_f32; FEATURES];
    let (mut freedom, mut impulse, mut struck) = ([0_i32; FEATURES], 0.0_f32, 0_i32);
    for (class, typical) in typical.iter().take(n).enumerate() {
        let members = || {
            let all = entries.iter().enumerate().skip(class).step_by(n);
            all.filter(|(i, _)| counts(*i)).map(|(_, entry)| entry)
        };
        let size = members().count();
        if size == 0 {
            continue;
        }
        let share = 1.0 / size as f32;
        for (feature, square) in squares.iter_mut().enumerate() {
            // A period without contact has neither impulse nor onset.
            if *typical == 0 && feature < 2 {
                continue;
            }
            let value = |entry: &Entry| entry.features.get(feature).copied().unwrap_or(0.0);
            let mean = members().map(value).sum::<f32>() * share;
            *square += members()
                .map(|entry| (value(entry) - mean) * (value(entry) - mean))
                .sum::<f32>();
            if let Some(freedom) = freedom.get_mut(feature) {
                *freedom += size as i32 - 1;
            }
            if feature == 0 {
                impulse += mean;
                struck += 1;
            }
        }
    }
    let scale = if impulse > 0.0 {
        struck as f32 / impulse
    } else {
        0.0
    };
    for ((feature, square), freedom) in squares.iter_mut().enumerate().zip(freedom) {
        *square /= freedom.max(1) as f32;
        if feature == 0 {
            *square *= scale * scale;
        }
    }
    squares
}

/// The lower median of at most [`WINDOW`](super::WINDOW) counts.
fn median(counts: impl Iterator<Item = u8> + Clone) -> u8 {
    let size = counts.clone().count();
    let below = |limit: u8| counts.clone().filter(|c| *c < limit).count();
    let fit = counts.clone().filter(|c| {
        let less = below(*c);
        let equal = counts.clone().filter(|other| other == c).count();
        2 * less < size + size % 2 && 2 * (less + equal) >= size
    });
    fit.min().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: [f32; FEATURES], wanted: [f32; FEATURES]) {
        for (f, w) in found.iter().zip(&wanted) {
            assert!((f - w).abs() <= 1e-5 + 1e-4 * w, "{found:?} {wanted:?}");
        }
    }

    /// A period with one contact.
    fn period(features: [f32; FEATURES]) -> Entry {
        Entry {
            contacts: 1,
            near_cut: 0,
            features,
        }
    }

    /// Twelve periods: two classes of six, half of each above its mean and half below.
    fn alternating() -> [Entry; 12] {
        core::array::from_fn(|i| {
            let class = if i % 2 == 0 { 1.0 } else { -1.0 };
            let off = if i / 2 % 2 == 0 { 1.0 } else { -1.0 };
            period([
                2.0 + 0.4 * class + 0.2 * off,
                0.3 + 0.05 * class + 0.01 * off,
                -1.0 + 0.3 * class + 0.1 * off,
                0.5 - 0.2 * class + 0.05 * off,
            ])
        })
    }

    #[test]
    fn the_scatter_is_the_variance_within_classes_of_the_impulse_as_a_share() {
        let entries = alternating();
        let apart = fit_of(&entries, 2);
        assert!(apart.consistent);
        assert_eq!(apart.contacts, 2);
        // Twelve deviations, ten degrees of freedom; the mean impulse is 2.
        let share = 12.0 / 10.0;
        let within = [0.1 * 0.1, 0.01 * 0.01, 0.1 * 0.1, 0.05 * 0.05];
        close(apart.variance, within.map(|square: f32| share * square));
        // One class: the distance of the classes is scatter, too.
        let together = fit_of(&entries, 1);
        assert_eq!((together.consistent, together.contacts), (true, 1));
        let share = 12.0 / 11.0;
        let all = [
            0.2 * 0.2 + 0.1 * 0.1,
            0.05 * 0.05 + 0.01 * 0.01,
            0.3 * 0.3 + 0.1 * 0.1,
            0.2 * 0.2 + 0.05 * 0.05,
        ];
        close(together.variance, all.map(|square: f32| share * square));
        assert_eq!(
            fit_of(&entries, 7),
            SectionFit::default(),
            "two of each class"
        );
        assert!(fit_of(&entries, 6).consistent);
    }

    #[test]
    fn periods_without_a_contact_have_neither_impulse_nor_onset() {
        let mut entries = alternating();
        for entry in entries.iter_mut().skip(1).step_by(2) {
            entry.contacts = 0;
            // What stands here must not count.
            entry.features[0] = 50.0 * entry.features[2];
            entry.features[1] = 9.0 * entry.features[2];
        }
        let fit = fit_of(&entries, 2);
        assert_eq!((fit.consistent, fit.contacts), (true, 1));
        // Six deviations with five degrees of freedom; the mean impulse is 2.4.
        let share = 6.0 / 5.0;
        let impulse = share * 0.2 * 0.2 / (2.4 * 2.4);
        let both = 12.0 / 10.0;
        close(
            fit.variance,
            [impulse, share * 1e-4, both * 0.01, both * 0.0025],
        );
        let mut silent = entries;
        for entry in &mut silent {
            entry.contacts = 0;
        }
        let fit = fit_of(&silent, 1);
        assert_eq!((fit.consistent, fit.contacts), (true, 0));
        assert_eq!(fit.variance[..2], [0.0, 0.0]);
    }

    #[test]
    fn one_period_with_a_wrong_count_is_left_out_with_the_one_after_it() {
        let mut entries = alternating();
        let clean = fit_of(&entries[..10], 2).variance;
        // The newest stands first, so the one after period 11 is period 10.
        entries[11].contacts = 2;
        entries[11].features = [99.0; FEATURES];
        entries[10].features = [-77.0; FEATURES];
        let fit = fit_of(&entries, 2);
        assert_eq!((fit.consistent, fit.contacts), (true, 2));
        close(fit.variance, clean);
        // Not for six classes, nor with fewer than three of each class, nor in two periods.
        assert!(!fit_of(&entries, 6).consistent);
        assert!(fit_of(&entries, 4).consistent);
        assert!(!fit_of(&entries[1..], 4).consistent);
        entries[3].contacts = 0;
        assert!(!fit_of(&entries, 2).consistent);
        assert_eq!(fit_of(&entries, 2).variance, [0.0; FEATURES]);
    }

    #[test]
    fn a_class_has_as_many_contacts_as_its_lower_median() {
        for (counts, expected) in [
            (&[3][..], 3),
            (&[2, 1], 1),
            (&[1, 2, 2], 2),
            (&[4, 0, 1, 1], 1),
            (&[5, 5, 0, 0], 0),
            (&[0, 3, 3, 3, 9], 3),
            (&[], 0),
        ] {
            assert_eq!(median(counts.iter().copied()), expected, "{counts:?}");
        }
    }
}
