//! The surface's ringing, and the contact's true peak behind it.
//!
//! A contact makes the surface ring, and the force sensor sees both. Where the ringing falls first, the largest sample is up
//! to 18 % below the contact's true peak; where it has come back before the force is gone, up to 25 % above it.
//! After the contact the sensor sees the ringing alone: a decaying sine. Its pitch and decay come from the correlation of the
//! mean of those samples over many contacts, whose noise is small; the correlation over a tick or two, which noise behind a filter has too,
//! is left out. Size and phase are those of each contact where noise is small, and else those of the last contacts, turned to the instant at
//! which this one crossed its threshold. The ringing is followed back to where it began, through the anti-alias filter, and taken out of the
//! samples of the contact. Where it is heard but not known, the peak is taken for up to 1.2 times what is read, by how loud it is. With
//! ringing of 5 to 60 % at 1 to 6 kHz and a decay of 1 or 2 ms, the peak of the emulator's contact is that of the same contact without
//! ringing within 0.2 %, with noise of 0.5 % of the peak within 0.6 %, with 2 % within 1.9 %.

use core::f32::consts::{PI, SQRT_2};

use nalgebra::Complex;

use crate::model::contact::Law;
use crate::model::params::RigParams;
use crate::settings::{Settings, TICK_S, strong_speed_m_per_s};

use self::learnt::Learnt;
use self::sine::{TAIL, exp, fit, products};
use super::pulse::PulseEdge;

mod learnt;
mod sine;

/// Samples kept of a contact and what follows.
const LENGTH: usize = 80;
/// Ticks for which the filter still shows the contact after its end, and a softer contact lasts longer.
const MARGIN: f32 = 3.5;
/// Contacts in the mean of peaks.
const MEMORY: f32 = 16.0;
/// Variance of the amplitude fitted to a contact, over its decay per tick times the mean square of the noise: 4 if that is white, twice as
/// much behind a filter.
const FITTED: f32 = 8.0;
/// Error of a contact's peak, as a share of it, from which on it is known better as the contacts before it were.
const UNSURE: f32 = 0.01;
/// From which on it is taken for no more than how loud the tails are allows,
const UNCLEAR: f32 = 0.05;
/// and from which on nothing is known of it.
const UNKNOWN: f32 = 0.12;
/// Contacts for which the most that two samples in a row have reached is remembered. How much that is changes with where the
/// samples fall in the ringing, slowly where the drive holds its frequency: at 5 kHz there are four of them to a swing.
const TWO_MEMORY: f32 = 512.0;
/// How many times the errors of a peak, and of one taken as those before it, the two differ by if it is a blow of another kind.
const OTHER: f32 = 4.0;
/// Contacts before anything is known.
const FEW: u8 = 4;
/// True peak over largest sample, at most, where nothing is known yet.
const MOST: f32 = 1.2;
/// What a limit adds where the ringing is lost in the noise or dies before it is seen: such a peak may be so much above its reading.
const HIDDEN: f32 = 0.15;
/// Error of the decay found, relative, over the share of noise in the mean tail.
const DECAY: f32 = 3.0;
/// How much of the ringing's amplitude may be hidden in a peak.
const HIDES: f32 = 0.36;
/// And as far as what was found is believed.
const BELIEVED: (f32, f32) = (0.7, 1.4);
/// Corner of the force's anti-alias filter, second-order Butterworth (docs/wiring.md), rad per tick.
const CORNER: f32 = 2.0 * PI * 6_000.0 * TICK_S as f32;

/// The believed contact, in ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    /// From the onset to the largest force, where the ringing begins.
    to_peak: f32,
    /// From the first sample to the first of the ringing alone.
    tail: usize,
    /// Share of the largest force that the filter hides, per N of it: the harder the blow, the sooner its largest force.
    filtered_per_n: f32,
}

