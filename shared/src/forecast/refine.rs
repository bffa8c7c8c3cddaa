//! Between the rows: where a stretch of stable 1/1 ends, and where its force is largest.
//!
//! Both searches give the frequency of the next orbit, and take the orbit found there.

use super::march::ForecastSection;
use super::shoot::Solution;

/// An orbit and its frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrbitAtFrequency {
    /// Drive frequency, Hz.
    pub hz: f32,
    /// The orbit found there, and its section point.
    pub solution: Solution,
}

impl OrbitAtFrequency {
    /// The orbit's doubling test: positive before the doubling, 0 at it, negative past it.
    fn at_minus_one(&self) -> f32 {
        self.solution.orbit.doubling_test
    }

    fn force(&self) -> f32 {
        self.solution.orbit.force_n
    }
}

/// The section point at `hz` on the line through two orbits, beyond them too.
pub fn on_line(a: &OrbitAtFrequency, b: &OrbitAtFrequency, hz: f32) -> ForecastSection {
    let span = b.hz - a.hz;
    let share = if span == 0.0 { 0.0 } else { (hz - a.hz) / span };
    between(a.solution.section, b.solution.section, share)
}

/// The section point at a `share` of the way from `a` to `b`.
pub fn between(a: ForecastSection, b: ForecastSection, share: f32) -> ForecastSection {
    let ([q0, v0, e0, w0], [q1, v1, e1, w1]) = (a, b);
    let at = |from: f32, to: f32| from + share * (to - from);
    [at(q0, q1), at(v0, v1), at(e0, e1), at(w0, w1)]
}

/// Whether two neighbouring orbits are of one branch: their forces differ little.
pub fn is_neighbour(a: &Solution, b: &Solution) -> bool {
    let (a, b) = (a.orbit.force_n, b.orbit.force_n);
    a < 2.5 * b && b < 2.5 * a
}

/// The search for an end of the stable 1/1, from a frequency inside to one beyond.
#[derive(Clone, Copy, Debug)]
pub struct RangeEnd {
    inside: OrbitAtFrequency,
    /// Another orbit farther inside, to extrapolate with.
    behind: Option<OrbitAtFrequency>,
    beyond_hz: f32,
    /// The orbit beyond, if it is a 1/1 past its doubling, with its weight in the false position.
    beyond: Option<(OrbitAtFrequency, f32)>,
    inside_weight: f32,
    iterations: u8,
}

/// Frequencies are found to this share of themselves.
const TOLERANCE: f32 = 2e-5;

const EDGE_ITERATIONS: u8 = 14;

impl RangeEnd {
    /// Starts with an orbit `inside`, perhaps another one `behind` it, and a frequency beyond the end, with
    /// what was found there.
    pub fn new(
        inside: OrbitAtFrequency,
        behind: Option<OrbitAtFrequency>,
        beyond_hz: f32,
        beyond: Option<Solution>,
    ) -> Self {
        let mut edge = Self {
            inside,
            behind,
            beyond_hz,
            beyond: None,
            inside_weight: 1.0,
            iterations: 0,
        };
        edge.set_beyond(beyond_hz, beyond);
        edge
    }

    /// The last stable 1/1 found.
    pub fn inside(&self) -> OrbitAtFrequency {
        self.inside
    }

    /// Whether the stable 1/1 goes on up to `hz`, where the search began: no end was found before it.
    pub fn reaches(&self, hz: f32) -> bool {
        let width = libm::fabsf(hz - self.inside.hz);
        self.beyond_hz == hz && self.beyond.is_none() && width < 4.0 * TOLERANCE * hz
    }

    /// The doubling, Hz, if it is one.
    pub fn doubling_hz(&self) -> Option<f32> {
        self.beyond.map(|_| self.next_hz())
    }

    /// Where the next orbit is wanted, or none when the end is found.
    pub fn wanted(&self) -> Option<f32> {
        let width = libm::fabsf(self.beyond_hz - self.inside.hz);
        let next = self.next_hz();
        let narrow = TOLERANCE * self.inside.hz;
        let close = self.beyond.is_some()
            && self.iterations > 2
            && (libm::fabsf(next - self.inside.hz) < narrow
                || libm::fabsf(next - self.beyond_hz) < narrow);
        (self.iterations < EDGE_ITERATIONS && width > narrow && !close).then_some(next)
    }

    /// A guess of the section at `hz`.
    pub fn guess(&self, hz: f32) -> ForecastSection {
        match (&self.beyond, &self.behind) {
            (Some((beyond, _)), _) => on_line(&self.inside, beyond, hz),
            (None, Some(behind)) => on_line(behind, &self.inside, hz),
            (None, None) => self.inside.solution.section,
        }
    }

