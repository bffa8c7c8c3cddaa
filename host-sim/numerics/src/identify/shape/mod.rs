//! The whole force of each impact, sample by sample, with what the sensor may do to it: law, release, gain, zero, filter,
//! ringing and the instant of each onset are sought together.
//!
//! Each impact has an onset of its own: the flight in between is not what is sought, and the surface's flexibility makes
//! it differ (section 3.3.2). Without a filter the force of a spring-dashpot jumps at the onset, and the sum of squares
//! jumps when the onset passes a sample: the onset is then sought between two samples, and the two best pairs of them
//! by scanning.

mod problem;

use std::ops::Range;

use shared::model::params::RigParams;
use shared::model::rig::Rig;

use super::SearchSettings;
use super::contacts::MeasuredImpacts;
use super::least_squares::{self, Solved};
use super::ring::{self, Tail};
use super::sensor::{FilterKind, FilteredPulse, SensorModel, Swing};
use super::unknowns::Unknowns;
use crate::contact_law::undriven::Course;
use crate::drop_test::impacts;
use crate::reference::LocatedContact;

/// Where no noise is seen, squares are counted in this share of the largest peak, so that the search has a scale.
const SCALE_SHARE: f64 = 1e-5;

/// The window reaches this many time constants of the ringing beyond the contact.
const RINGING_DECAYS: f64 = 3.0;

/// Coordinates after those of the law.
const RELEASE: usize = 0;
const GAIN: usize = 1;
const OFFSET: usize = 2;
const CLOCK: usize = 3;
/// The first of the filter's, of which [`FilterKind::unknowns`] says how many there are.
const FILTER: usize = 4;
/// After these, those of the ringing if it is sought: two sizes, ln Hz, ln s.
const RINGING: usize = 4;

/// Where the search for the ringing begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingingGuess {
    pub hz: f64,
    /// Time constant of its decay, s.
    pub decay_s: f64,
}

/// The problem of fitting the whole force.
pub struct ForceShape<'a> {
    measured: &'a MeasuredImpacts,
    params: RigParams,
    unknowns: &'a Unknowns,
    settings: SearchSettings,
    /// The kind of filter.
    pub model: FilterKind,
    ringing: Option<RingingGuess>,
    pub windows: Vec<Range<usize>>,
    /// The deviation of a sample, N.
    pub deviation_n: f64,
}

/// The model's contacts at a point.
pub struct Contacts {
    rig: Rig<f64>,
    courses: Vec<Course>,
}

impl Contacts {
    /// The `i`-th contact, if there are so many.
    pub fn contact(&self, i: usize) -> Option<LocatedContact> {
        self.courses.get(i).map(|course| course.contact)
    }
}

impl<'a> ForceShape<'a> {
    /// Of `measured`, with this kind of filter, and with ringing if there is a guess of it.
    pub fn new(
        measured: &'a MeasuredImpacts,
        params: &RigParams,
        unknowns: &'a Unknowns,
        settings: &SearchSettings,
        model: FilterKind,
        ringing: Option<RingingGuess>,
    ) -> Self {
        let mut windows: Vec<Range<usize>> =
            measured.impacts.iter().map(|i| i.window.clone()).collect();
        if let Some(guess) = ringing {
            let until = |w: &Range<usize>| {
                let end_s = measured.time_s[w.end - 1] + RINGING_DECAYS * guess.decay_s;
                measured.time_s.partition_point(|t| *t < end_s)
            };
            let starts: Vec<usize> = windows.iter().skip(1).map(|w| w.start).collect();
            for (i, window) in windows.iter_mut().enumerate() {
                let next = starts.get(i).copied().unwrap_or(measured.time_s.len());
                window.end = until(window).min(next).max(window.end);
            }
        }
        Self {
            measured,
            params: *params,
            unknowns,
            settings: *settings,
            model,
            ringing,
            windows,
            deviation_n: unit_n(measured),
        }
    }

    /// How many numbers are compared.
    pub fn data(&self) -> usize {
        self.windows.iter().map(Range::len).sum()
    }

    fn laws(&self) -> usize {
        self.unknowns.list().len()
    }

    /// Where the ringing's are, if it is sought.
    fn ringing_at(&self) -> usize {
        FILTER + self.model.unknowns()
    }

    fn first_onset(&self) -> usize {
        self.laws() + self.ringing_at() + if self.ringing.is_some() { RINGING } else { 0 }
    }

    /// The sensor's gain at a point. Gain and release make up for each other: only their product is seen. Where the
    /// release is sought, the coordinate is therefore the gain at the release first given, which keeps the product while
    /// the release moves: else the search ends on the long way along the valley, wherever its first steps led.
    fn gain(&self, x: &[f64]) -> f64 {
        let own = x[self.laws() + GAIN];
        match self.release_m(x) {
            Some(release_m) if self.settings.seek_release => {
                own * self.settings.release_m / release_m
            }
            _ => own,
        }
    }

