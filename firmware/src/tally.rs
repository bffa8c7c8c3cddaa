//! Median and worst of many counts, in little memory.

/// Width of a bin.
const WIDTH: u32 = 32;
/// Bins; what lies beyond goes into the last.
const BINS: usize = 512;

/// Counts, in bins.
#[derive(Clone, Debug)]
pub struct Tally {
    bins: [u32; BINS],
    worst: u32,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            bins: [0; BINS],
            worst: 0,
        }
    }
}

impl Tally {
    /// Adds a count.
    pub fn add(&mut self, count: u32) {
        let bin = (count / WIDTH) as usize;
        if let Some(bin) = self.bins.get_mut(bin.min(BINS - 1)) {
            *bin = bin.saturating_add(1);
        }
        self.worst = self.worst.max(count);
    }

    /// The upper end of the bin that holds the median: at most 31 too much.
    pub fn median(&self) -> u32 {
        let all: u32 = self.bins.iter().sum();
        let mut below = 0;
        let before = self.bins.iter().take_while(|bin| {
            below += **bin;
            below <= all / 2
        });
        (before.count() as u32 + 1) * WIDTH - 1
    }

    /// The largest, exactly.
    pub fn worst(&self) -> u32 {
        self.worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_worst() {
        let mut tally = Tally::default();
        (0..1001).for_each(|i| tally.add(i * 10));
        assert_eq!(tally.worst(), 10_000);
        assert!((5000..5032).contains(&tally.median()), "{}", tally.median());
        tally.add(1_000_000);
        assert_eq!(tally.worst(), 1_000_000);
    }
}
