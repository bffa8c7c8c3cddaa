//! Random numbers, and sensors that lie at random.

use emulator::scenario::{ScenarioAct, SensorDefect, SensorFault, Which};
use emulator::sensors::BadContactEnd;

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

/// A sensor fault of this kind; `strong_n` is the force of a strong 1/1.
pub fn sensor_fault(kind: Kind, strong_n: f64, r: &mut Random) -> ScenarioAct {
    let one = r.one(&[Which::Force, Which::Hammer, Which::Cart]);
    // Half of them stay.
    let stays = r.below(2) == 0;
    let for_s = (!stays).then(|| r.within(0.5, 8.0));
    let (length, force) = (one != Which::Force, one == Which::Force);
    let lie = |fault| SensorFault {
        sensor: one,
        fault,
        for_s,
        ..SensorFault::default()
    };
    ScenarioAct::SensorFault(match kind {
        Kind::Short => {
            let how = r.one(&[
                SensorDefect::Open,
                SensorDefect::Saturated,
                SensorDefect::SaturatedLow,
                SensorDefect::Frozen,
            ]);
            SensorFault {
                for_s: Some(r.within(1e-4, 2.0)),
                ..lie(how)
            }
        }
        Kind::Gain => SensorFault {
            times: Some(r.within(0.3, 1.8)),
            ..lie(SensorDefect::Gain)
        },
        Kind::Common | Kind::Supply => {
            let sensor = r.one(&[Which::Displacements, Which::All]);
            let how = if kind == Kind::Common {
                SensorDefect::Gain
            } else {
                SensorDefect::Supply
            };
            SensorFault {
                sensor,
                times: Some(r.within(0.4, 1.4)),
                ..lie(how)
            }
        }
        Kind::GainDrift => SensorFault {
            percent_per_s: Some(r.within(-12.0, 12.0)),
            ..lie(SensorDefect::GainDrift)
        },
        Kind::Reversed => lie(SensorDefect::Reversed),
        Kind::Offset => {
            let (um, newtons) = (r.within(-1500.0, 1500.0), strong_n * r.within(-0.5, 0.5));
            SensorFault {
                offset_um: length.then_some(um),
                offset_n: force.then_some(newtons),
                ..lie(SensorDefect::Offset)
            }
        }
        Kind::OffsetDrift => {
            let (um, newtons) = (r.within(-300.0, 300.0), strong_n * r.within(-0.1, 0.1));
            SensorFault {
                drift_um_per_s: length.then_some(um),
                drift_n_per_s: force.then_some(newtons),
                ..lie(SensorDefect::OffsetDrift)
            }
        }
        Kind::Dead => {
            let (um, newtons) = (r.within(0.0, 60.0), strong_n * r.within(0.0, 0.04));
            SensorFault {
                noise_um: length.then_some(um),
                noise_n: force.then_some(newtons),
                ..lie(SensorDefect::Dead)
            }
        }
        Kind::Delayed => SensorFault {
            delay_ms: Some(r.within(0.1, 120.0)),
            ..lie(SensorDefect::Delayed)
        },
        _ => {
            let of = r.count(2, 400);
            let ticks = r.count(1, of + 1);
            SensorFault {
                ticks: Some(ticks),
                of: Some(of),
                at: Some(r.one(&[BadContactEnd::Open, BadContactEnd::High, BadContactEnd::Low])),
                ..lie(SensorDefect::Intermittent)
            }
        }
    })
}