    /// The sensor at a point.
    pub fn sensor(&self, x: &[f64]) -> SensorModel {
        let own = &x[self.laws()..];
        let swing = &own[self.ringing_at()..];
        let mut filter = [0.0; 3];
        let count = self.model.unknowns();
        filter[..count].copy_from_slice(&own[FILTER..FILTER + count]);
        SensorModel {
            gain: self.gain(x),
            offset_n: own[OFFSET],
            clock: own[CLOCK],
            model: self.model,
            filter,
            swing: self.ringing.map(|_| Swing {
                cos: swing[0],
                sin: swing[1],
                hz: swing[2].exp(),
                decay_s: swing[3].exp(),
            }),
        }
    }

    /// The coordinates of the sensor from `of`, gain and release apart.
    pub fn sensor_coordinates(&self) -> Range<usize> {
        self.laws() + OFFSET..self.first_onset()
    }

    /// The release at a point, m.
    pub fn release_m(&self, x: &[f64]) -> Option<f64> {
        let (_, release_m) = self.unknowns.read(&x[..self.laws()])?;
        Some(release_m * x[self.laws() + RELEASE])
    }

    /// The model's contacts at a point; fewer than the record's where the hammer comes to rest.
    pub fn contacts(&self, x: &[f64]) -> Option<Contacts> {
        let (law, _) = self.unknowns.read(&x[..self.laws()])?;
        let params = RigParams {
            contact: law,
            ..self.params
        };
        let rig = Rig::<f64>::new(&params).ok()?;
        let count = self.measured.impacts.len();
        let courses = impacts(&params, &rig, self.release_m(x)?, count).ok()?;
        Some(Contacts { rig, courses })
    }

    /// What the sensor would show, N, window by window.
    pub fn shown(&self, x: &[f64], contacts: &Contacts) -> Vec<Vec<f64>> {
        (0..self.windows.len())
            .map(|i| self.shown_impact(x, contacts, i))
            .collect()
    }

    fn shown_impact(&self, x: &[f64], contacts: &Contacts, i: usize) -> Vec<f64> {
        let sensor = self.sensor(x);
        let times = &self.measured.time_s[self.windows[i].clone()];
        let Some(course) = contacts.courses.get(i) else {
            return vec![sensor.offset_n; times.len()];
        };
        let pulse = FilteredPulse::new(&contacts.rig, course, &sensor, self.measured.sample_s);
        let onset = self.onset_s(x, i);
        times
            .iter()
            .map(|t| pulse.shown(&sensor, t - onset))
            .collect()
    }

    /// When the `i`-th contact begins in the record, s: a coordinate counted in samples from the first over the
    /// threshold.
    pub fn onset_s(&self, x: &[f64], i: usize) -> f64 {
        self.measured.impacts[i].at_s + x[self.first_onset() + i] * self.measured.sample_s
    }

    /// The share by which the release may be off, as stated.
    pub fn release_deviation(&self) -> f64 {
        if self.settings.seek_release {
            return 1e-9;
        }
        0.01 * self.settings.release_height_percent.max(1e-7)
    }

    /// The share by which the gain may be off, as stated.
    pub fn gain_deviation(&self) -> f64 {
        0.01 * self.settings.gain_percent.max(1e-7)
    }

    /// Where a search begins: a point of the law, and a filter.
    pub fn start(&self, law: &[f64], filter: &[f64]) -> Vec<f64> {
        let mut x = law.to_vec();
        x.extend([1.0, 1.0, 0.0, 1.0]);
        x.extend(filter);
        if let Some(guess) = self.ringing {
            x.extend([0.0, 0.0, guess.hz.ln(), guess.decay_s.ln()]);
        }
        x.extend(vec![-0.5; self.windows.len()]);
        x
    }