impl Shape {
    /// Of the rig's contact at the speed of a strong 1/1; none if it lasts too long for the ringing to be seen after it.
    fn of(rig: &RigParams, tick_s: f32) -> Option<Self> {
        const STEP: f32 = 0.05;
        let law: Law<f32> = rig.contact.cast();
        let (mass_kg, h) = (rig.mass_kg as f32, STEP * tick_s);
        let approach = strong_speed_m_per_s(rig) as f32;
        let (mut depth_m, mut rate) = (0.0, approach);
        let (mut largest_n, mut to_peak) = (0.0, 0.0);
        let (mut shown_n, mut shown_rate, mut most_n) = (0.0, 0.0, 0.0_f32);
        let longest = ((LENGTH - TAIL) as f32 - MARGIN) / STEP;
        for step in 0..longest as usize {
            let force_n = law.force(depth_m, rate, approach);
            if force_n > largest_n {
                (largest_n, to_peak) = (force_n, STEP * step as f32);
            }
            shown_rate += STEP * CORNER * (CORNER * (force_n - shown_n) - SQRT_2 * shown_rate);
            shown_n += STEP * shown_rate;
            most_n = most_n.max(shown_n);
            rate -= h * force_n / mass_kg;
            depth_m += h * rate;
            if rate < 0.0 && law.force(depth_m, rate, approach) <= 0.0 {
                let tail = (STEP * step as f32 + MARGIN) as usize + 1;
                return Some(Self {
                    to_peak,
                    tail,
                    filtered_per_n: (1.0 / most_n - 1.0 / largest_n).max(0.0),
                });
            }
        }
        None
    }
}

/// Finds the ringing, one sample of the force at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ringing {
    shape: Option<Shape>,
    /// How many samples there are; [`LENGTH`]: none is collected.
    count: usize,
    /// From the second sample back to the crossing, ticks.
    crossed_before: f32,
    /// The last two samples.
    last_n: [f32; 2],
    /// Contacts that were collected, and their mean, as read and without ringing.
    contacts: u8,
    read: RingingContact,
    found: RingingContact,
    /// The most that two samples in a row of such a contact reach of its true peak.
    two_share: f32,
    /// Error of the last contact's peak by the noise, as a share of it.
    unsure: f32,
    /// Error of what the last contact alone showed.
    noisy: f32,
    /// What a limit adds to the last contacts' peaks, as a share of them.
    doubted: f32,
    /// The contact under way as it is read, and without ringing, once known.
    reading: RingingContact,
    own: Option<RingingContact>,
    open: bool,
    period_n: f32,
    samples: [f32; LENGTH],
    learnt: Learnt,
}

/// The force of one contact: its peak and the sum of its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingingContact {
    /// Its largest force, N.
    pub peak_n: f32,
    /// Sum of the samples, N.
    pub sum_n: f32,
}

impl RingingContact {
    const NONE: Self = Self {
        peak_n: 0.0,
        sum_n: 0.0,
    };
}

impl Ringing {
    /// Of the rig's surface; nothing is known of it yet.
    pub fn new(settings: &Settings, tick_s: f32) -> Self {
        let shape = Shape::of(&settings.rig, tick_s);
        Self {
            shape,
            samples: [0.0; LENGTH],
            count: LENGTH,
            crossed_before: 0.0,
            last_n: [0.0; 2],
            learnt: Learnt::NOTHING,
            contacts: 0,
            read: RingingContact::NONE,
            found: RingingContact::NONE,
            two_share: 0.0,
            unsure: 0.0,
            noisy: 0.0,
            doubted: if shape.is_some() { HIDDEN } else { 0.0 },
            reading: RingingContact::NONE,
            own: None,
            open: false,
            period_n: 0.0,
        }
    }

    /// The contact under way is forgotten; what is known of the surface stays.
    pub fn reset(&mut self) {
        self.count = LENGTH;
        self.reading = RingingContact::NONE;
        self.own = None;
        self.open = false;
        self.period_n = 0.0;
    }

    /// True peak over the largest sample, mean of the last contacts; 1 while nothing is known.
    pub fn peak_over_reading(&self) -> f32 {
        ratio(self.found.peak_n, self.read.peak_n)
    }

    /// True peak over what two samples in a row reach in the last contacts, at most; 1 while nothing is known. Of a contact of
    /// one sample they reach nothing: more than is believed is none.
    pub fn peak_over_two(&self) -> f32 {
        ratio(1.0, self.two_share).min(BELIEVED.1)
    }

    /// How many times what it seems to be the peak may still be.
    pub fn doubt(&self) -> f32 {
        if self.shape.is_some() && self.contacts < FEW {
            // Of contacts that ring in an unknown way the peak has it already.
            (MOST / self.peak_over_reading()).max(1.0)
        } else {
            1.0
        }
    }

    /// How many times what it seems to be the peak is taken for by a limit, which no surface's ringing may hide.
    pub fn limit_doubt(&self) -> f32 {
        1.0 + self.doubted
    }

    /// Whether the peak of a single contact says something, and not only those of several.
    pub fn is_sure(&self) -> bool {
        self.unsure.max(self.noisy) < UNSURE
    }

