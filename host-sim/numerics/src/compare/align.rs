//! The drive's frequency and phase in a record.

use std::f64::consts::TAU;

use super::{ComparisonRequest, FrequencySource, MeasuredFrame, SimulatedMotion};
use crate::error::{Error, RecordError};
use crate::identify::{EVERY_CONTACT, measure};
use crate::root::maximum;
use crate::signal::Signal;

/// Samples that are compared when a shift or a pitch is tried, at most.
const TRIED_SAMPLES: usize = 2000;

/// Of these in the shortest period looked for, at least.
const TRIED_PER_PERIOD: f64 = 4.0;

/// Samples of a force that are compared when a shift is tried, at most.
const TRIED_FORCES: usize = 100_000;

/// Shifts tried per drive period.
const SHIFTS: u32 = 160;

/// The hammer may answer at a fraction of the drive: multiples of its pitch that are tried as the drive.
const MULTIPLES: u32 = 4;

/// Drive frequencies to try, Hz, and where they are from.
pub fn drive(
    signal: &Signal,
    question: &ComparisonRequest,
) -> Result<(Vec<f64>, FrequencySource), Error> {
    if let Some(frequency_hz) = question.frequency_hz {
        return Ok((vec![frequency_hz], FrequencySource::Given));
    }
    let natural = question.params.natural_frequency_hz();
    let range = (0.3 * natural, 12.0 * natural);
    if let Some(cart) = &signal.cart_mm {
        let (hz, explained) = pitch(&signal.time_s, cart, range);
        if explained > 0.5 {
            return Ok((vec![hz], FrequencySource::Cart));
        }
        if moves(cart, question) {
            return Err(signal.lacks(RecordError::UnsteadyCart));
        }
    }
    let slowest = (0.3 * natural / f64::from(MULTIPLES), range.1);
    let base = match (&signal.displacement_mm, &signal.force_n) {
        (Some(displacement), _) => pitch(&signal.time_s, displacement, slowest).0,
        (None, Some(_)) => contacts_per_second(signal)?,
        (None, None) => {
            return Err(signal.lacks(RecordError::NothingToCompare));
        }
    };
    Ok((
        (1..=MULTIPLES).map(|k| base * f64::from(k)).collect(),
        FrequencySource::Record,
    ))
}

/// Whether the cart moves at all: a column that no sensor stands behind holds noise.
fn moves(cart: &[f64], question: &ComparisonRequest) -> bool {
    let n = cart.len() as f64;
    let mean = cart.iter().sum::<f64>() / n;
    let rms = (cart.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / n).sqrt();
    rms > 0.1 * question.params.amplitude_m * 1e3
}

/// Contacts per second in the force record, Hz.
fn contacts_per_second(signal: &Signal) -> Result<f64, Error> {
    let impacts = measure(signal, &EVERY_CONTACT)?.impacts;
    let (Some(first), Some(last)) = (impacts.first(), impacts.last()) else {
        return Err(signal.lacks(RecordError::NoContacts));
    };
    if impacts.len() < 3 {
        return Err(signal.lacks(RecordError::FewContacts(impacts.len())));
    }
    Ok((impacts.len() - 1) as f64 / (last.at_s - first.at_s))
}

