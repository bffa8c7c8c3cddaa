//! Random numbers, and sensors that lie at random.

use emulator::scenario::{Act, Fault, Which};
use emulator::sensors::End;

use super::draw::Kind;

/// Numbers from a number (splitmix64).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    pub fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn count(&mut self, from: u32, to: u32) -> u32 {
        from + self.below((to - from) as usize) as u32
    }
}

/// A sensor fault without its numbers.
fn fault(sensor: Which, fault: Fault, for_s: Option<f64>) -> Act {
    Act::SensorFault {
        sensor,
        fault,
        times: None,
        for_s,
        percent_per_s: None,
        offset_n: None,
        offset_um: None,
        drift_n_per_s: None,
        drift_um_per_s: None,
        noise_n: None,
        noise_um: None,
        delay_ms: None,
        ticks: None,
        of: None,
        at: None,
    }
}

/// A sensor fault of this kind; `strong_n` is the force of a strong 1/1.
pub fn sensor_fault(kind: Kind, strong_n: f64, r: &mut Random) -> Act {
    let one = r.one(&[Which::Force, Which::Hammer, Which::Cart]);
    // Half of them stay.
    let stays = r.below(2) == 0;
    let for_s = (!stays).then(|| r.within(0.5, 8.0));
    let numbers = |act: Act, set: &mut dyn FnMut(&mut Numbers)| {
        let mut numbers = Numbers::default();
        set(&mut numbers);
        numbers.put(act)
    };
    let (length, force) = (one != Which::Force, one == Which::Force);
    match kind {
        Kind::Short => {
            let how = r.one(&[
                Fault::Open,
                Fault::Saturated,
                Fault::SaturatedLow,
                Fault::Frozen,
            ]);
            fault(one, how, Some(r.within(1e-4, 2.0)))
        }
        Kind::Gain => {
            let times = r.within(0.3, 1.8);
            numbers(fault(one, Fault::Gain, for_s), &mut |n| {
                n.times = Some(times)
            })
        }
        Kind::Common | Kind::Supply => {
            let which = r.one(&[Which::Displacements, Which::All]);
            let how = if kind == Kind::Common {
                Fault::Gain
            } else {
                Fault::Supply
            };
            let times = r.within(0.4, 1.4);
            numbers(fault(which, how, for_s), &mut |n| n.times = Some(times))
        }
        Kind::GainDrift => {
            let rate = r.within(-12.0, 12.0);
            numbers(fault(one, Fault::GainDrift, for_s), &mut |n| {
                n.percent_per_s = Some(rate)
            })
        }
        Kind::Reversed => fault(one, Fault::Reversed, for_s),
        Kind::Offset => {
            let (um, newtons) = (r.within(-1500.0, 1500.0), strong_n * r.within(-0.5, 0.5));
            numbers(fault(one, Fault::Offset, for_s), &mut |n| {
                n.offset_um = length.then_some(um);
                n.offset_n = force.then_some(newtons);
            })
        }
        Kind::OffsetDrift => {
            let (um, newtons) = (r.within(-300.0, 300.0), strong_n * r.within(-0.1, 0.1));
            numbers(fault(one, Fault::OffsetDrift, for_s), &mut |n| {
                n.drift_um_per_s = length.then_some(um);
                n.drift_n_per_s = force.then_some(newtons);
            })
        }
        Kind::Dead => {
            let (um, newtons) = (r.within(0.0, 60.0), strong_n * r.within(0.0, 0.04));
            numbers(fault(one, Fault::Dead, for_s), &mut |n| {
                n.noise_um = length.then_some(um);
                n.noise_n = force.then_some(newtons);
            })
        }
        Kind::Delayed => {
            let ms = r.within(0.1, 120.0);
            numbers(fault(one, Fault::Delayed, for_s), &mut |n| {
                n.delay_ms = Some(ms)
            })
        }
        _ => {
            let of = r.count(2, 400);
            let ticks = r.count(1, of + 1);
            let at = r.one(&[End::Open, End::High, End::Low]);
            numbers(fault(one, Fault::Intermittent, for_s), &mut |n| {
                n.ticks = Some(ticks);
                n.of = Some(of);
                n.at = Some(at);
            })
        }
    }
}

/// The numbers of a sensor fault.
#[derive(Default)]
struct Numbers {
    times: Option<f64>,
    percent_per_s: Option<f64>,
    offset_n: Option<f64>,
    offset_um: Option<f64>,
    drift_n_per_s: Option<f64>,
    drift_um_per_s: Option<f64>,
    noise_n: Option<f64>,
    noise_um: Option<f64>,
    delay_ms: Option<f64>,
    ticks: Option<u32>,
    of: Option<u32>,
    at: Option<End>,
}

impl Numbers {
    fn put(self, act: Act) -> Act {
        match act {
            Act::SensorFault {
                sensor,
                fault,
                for_s,
                ..
            } => Act::SensorFault {
                sensor,
                fault,
                for_s,
                times: self.times,
                percent_per_s: self.percent_per_s,
                offset_n: self.offset_n,
                offset_um: self.offset_um,
                drift_n_per_s: self.drift_n_per_s,
                drift_um_per_s: self.drift_um_per_s,
                noise_n: self.noise_n,
                noise_um: self.noise_um,
                delay_ms: self.delay_ms,
                ticks: self.ticks,
                of: self.of,
                at: self.at,
            },
            act => act,
        }
    }
}
