//! Median and worst of many counts in little memory.

/// Width of a bin.
const WIDTH: u32 = 32;
/// Bins; what lies beyond goes into the last.
const BINS: usize = 512;

/// How often each count came, in bins of 32, and the largest count.
#[derive(Clone, Debug)]
pub struct Histogram {
    bins: [u32; BINS],
    worst: u32,
}

impl Default for Histogram {
    fn default() -> Self {
        Self {
            bins: [0; BINS],
            worst: 0,
        }
    }
}

impl Histogram {
    /// Enters one count into its bin.
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

    /// The largest count entered, exactly; 0 before any.
    pub fn worst(&self) -> u32 {
        self.worst
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_and_worst() {
        let mut histogram = Histogram::default();
        (0..1001).for_each(|i| histogram.add(i * 10));
        assert_eq!(histogram.worst(), 10_000);
        assert!(
            (5000..5032).contains(&histogram.median()),
            "{}",
            histogram.median()
        );
        histogram.add(1_000_000);
        assert_eq!(histogram.worst(), 1_000_000);
    }
}
