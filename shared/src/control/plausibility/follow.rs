//! The cart's measured amplitude and lag against the command.

use crate::model::cart::CartDrive;
use crate::sense::Strobe;
use crate::sense::harmonic::Fundamental;
use crate::settings::Settings;

/// Drive periods in a row, in which the cart does not follow, that trip.
pub const BAD_PERIODS: u8 = 4;
/// Least measured amplitude, as a share of the command.
pub const LEAST_FOLLOW: f32 = 0.7;
/// Measured over commanded amplitude, as a share of what it was before at this frequency.
pub const STEP_RANGE: (f32, f32) = (0.85, 1.3);
/// Largest lag of the cart behind the command, either way, rad: 120°, where the rig's position loop is not known. Hardly one
/// is that late; a sensor with reversed polarity shows 180°.
pub const LARGEST_LAG: f32 = 2.094;
/// Largest lag of the cart, either way, beyond that of the rig's own loop, where that is known, rad: 45°. Amplifier and
/// sensor of a healthy rig add 16° at 13 Hz.
pub const LARGEST_MORE_LAG: f32 = core::f32::consts::FRAC_PI_4;
/// The loop's natural frequency is known within this factor.
const LOOP_SPREAD: f32 = 1.25;
/// A command below this share of A0 is not judged.
const LEAST_COMMAND: f32 = 0.1;
/// Relative change of frequency after which the response of the shaker is another one.
const ELSEWHERE: f32 = 0.03;
/// Drive periods at a frequency before the response there is known.
const LEARNT: u8 = 8;
/// Share of a new period in what is known of the response.
const LEARNS: f32 = 1.0 / 16.0;

/// How the cart follows.
#[derive(Clone, Copy, Debug)]
pub(super) struct CartFollowing {
    least_m: f32,
    lateness: Lateness,
    /// Frequency, Hz, at which the response was learnt, the response, and from how many periods.
    learnt_hz: f32,
    response: f32,
    learnt: u8,
    weak: u8,
    step: u8,
    late: u8,
}

impl CartFollowing {
    pub fn new(settings: &Settings) -> Self {
        Self {
            least_m: LEAST_COMMAND * settings.rig.amplitude_m as f32,
            lateness: Lateness::of(&settings.rig.cart),
            learnt_hz: 0.0,
            response: 1.0,
            learnt: 0,
            weak: 0,
            step: 0,
            late: 0,
        }
    }

    pub fn restart(&mut self) {
        self.learnt = 0;
        self.weak = 0;
        self.step = 0;
        self.late = 0;
    }

    /// Whether the last periods were out of their range.
    pub fn doubts(&self) -> bool {
        self.weak > 0 || self.step > 0 || self.late > 0
    }

    /// A drive period; what trips: the ratio of measured to commanded amplitude, or the lag, rad.
    pub fn strobe(
        &mut self,
        strobe: &Strobe,
        command_m: f32,
        frequency_hz: f32,
        rising: bool,
    ) -> Option<f32> {
        if command_m < self.least_m || command_m <= 0.0 {
            return None;
        }
        let ratio = strobe.amplitude_m / command_m;
        let late = self.lateness.is_beyond(strobe.lag_rad, frequency_hz);
        // Without motion there is no lag.
        if super::run(&mut self.late, late && ratio > 0.3, BAD_PERIODS) {
            return Some(strobe.lag_rad);
        }
        // Written so that NaN is weak.
        let follows = ratio >= LEAST_FOLLOW;
        if super::run(&mut self.weak, !follows, BAD_PERIODS) {
            return Some(ratio);
        }
        if rising {
            self.learnt = 0;
            return None;
        }
        self.steps(ratio, frequency_hz).then_some(ratio)
    }

    /// Compares with the response learnt at this frequency, or learns it.
    fn steps(&mut self, ratio: f32, frequency_hz: f32) -> bool {
        let moved = libm::fabsf(frequency_hz - self.learnt_hz) > ELSEWHERE * self.learnt_hz;
        if moved || self.learnt == 0 {
            self.learnt_hz = frequency_hz;
            self.learnt = 1;
            self.response = ratio;
            self.step = 0;
            return false;
        }
        if self.learnt < LEARNT {
            self.learnt += 1;
            self.response += 0.5 * (ratio - self.response);
            return false;
        }
        let (low, high) = STEP_RANGE;
        let same = ratio >= low * self.response && ratio <= high * self.response;
        if same {
            self.response += LEARNS * (ratio - self.response);
        }
        super::run(&mut self.step, !same, BAD_PERIODS)
    }
}

/// How late the cart may be.
#[derive(Clone, Copy, Debug)]
enum Lateness {
    /// Its loop is not known.
    Unknown,
    /// A loop of this natural frequency, Hz, with twice its damping ratio and what its feed-forward lacks of the whole.
    Loop { hz: f32, damping: f32, lacks: f32 },
}

impl Lateness {
    fn of(cart: &CartDrive) -> Self {
        match cart {
            CartDrive::Prescribed => Self::Unknown,
            CartDrive::Loop(held) => Self::Loop {
                hz: held.frequency_hz as f32,
                damping: 2.0 * held.damping_ratio as f32,
                lacks: 1.0 - held.feed_forward as f32,
            },
        }
    }

    /// Whether a cart at `hz` is later than it may be, or as much too early.
    fn is_beyond(&self, lag_rad: f32, hz: f32) -> bool {
        let Self::Loop {
            hz: own_hz,
            damping,
            lacks,
        } = *self
        else {
            return libm::fabsf(lag_rad) > LARGEST_LAG;
        };
        // y/y* = (1 − φ r² + 2jζr)/(1 − r² + 2jζr), r the frequency over the loop's.
        let lag = |r: f32| {
            let (square, damped) = (r * r, damping * r);
            let own = 1.0 - square;
            Fundamental {
                sine: (own + lacks * square) * own + damped * damped,
                cosine: -damped * lacks * square,
            }
            .lag_rad()
        };
        let r = hz / own_hz;
        let (swift, slow) = (lag(r / LOOP_SPREAD), lag(r * LOOP_SPREAD));
        let half = 0.5 * (slow - swift);
        let more = lag_rad - swift - half;
        // Within half a turn.
        let turns = more * (0.5 * core::f32::consts::FRAC_1_PI);
        let more = core::f32::consts::TAU * (turns - libm::floorf(turns + 0.5));
        libm::fabsf(more) > libm::fabsf(half) + LARGEST_MORE_LAG
    }
}