/// The frequency (Hz, within `range`) of the sinusoid that explains most of `values`, and the share of their
/// variance it explains.
///
/// The first part of a long record tells it coarsely, and ever longer parts finely: what is tried of the whole record
/// stands too far apart to tell a frequency from a faster one.
pub fn pitch(times: &[f64], values: &[f64], mut range: (f64, f64)) -> (f64, f64) {
    let begin = times.first().unwrap_or(&0.0);
    let mut part_s = TRIED_SAMPLES as f64 / (TRIED_PER_PERIOD * range.1);
    loop {
        let count = times.partition_point(|t| t - begin <= part_s);
        let every = count.div_ceil(TRIED_SAMPLES).max(1);
        let kept =
            |all: &[f64]| -> Vec<f64> { all[..count].iter().step_by(every).copied().collect() };
        let (few, values) = (kept(times), kept(values));
        let share = |hz: f64| Swing::new(&few, &values, hz).explained;
        let span = few.last().map_or(1.0, |t| t - begin);
        let step = 0.2 / span;
        let count_hz = (((range.1 - range.0) / step) as usize).clamp(1, 20_000);
        let at = |i: usize| range.0 + (range.1 - range.0) * i as f64 / count_hz as f64;
        let tried = (0..=count_hz).map(at);
        let best = tried.max_by(|a, b| share(*a).total_cmp(&share(*b)));
        let best = best.unwrap_or(range.0);
        let near = ((best - step).max(range.0), (best + step).min(range.1));
        let fine = (1e-6 * best).min(1e-3 / span);
        let hz = maximum(share, near, fine, best);
        if count == times.len() {
            return (hz, share(hz));
        }
        range = near;
        part_s *= 10.0;
    }
}

/// The sinusoid c cos Ωt + s sin Ωt, about a mean, that is closest to a record by least squares.
struct Swing {
    cosine: f64,
    sine: f64,
    /// Share of the record's variance it explains.
    explained: f64,
}

impl Swing {
    fn new(times: &[f64], values: &[f64], hz: f64) -> Self {
        let n = times.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let (mut cc, mut cs, mut ss, mut c1, mut s1) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (mut cy, mut sy, mut yy) = (0.0, 0.0, 0.0);
        for (t, y) in times.iter().zip(values) {
            let (s, c) = (TAU * hz * t).sin_cos();
            cc += c * c;
            cs += c * s;
            ss += s * s;
            c1 += c;
            s1 += s;
            cy += c * (y - mean);
            sy += s * (y - mean);
            yy += (y - mean).powi(2);
        }
        // With the mean free, too.
        let (cc, cs, ss) = (cc - c1 * c1 / n, cs - c1 * s1 / n, ss - s1 * s1 / n);
        let determinant = cc * ss - cs * cs;
        if determinant <= 1e-9 * cc * ss {
            return Self {
                cosine: 0.0,
                sine: 0.0,
                explained: 0.0,
            };
        }
        let cosine = (cy * ss - sy * cs) / determinant;
        let sine = (sy * cc - cy * cs) / determinant;
        Self {
            cosine,
            sine,
            explained: (cosine * cy + sine * sy) / yy,
        }
    }
}

