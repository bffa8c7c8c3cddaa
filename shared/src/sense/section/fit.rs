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
pub struct Fit {
    /// Contact counts agree, with at most the allowed exception.
    pub consistent: bool,
    pub contacts: u16,
    /// Scatter within classes, squared, per degree of freedom.
    pub variance: [f32; FEATURES],
}

/// Sorts periods into n classes and measures what is left within them.
pub fn fit_of(entries: &[Entry], n: usize) -> Fit {
    // Steps by 0 would panic; this shows the compiler that there are none.
    let n = n.max(1);
    let mut fit = Fit::default();
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

/// The lower median of at most [`WINDOW`] counts.
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