    /// `x` with each onset where the impact fits best, the rest as it is: anywhere in the window, or `near` where it is.
    /// None if the model cannot be followed.
    fn scanned(&self, x: &[f64], near: bool) -> Option<Vec<f64>> {
        let contacts = self.contacts(x)?;
        let mut x = x.to_vec();
        for i in 0..self.windows.len() {
            let k = self.first_onset() + i;
            let impact = &self.measured.impacts[i];
            let before = (impact.first - self.windows[i].start) as f64;
            let after = self.latest(&x);
            let own = x[k];
            let tried: Vec<f64> = if near {
                // Either end of this space between samples and of two on both sides.
                let pair = own.floor();
                let places = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|j| [pair + j + 0.1, pair + j + 0.9]);
                places.into_iter().flatten().collect()
            } else {
                (-before as i64..after as i64)
                    .map(|j| j as f64 + 0.5)
                    .collect()
            };
            let mut best = (self.squares(&x, &contacts, i), own);
            for place in tried.into_iter().filter(|p| *p > -before && *p < after) {
                x[k] = place;
                let cost = self.squares(&x, &contacts, i);
                if cost < best.0 {
                    best = (cost, place);
                }
            }
            x[k] = best.1;
        }
        Some(x)
    }

    fn squares(&self, x: &[f64], contacts: &Contacts, i: usize) -> f64 {
        let forces = &self.measured.force_n[self.windows[i].clone()];
        let shown = self.shown_impact(x, contacts, i);
        let pairs = shown.iter().zip(forces);
        pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>()
    }

    /// The least near `x`, the coordinates `held` kept. Where the filter is too fast to be told from none, a little of it
    /// and another onset make up for each other, and there is more than one least: it is also sought from no filter.
    pub fn solve(&self, x: &[f64], held: &[usize], rounds: usize) -> Option<Solved> {
        let best = self.solve_once(x, held, rounds)?;
        let filter = self.laws() + FILTER;
        if self.shows_filter(&best.x) || held.contains(&filter) {
            return Some(best);
        }
        let mut sharp = best.x.clone();
        sharp[filter] = 0.0;
        let again = self.solve_once(&self.scanned(&sharp, true)?, held, rounds)?;
        Some(best.or_better(again))
    }

    /// Whether the record shows a filter at a point: if not, filter and onsets make up for each other.
    pub fn shows_filter(&self, x: &[f64]) -> bool {
        self.model.shows(x[self.laws() + FILTER])
    }

    /// The latest onset of an impact, in samples from the first over the threshold.
    fn latest(&self, x: &[f64]) -> f64 {
        3.0 + self.model.leads(&x[self.laws() + FILTER..]).floor()
    }

    /// `x` with all onsets so many samples later, as far as their range goes.
    pub fn shifted(&self, x: &[f64], by: f64) -> Vec<f64> {
        let mut x = x.to_vec();
        let first = self.first_onset();
        let latest = self.latest(&x);
        for (i, onset) in x[first..].iter_mut().enumerate() {
            let before = (self.measured.impacts[i].first - self.windows[i].start) as f64;
            *onset = (*onset + by).clamp(1e-2 - before, latest - 1e-2);
        }
        x
    }

    /// Whether the onset's jump is one in the samples.
    pub fn jumps(&self, x: &[f64]) -> bool {
        self.model.jumps(x[self.laws() + FILTER])
    }

    /// Rounds of least squares, with the onsets scanned in between.
    fn solve_once(&self, x: &[f64], held: &[usize], rounds: usize) -> Option<Solved> {
        let mut best = least_squares::solve(self, x, held, rounds)?;
        if !self.jumps(&best.x) {
            return Some(best);
        }
        for _ in 0..3 {
            let scanned = self.scanned(&best.x, true)?;
            if scanned == best.x {
                break;
            }
            let again = least_squares::solve(self, &scanned, held, rounds)?;
            let done = again.cost > best.cost - 1e-3;
            best = best.or_better(again);
            if done {
                break;
            }
        }
        Some(best)
    }

    /// From a start far away.
    pub fn solve_from(&self, x: &[f64], rounds: usize) -> Option<Solved> {
        self.solve_once(&self.scanned(x, false)?, &[], rounds)
    }

    /// What is measured less what is shown, N, window by window.
    pub fn left(&self, x: &[f64]) -> Option<Vec<Vec<f64>>> {
        let shown = self.shown(x, &self.contacts(x)?);
        let one = |(window, shown): (&Range<usize>, Vec<f64>)| {
            let forces = &self.measured.force_n[window.clone()];
            forces.iter().zip(shown).map(|(f, s)| f - s).collect()
        };
        Some(self.windows.iter().zip(shown).map(one).collect())
    }

    /// What is left after each release, where a rigid surface shows nothing.
    pub fn tails(&self, x: &[f64]) -> Option<Vec<Tail>> {
        let contacts = self.contacts(x)?;
        let sensor = self.sensor(x);
        let (times, forces) = (&self.measured.time_s, &self.measured.force_n);
        let one = |(i, course): (usize, &Course)| {
            let release = self.onset_s(x, i) + course.contact.duration_s;
            let at = |t: f64| times.partition_point(|x| *x < t);
            // The release of the law may be a little early or late: a tenth of the contact is left out.
            let first = at(release + 0.1 * course.contact.duration_s);
            let end = at(release + ring::SPAN_S);
            let pulse = FilteredPulse::new(&contacts.rig, course, &sensor, self.measured.sample_s);
            let left = |k: usize| forces[k] - pulse.shown(&sensor, times[k] - self.onset_s(x, i));
            (end >= first + 10).then(|| Tail {
                time_s: times[first..end].iter().map(|t| t - release).collect(),
                force_n: (first..end).map(left).collect(),
            })
        };
        Some(
            contacts
                .courses
                .iter()
                .enumerate()
                .filter_map(one)
                .collect(),
        )
    }
}

/// What squares are counted in, N: the noise, or a hundred thousandth of the largest peak.
pub fn unit_n(measured: &MeasuredImpacts) -> f64 {
    let largest = measured.impacts.iter().map(|i| i.peak_n);
    measured
        .noise_n
        .max(SCALE_SHARE * largest.fold(0.0, f64::max))
}