    /// Takes what was found at `hz`.
    pub fn take(&mut self, hz: f32, found: Option<Solution>) {
        self.iterations += 1;
        let found = found.filter(|f| is_neighbour(f, &self.inside.solution));
        match found {
            Some(solution) if solution.is_stable_one_one() => {
                self.behind = Some(self.inside);
                self.inside = OrbitAtFrequency { hz, solution };
                // The same side twice: the false position leans to the other (Illinois).
                self.inside_weight = 1.0;
                if let Some((_, weight)) = &mut self.beyond {
                    *weight *= 0.5;
                }
            }
            other => {
                self.set_beyond(hz, other);
                self.inside_weight *= 0.5;
            }
        }
    }

    fn set_beyond(&mut self, hz: f32, found: Option<Solution>) {
        self.beyond_hz = hz;
        let doubled = found
            .filter(|s| s.onsets == 1)
            .map(|solution| OrbitAtFrequency { hz, solution })
            .filter(|known| known.at_minus_one() < 0.0);
        self.beyond = doubled.map(|known| (known, 1.0));
    }

    fn next_hz(&self) -> f32 {
        let (from, to) = (self.inside.hz, self.beyond_hz);
        let share = match &self.beyond {
            Some((beyond, weight)) => {
                let a = self.inside_weight * self.inside.at_minus_one();
                let b = weight * beyond.at_minus_one();
                let share = a / (a - b);
                if share > 0.01 && share < 0.99 {
                    share
                } else {
                    0.5
                }
            }
            None => 0.5,
        };
        from + share * (to - from)
    }
}

/// The search for the largest force between two orbits, through a third.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    low: OrbitAtFrequency,
    top: OrbitAtFrequency,
    high: OrbitAtFrequency,
    iterations: u8,
}

const PEAK_ITERATIONS: u8 = 10;

/// A step to the parabola's top shorter than this share of the frequency is the last: points closer together
/// would differ by little more than rounding.
const CLOSEST: f32 = 2e-3;

impl Peak {
    /// Starts with three orbits by rising frequency.
    pub fn new(low: OrbitAtFrequency, top: OrbitAtFrequency, high: OrbitAtFrequency) -> Self {
        Self {
            low,
            top,
            high,
            iterations: 0,
        }
    }

    /// The strongest orbit found.
    pub fn best(&self) -> OrbitAtFrequency {
        let mut best = self.top;
        for end in [self.low, self.high] {
            if end.force() > best.force() {
                best = end;
            }
        }
        best
    }

    /// Where the next orbit is wanted, or none when the largest force is found.
    pub fn wanted(&self) -> Option<f32> {
        if self.iterations >= PEAK_ITERATIONS {
            return None;
        }
        let best = self.best().hz;
        let top = self.top.hz;
        if best != top {
            // The force is largest at an end: halve towards it.
            let far = libm::fabsf(best - top) > CLOSEST * top;
            return far.then_some(0.5 * (top + best));
        }
        let vertex = self.vertex();
        (libm::fabsf(vertex - top) > TOLERANCE * top).then_some(vertex)
    }

    /// The top of the parabola through the three points, kept between the outer ones.
    fn vertex(&self) -> f32 {
        let (top_hz, top_n) = (self.top.hz, self.top.force());
        let (a, c) = (self.low.hz - top_hz, self.high.hz - top_hz);
        if a == 0.0 || c == 0.0 {
            return top_hz;
        }
        let slope_a = (self.low.force() - top_n) / a;
        let slope_c = (self.high.force() - top_n) / c;
        let curvature = (slope_a - slope_c) / (a - c);
        if curvature == 0.0 {
            return top_hz;
        }
        let shift = -0.5 * (slope_a - curvature * a) / curvature;
        // Comparisons with NaN are false.
        if shift > 0.9 * a && shift < 0.9 * c {
            top_hz + shift
        } else {
            top_hz
        }
    }

    /// A guess of the section at `hz`.
    pub fn guess(&self, hz: f32) -> ForecastSection {
        if hz < self.top.hz {
            on_line(&self.low, &self.top, hz)
        } else {
            on_line(&self.top, &self.high, hz)
        }
    }

    /// Takes what was found at `hz`.
    pub fn take(&mut self, hz: f32, found: Option<Solution>) {
        self.iterations += 1;
        let found = found.filter(Solution::is_stable_one_one);
        let Some(solution) = found else {
            self.iterations = PEAK_ITERATIONS;
            return;
        };
        if self.best() == self.top && libm::fabsf(hz - self.top.hz) < CLOSEST * hz {
            // The parabola's top has come to rest: this is it.
            self.top = OrbitAtFrequency { hz, solution };
            self.iterations = PEAK_ITERATIONS;
            return;
        }
        let known = OrbitAtFrequency { hz, solution };
        let below = hz < self.top.hz;
        // What is stronger becomes the top, and the top an end; what is weaker becomes an end.
        match (known.force() > self.top.force(), below) {
            (true, true) => (self.high, self.top) = (self.top, known),
            (true, false) => (self.low, self.top) = (self.top, known),
            (false, true) => self.low = known,
            (false, false) => self.high = known,
        }
    }
}