/// What is to be added to the record's times so that it lies best over the simulation, s, and the misfit there
/// (the share of the record's square that is left).
pub fn shift(signal: &Signal, simulated: &SimulatedMotion, frame: MeasuredFrame) -> (f64, f64) {
    let period = 1.0 / simulated.frequency_hz;
    let misfit = |shift: f64| left(signal, simulated, frame, shift);
    let least = |tried: &mut dyn Iterator<Item = f64>| {
        tried
            .map(|s| (s, misfit(s)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((0.0, f64::INFINITY))
    };
    // The cart's own phase leaves whole periods open.
    if let Some(phase) = signal
        .cart_mm
        .as_ref()
        .and_then(|cart| cart_swing(signal, cart, simulated.frequency_hz))
        .map(|(_, phase)| phase)
    {
        let each = (0..simulated.periods).map(|k| (phase + f64::from(k)) * period);
        return least(&mut { each });
    }
    let (near, step) = match signal.displacement_mm {
        Some(_) => {
            let count = simulated.periods * SHIFTS;
            let step = period / f64::from(SHIFTS);
            (least(&mut (0..count).map(|i| f64::from(i) * step)).0, step)
        }
        None => match by_contacts(signal, simulated) {
            Some((tried, step)) => (least(&mut tried.into_iter()).0, step),
            None => return (0.0, misfit(0.0)),
        },
    };
    let best = maximum(
        |s| -misfit(s),
        (near - step, near + step),
        1e-4 * step,
        near,
    );
    (best.rem_euclid(simulated.span_s()), misfit(best))
}

/// Shifts that lay a contact in the middle of a force record over each of the simulation's, and how far off they may be
/// (half a contact), s. A contact is far shorter than a [`SHIFTS`]th of a period: it would be missed.
fn by_contacts(signal: &Signal, simulated: &SimulatedMotion) -> Option<(Vec<f64>, f64)> {
    let measured = measure(signal, &EVERY_CONTACT).ok()?;
    let middle = measured.impacts.get(measured.impacts.len() / 2)?;
    let contacts = simulated.contacts(measured.threshold_n);
    let half = 0.5 * simulated.contact_time_s(measured.threshold_n)?;
    let shifts = contacts.iter().map(|contact| contact.0 - middle.at_s);
    Some((shifts.collect(), half.max(measured.sample_s)))
}

/// The cart's amplitude (mm) and the drive's phase at the record's time 0 (turns), from its motion y = A0 sin Ωt.
pub fn cart_swing(signal: &Signal, cart: &[f64], hz: f64) -> Option<(f64, f64)> {
    let swing = Swing::new(&signal.time_s, cart, hz);
    let phase = (swing.cosine.atan2(swing.sine) / TAU).rem_euclid(1.0);
    (swing.explained > 0.5).then(|| (swing.cosine.hypot(swing.sine), phase))
}

/// Share of the record's square about its mean that a shift leaves: of the displacement, or else of the force.
fn left(signal: &Signal, simulated: &SimulatedMotion, frame: MeasuredFrame, shift: f64) -> f64 {
    let values = signal.displacement_mm.as_ref().or(signal.force_n.as_ref());
    let Some(values) = values else {
        return f64::INFINITY;
    };
    let by_force = signal.displacement_mm.is_none();
    // A force is short: no sample of it may be passed over, so that the middle of the record must do.
    let (from, every) = if by_force {
        (values.len().saturating_sub(TRIED_FORCES) / 2, 1)
    } else {
        (0, values.len().div_ceil(TRIED_SAMPLES))
    };
    let most = if by_force { TRIED_FORCES } else { usize::MAX };
    let all = signal.time_s.iter().zip(values).skip(from).take(most);
    let pairs: Vec<(f64, f64)> = all
        .step_by(every)
        .map(|(t, y)| {
            let at = simulated.at(t + shift, frame);
            (
                *y,
                if by_force {
                    at.force_n
                } else {
                    at.displacement_mm
                },
            )
        })
        .collect();
    let n = pairs.len() as f64;
    let mean = pairs.iter().map(|p| p.0).sum::<f64>() / n;
    let bias = pairs.iter().map(|p| p.1 - p.0).sum::<f64>() / n;
    let all = pairs.iter().map(|p| (p.0 - mean).powi(2)).sum::<f64>();
    let apart = pairs
        .iter()
        .map(|p| (p.1 - p.0 - bias).powi(2))
        .sum::<f64>();
    apart / all
}

/// The rate of `values` by a least-squares line through the samples within `half_s` of each.
pub fn rate(times: &[f64], values: &[f64], half_s: f64) -> Vec<f64> {
    let slope = |i: usize| {
        let from = times
            .partition_point(|t| *t < times[i] - half_s)
            .min(i.saturating_sub(1));
        let to = times
            .partition_point(|t| *t <= times[i] + half_s)
            .max(i + 2)
            .min(times.len());
        let n = (to - from) as f64;
        let mean_t = times[from..to].iter().map(|t| t - times[i]).sum::<f64>() / n;
        let mean_y = values[from..to].iter().sum::<f64>() / n;
        let (mut tt, mut ty) = (0.0, 0.0);
        for (t, y) in times[from..to].iter().zip(&values[from..to]) {
            let d = t - times[i] - mean_t;
            tt += d * d;
            ty += d * (y - mean_y);
        }
        ty / tt
    };
    (0..times.len()).map(slope).collect()
}
