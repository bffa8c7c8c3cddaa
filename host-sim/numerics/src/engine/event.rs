//! The reference behind the engines' interface.

use shared::model::contacts::Period;
use shared::model::params::RigParams;
use shared::model::rig::Rig;

use super::{CycleRecorder, Machine, RecordedSample};
use crate::error::Error;
use crate::reference::{LocatedContact, Reference, Segment, TrajectoryObserver};

/// The reference at coordinate and rate `section` with the cart `deviation` (m, m/s) off its course, at drive `phase`
/// (turns).
pub fn machine(
    params: &RigParams,
    frequency_hz: f64,
    section: [f64; 2],
    deviation: [f64; 2],
    phase: f64,
) -> Result<Box<dyn Machine>, Error> {
    let hammer = Reference::<f64>::new(params, frequency_hz, section[0], section[1])?;
    let hammer = hammer.with_cart(deviation).from_phase(phase);
    Ok(Box::new(Event {
        hammer,
        frequency_hz,
    }))
}

struct Event {
    hammer: Reference<f64>,
    frequency_hz: f64,
}

impl Machine for Event {
    fn period(&mut self, recorder: Option<&mut CycleRecorder>) -> Period<f64> {
        match recorder {
            Some(recorder) => {
                let mut sampler = Sampler {
                    frequency_hz: self.frequency_hz,
                    recorder,
                    next: 0,
                };
                self.hammer.run_period(&mut sampler)
            }
            None => self.hammer.run_period(&mut ()),
        }
    }
    fn section(&self) -> [f64; 2] {
        self.hammer.state().into()
    }
    fn rig(&self) -> &Rig<f64> {
        self.hammer.rig()
    }
    fn frequency_hz(&self) -> f64 {
        self.frequency_hz
    }
}

/// Samples the smooth pieces of one period of the reference: evenly, and a few times per piece in contact, which
/// is over long before the next even sample.
struct Sampler<'a> {
    frequency_hz: f64,
    recorder: &'a mut CycleRecorder,
    /// Which even sample of the period is next.
    next: usize,
}

impl TrajectoryObserver for Sampler<'_> {
    fn segment(&mut self, segment: &Segment) {
        let (per_period, evenly) = (self.recorder.samples_per_period, self.recorder.evenly);
        if per_period == 0 {
            return;
        }
        let mut take = |t: f64| {
            let (q, v) = segment.at(t);
            let turns = segment.cycle as f64 + t * self.frequency_hz;
            let force = segment.force(q, v);
            let cart = segment.cart(t);
            let sample =
                RecordedSample::new(segment.rig, self.frequency_hz, turns, (q, v), cart, force);
            self.recorder.samples.push(sample);
        };
        let (start, end) = (segment.start.t, segment.end.t);
        let dense = !evenly && segment.mode == shared::model::rig::SwitchMode::Contact;
        if dense {
            const PIECES: usize = 24;
            (0..=PIECES).for_each(|i| take(start + (end - start) * i as f64 / PIECES as f64));
        }
        let spacing = 1.0 / (self.frequency_hz * per_period as f64);
        while self.next < per_period && self.next as f64 * spacing < end {
            if !dense {
                take(self.next as f64 * spacing);
            }
            self.next += 1;
        }
    }

    fn contact(&mut self, contact: &LocatedContact) {
        self.recorder.contacts.push(*contact);
    }
}