    /// The largest peak of the contacts that ended since the last call, N, each with the ringing after it.
    pub fn take_largest(&mut self) -> f32 {
        core::mem::take(&mut self.period_n)
    }

    /// The next sample, N, and what the detector made of it. A contact that is over, its ringing seen.
    #[inline]
    pub fn tick(&mut self, force_n: f32, edge: &PulseEdge) -> Option<RingingContact> {
        let [older_n, first_n] = self.last_n;
        self.last_n = [first_n, force_n];
        let mut over = None;
        if let PulseEdge::Began { ago } = edge {
            over = self.end();
            self.crossed_before = ago - 1.0;
            // The filter's slope before the crossing belongs to the contact.
            self.samples[0] = older_n;
            self.samples[1] = first_n;
            self.count = 2;
            self.reading.peak_n = first_n;
            self.open = true;
        }
        if self.is_under_way() && force_n > self.reading.peak_n {
            self.reading.peak_n = force_n;
            // Of a contact that goes on after it was collected, what was found is not all.
            self.own = None;
        }
        if let Some(place) = self.samples.get_mut(self.count) {
            *place = force_n;
            self.count += 1;
            if let Some(shape) = self.shape.filter(|shape| self.count >= shape.tail + TAIL) {
                self.count = LENGTH;
                self.contact(&shape);
            }
        }
        if let PulseEdge::Ended(raw) = edge {
            self.reading.sum_n = raw.sum_n;
            self.open = false;
        }
        if self.is_under_way() {
            over
        } else {
            self.end().or(over)
        }
    }

    fn is_under_way(&self) -> bool {
        self.open || self.count < LENGTH
    }

    /// The contact that was under way, if any, is over.
    #[inline(never)]
    fn end(&mut self) -> Option<RingingContact> {
        let reading = core::mem::replace(&mut self.reading, RingingContact::NONE);
        if reading.peak_n <= 0.0 {
            return None;
        }
        let as_before = RingingContact {
            peak_n: reading.peak_n * self.peak_over_reading(),
            sum_n: reading.sum_n * ratio(self.found.sum_n, self.read.sum_n),
        };
        let contact = self.own.take().unwrap_or(as_before);
        self.period_n = self.period_n.max(contact.peak_n);
        Some(contact)
    }

    /// A contact and its ringing have been collected.
    #[inline(never)]
    fn contact(&mut self, shape: &Shape) {
        let mut tail = [0.0; TAIL];
        for (place, sample) in tail.iter_mut().zip(self.samples.iter().skip(shape.tail)) {
            *place = *sample;
        }
        let length = shape.tail + TAIL;
        let read = measure(&self.samples, length);
        let pairs = self.samples.windows(2).take(length - 1);
        let two_n = pairs.fold(0.0, |most: f32, pair| {
            most.max(pair.iter().copied().fold(f32::INFINITY, f32::min))
        });
        let struck = read.peak_n > 0.0;
        if !struck {
            return;
        }
        for sample in &mut tail {
            *sample /= read.peak_n;
        }
        self.learnt.add(&tail);
        let (rings, most) = (self.learnt.rings(), self.learnt.most());
        let (mut found, mut explained) = (read, false);
        self.unsure = 0.0;
        self.noisy = 0.5 * libm::sqrtf(self.learnt.noise);
        let mut hidden = 0.0;
        let pole = rings.then(|| self.learnt.pole()).flatten();
        let fitted = pole
            .and_then(|pole| Some((pole, fit(&tail, pole)?)))
            .filter(|(_, own)| own.norm_sqr().is_finite());
        if let Some((pole, own)) = fitted {
            sine::take_out(&mut tail, pole, own);
            let left = products(&tail, 0, 0, TAIL - 1) / (TAIL - 1) as f32;
            let contradicted = self.learnt.is_contradicted(left);
            explained = self.learnt.explains(&tail);
            let noise = -FITTED * pole.re * left;
            let (amplitude, variance) =
                self.learnt.amplitude(own, noise, pole, self.crossed_before);
            let since_peak = shape.tail as f32 - shape.to_peak;
            let grows = -pole.re * since_peak;
            self.unsure = libm::sqrtf(variance) * libm::expf(grows);
            self.noisy = 0.5 * libm::sqrtf(left) * libm::expf(grows);
            let loud = libm::sqrtf(amplitude.norm_sqr()) * libm::expf(grows);
            let faster = DECAY * grows * self.learnt.noise_share();
            hidden = HIDES * loud * (libm::expf(faster.min(1.0)) - 1.0);
            if contradicted {
                self.learnt = Learnt::NOTHING;
            }
            let amplitude = amplitude * read.peak_n;
            shape.take_out(&mut self.samples, self.crossed_before, pole, amplitude);
            found = measure(&self.samples, length);
        }
        if self.unsure > UNCLEAR {
            found.peak_n = found.peak_n.min(most * read.peak_n);
            found.sum_n = read.sum_n;
        }
        found.peak_n *= 1.0 + shape.filtered_per_n * found.peak_n;
        let unknown = self.unsure > UNKNOWN || (fitted.is_none() && rings);
        let doubt = if unknown {
            // It rings, but how is not known.
            found = RingingContact {
                peak_n: most * read.peak_n,
                ..read
            };
            self.unsure = 1.0;
            MOST / most - 1.0
        } else if explained || self.learnt.is_silent() {
            (self.unsure + hidden).min(HIDDEN)
        } else {
            HIDDEN
        };
        self.doubted += (doubt - self.doubted) / MEMORY;
        let (least, most) = BELIEVED;
        if !(least..most).contains(&(found.peak_n / read.peak_n)) || !found.sum_n.is_finite() {
            found = read;
        }
        self.contacts = self.contacts.saturating_add(1);
        let weight = 1.0 / f32::from(self.contacts).min(MEMORY);
        for (mean, new) in [(&mut self.read, read), (&mut self.found, found)] {
            mean.peak_n += weight * (new.peak_n - mean.peak_n);
            mean.sum_n += weight * (new.sum_n - mean.sum_n);
        }
        let as_before_n = read.peak_n * self.peak_over_reading();
        let off = (found.peak_n / as_before_n - 1.0).abs();
        let own = if off > OTHER * (UNSURE + self.unsure) {
            1.0
        } else {
            UNSURE * UNSURE / (UNSURE * UNSURE + self.unsure * self.unsure)
        };
        self.own = Some(RingingContact {
            peak_n: as_before_n + own * (found.peak_n - as_before_n),
            ..found
        });
        let share = two_n / found.peak_n;
        let faded = self.two_share + (share - self.two_share) / TWO_MEMORY;
        self.two_share = share.max(faded);
    }
}

/// Peak and sum of the first `length` samples.
#[inline(never)]
fn measure(samples: &[f32; LENGTH], length: usize) -> RingingContact {
    RingingContact {
        peak_n: samples.iter().take(length).fold(0.0, |a, b| a.max(*b)),
        sum_n: samples.iter().take(length).sum(),
    }
}

/// 1 where nothing is known yet.
fn ratio(found: f32, read: f32) -> f32 {
    if read > 0.0 { found / read } else { 1.0 }
}

impl Shape {
    /// Takes a ringing out of the samples of a contact: the real part of `amplitude` e^(`pole` k), k = 0 at the first of
    /// the ringing alone, from its beginning on.
    fn take_out(
        &self,
        samples: &mut [f32; LENGTH],
        crossed_before: f32,
        pole: Complex<f32>,
        amplitude: Complex<f32>,
    ) {
        // The ringing itself, before the filter, passes 0 falling where it begins: the nearest such instant to the believed
        // peak.
        let peak = self.to_peak - crossed_before - (self.tail as f32 - 1.0);
        let filter = pole * pole + pole * (SQRT_2 * CORNER) + CORNER * CORNER;
        let from_falling = amplitude * filter * exp(pole * peak) * Complex::new(0.0, -1.0);
        let begin = peak - libm::atan2f(from_falling.im, from_falling.re) / pole.im;
        let first = libm::ceilf(begin).max(-(self.tail as f32));
        let mut ringing = amplitude * exp(pole * first);
        // The filter starts at rest: what its output lacks of that dies out as the filter does.
        let at_begin = amplitude * exp(pole * begin);
        let own = Complex::new(-1.0, 1.0) * (CORNER / SQRT_2);
        let sine = at_begin.re + (at_begin * pole).re / own.im;
        let mut lacks = Complex::new(at_begin.re, -sine) * exp(own * (first - begin));
        let (turn, fade) = (exp(pole), exp(own));
        let skipped = (self.tail as f32 + first) as usize;
        for sample in samples.iter_mut().skip(skipped) {
            *sample -= ringing.re - lacks.re;
            ringing *= turn;
            lacks *= fade;
        }
    }
}

#[cfg(test)]
mod tests;
