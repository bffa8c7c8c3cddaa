//! The forecast's march: long steps in flight, short ones in contact, switches located in between.
//!
//! The drive's tick is a 32nd of its period, so every period starts exactly at phase 0 and none is ever
//! split by a strobe. Within a tick time is a fraction, whose grain in `f32` is below a nanosecond. A step
//! never passes the end of a tick, nor a switch.
//!
//! In flight the motion is smooth on the scale of a period. At a switch the step falls back to a
//! fraction of the contact's own time scale; it doubles from step to step once the hammer is free again,
//! and grows slowly in a contact that lasts, up to what Runge–Kutta keeps stable. Under the nonlinear laws δⁿ is
//! not smooth where the contact begins and ends: there no step is longer than half the time δ took to come.
//!
//! A cart that recoils rings after each contact. The steps follow that first and grow as it dies away, so that the error of
//! each stays the same, again up to what Runge–Kutta keeps stable.

use core::f32::consts::{PI, TAU};

use crate::model::cart::{Cart, CartDrive, LoopParams};
use crate::model::contact::Law;
use crate::model::contacts::{Ledger, Period};
use crate::model::drive::{Drive, Stamp};
use crate::model::params::{ParamError, RigParams};
use crate::model::rig::{Rig, SwitchMode};
use crate::model::scalar::Real;
use crate::model::step::{Corrected, HammerState, Location, Span, piece};
use crate::model::tangent::Tangent;

/// Steps per drive period in flight.
pub const STEPS_PER_PERIOD: u32 = 32;

/// Angle of a tick, rad.
const TICK_RAD: f32 = TAU / STEPS_PER_PERIOD as f32;

/// Steps in contact, in units of the contact's time scale 1/λ ([`contact_rate`]): 47 µs for Table 3.1 on
/// 0.298 kg.
const CONTACT_STEP: f32 = 0.2;

/// The longest step in a contact that lasts, in the same unit.
const LONGEST_CONTACT_STEP: f32 = 1.0;

/// Steps of unchanged length at the beginning of a contact: more than a usual contact takes.
const STEPS_OF_A_CONTACT: u16 = 40;

/// [`STEPS_OF_A_CONTACT`] of the nonlinear laws: some steps are shorter, and Hunt–Crossley's hammer leaves slowly.
const STEPS_OF_A_NONLINEAR_CONTACT: u16 = 80;

/// The shortest step under the nonlinear laws, as a share of the usual one in contact.
const SHORTEST_STEP: f32 = 1.0 / 32.0;

/// Steps while the cart rings, in units of its loop's time scale 1/λ ([`loop_rate`]).
const RINGING_STEP: f32 = 0.3;

/// The longest step with a cart that recoils, in the same unit.
const LONGEST_RINGING_STEP: f32 = 1.5;

/// The error of a step goes with its fifth power and with what is left of the ringing, which falls by ζ times the step.
const RINGING_GROWTH: f32 = RINGING_STEP / 5.0;

/// Approach speed of a typical contact in units of A0 ω, for laws whose time scale depends on it.
const CONTACT_SPEED: f64 = 5.0;

/// Switches are located to this share of a tick, unless the iterations run out first.
const LOCATION: Location = Location {
    iterations: 7,
    settled: 2e-5,
};

/// A point of the section: coordinate and rate of the hammer, deviation of the cart from its course and its rate.
pub type ForecastSection = [f32; 4];

/// λ, 1/s: the faster of the contact's oscillation, v/δ_max of a typical contact (√(ki/m) for the linear
/// spring), and its damper's decay ci/m, m being [`RigParams::contact_mass_kg`].
fn contact_rate(params: &RigParams) -> f64 {
    let (stiffness, n) = (params.contact.stiffness(), params.contact.exponent());
    let omega = core::f64::consts::TAU * params.natural_frequency_hz();
    let speed = CONTACT_SPEED * params.amplitude_m * omega;
    let mass_kg = params.contact_mass_kg();
    let energy = 0.5 * mass_kg * speed * speed;
    let deepest = libm::pow((n + 1.0) * energy / stiffness, 1.0 / (n + 1.0));
    let (_, damping) = params.contact.gradient(deepest, 0.0, speed);
    Real::max(speed / deepest, damping / mass_kg)
}

/// λ, 1/s: the larger of the moduli of the roots of s² + 2 ζ ω s + ω².
fn loop_rate(held: &LoopParams) -> f64 {
    core::f64::consts::TAU * held.frequency_hz * held.swiftness()
}

/// How the cart is held, in the numbers the forecast needs.
#[derive(Clone, Copy, Debug)]
struct Held {
    cart: Cart<f32>,
    rate: f32,
    /// Growth of the steps while it rings.
    growth: f32,
}

impl Held {
    fn of(params: &RigParams) -> Option<Self> {
        let CartDrive::Loop(held) = &params.cart else {
            return None;
        };
        let damping = Real::min(held.damping_ratio as f32, 1.0);
        Some(Self {
            cart: Cart::of(params)?,
            rate: loop_rate(held) as f32,
            growth: 1.0 + RINGING_GROWTH * damping,
        })
    }
}

/// A rig in the numbers the forecast needs: worked out once, since that takes `f64`.
#[derive(Clone, Copy, Debug)]
pub struct ForecastModel {
    /// The rig in plain numbers, for the march.
    pub rig: Rig<f32>,
    /// The rig in numbers with derivatives, for the linearised motion.
    pub tangent: Rig<Tangent>,
    contact_rate: f32,
    held: Option<Held>,
}

impl ForecastModel {
    /// The model of `params`.
    ///
    /// # Errors
    /// If a parameter is out of range: the first such.
    pub fn new(params: &RigParams) -> Result<Self, ParamError> {
        Ok(Self {
            rig: Rig::new(params)?,
            tangent: Rig::new(params)?,
            contact_rate: contact_rate(params) as f32,
            held: Held::of(params),
        })
    }
}

/// A drive frequency, with the step lengths that suit it.
#[derive(Clone, Copy, Debug)]
pub struct Setup {
    /// The rig in plain numbers.
    pub rig: Rig<f32>,
    /// The drive at phase 0, a 32nd of a period per tick.
    pub drive: Drive<f32>,
    /// Amplitude A0 Ω² of the cart's acceleration, m/s².
    pub drive_acceleration: f32,
    /// The cart, if it recoils.
    pub cart: Option<Cart<f32>>,
    /// Units of the section: A0 and A0 Ω in the coordinate's units, and in m and m/s.
    pub units: ForecastSection,
    /// Steps per drive period at most that a cart that recoils adds.
    pub ringing_steps: u16,
    /// First and longest step in contact, as fractions of the tick.
    contact_steps: (f32, f32),
    /// First and longest step in flight once they no longer double, as fractions of the tick, and the growth between them.
    flight_steps: (f32, f32),
    flight_growth: f32,
    /// Whether the force grows with a power of δ.
    nonlinear: bool,
}

impl Setup {
    /// `model` driven at `frequency_hz`. `None` if no drive can run at that frequency.
    pub fn new(model: &ForecastModel, frequency_hz: f32) -> Option<Self> {
        let rig = model.rig;
        let hz = f64::from(frequency_hz);
        let drive = Drive::new(hz, 1.0 / (hz * f64::from(STEPS_PER_PERIOD))).ok()?;
        let omega = TAU * frequency_hz;
        let unit = 1.0 / (model.contact_rate * drive.tick_s());
        let limit = |x: f32| if x < 0.5 { x } else { 0.5 };
        let (scale, amplitude) = (rig.coordinate_scale(), rig.amplitude());
        let (flight_steps, flight_growth) = match &model.held {
            None => ((1.0, 1.0), 1.0),
            Some(held) => {
                let unit = 1.0 / (held.rate * drive.tick_s());
                let within = |x: f32| Real::min(x * unit, 1.0);
                let steps = (within(RINGING_STEP), within(LONGEST_RINGING_STEP));
                (steps, held.growth)
            }
        };
        let ticks = STEPS_PER_PERIOD as f32;
        let ringing = ticks / flight_steps.0 - ticks;
        Some(Self {
            rig,
            drive,
            drive_acceleration: rig.amplitude() * (omega * omega),
            cart: model.held.as_ref().map(|held| held.cart),
            units: [scale, scale * omega, amplitude, amplitude * omega],
            ringing_steps: ringing as u16,
            contact_steps: (
                limit(CONTACT_STEP * unit),
                limit(LONGEST_CONTACT_STEP * unit),
            ),
            flight_steps,
            flight_growth,
            nonlinear: !matches!(rig.law(), Law::SpringDashpot { .. }),
        })
    }
}

/// A step of the march: enough to repeat it in tangent numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarchStep {
    /// The part of the tick it spans.
    pub part: (f32, f32),
    /// Whether it ended on a switch, which has been crossed.
    pub switched: bool,
    /// Whether the tick ended with it.
    pub tick_ended: bool,
    /// Whether the drive period ended with it.
    pub period_ended: bool,
}

/// The latest contact, noted beside the contact record.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LatestContact {
    /// ∫F dt since the start, N·s.
    pub impulse_n_s: f32,
    /// The latest onset, and the penetration rate there, m/s.
    pub onset: Option<(Stamp, f32)>,
}

/// The fundamental of the cart's deviation from its course: the controller measures the phase at which the hammer strikes
/// against the cart's own motion.
#[derive(Clone, Copy, Debug, Default)]
struct Lead {
    /// ∫ e sin φ dφ and ∫ e cos φ dφ, m.
    sums: (f32, f32),
}

impl Lead {
    /// Adds a part of a tick with the cart's deviation and rate at both of its ends, by the trapezium rule corrected with
    /// the slopes there.
    fn add(&mut self, drive: &Drive<f32>, (from, to): (f32, f32), ends: ([f32; 2], [f32; 2])) {
        let rate = TICK_RAD / drive.tick_s();
        let at = |fraction: f32, [e, w]: [f32; 2]| {
            let (sin, cos) = drive.sin_cos_ahead(fraction);
            let slope = w / rate;
            (
                (e * sin, slope * sin + e * cos),
                (e * cos, slope * cos - e * sin),
            )
        };
        let (start, end) = (at(from, ends.0), at(to, ends.1));
        let span = (to - from) * TICK_RAD;
        let area = |(f0, s0): (f32, f32), (f1, s1): (f32, f32)| {
            span * (0.5 * (f0 + f1) + span * (1.0 / 12.0) * (s0 - s1))
        };
        self.sums.0 += area(start.0, end.0);
        self.sums.1 += area(start.1, end.1);
    }

    fn turns(&self, amplitude: f32) -> f32 {
        let (sine, cosine) = (self.sums.0 / PI, self.sums.1 / PI);
        Real::atan(cosine / (amplitude + sine)) / TAU
    }
}

/// The hammer on its march.
#[derive(Clone, Copy, Debug)]
pub struct March {
    setup: Setup,
    drive: Drive<f32>,
    state: HammerState<f32>,
    /// Where in the tick.
    at: f32,
    /// Length of the next step, in ticks.
    stride: f32,
    /// Whether the next step begins on a switch.
    fresh: bool,
    /// Steps since the onset.
    steps_in_contact: u16,
    ledger: Ledger<f32>,
    latest: LatestContact,
    /// The cart's lead, where it is asked for and the cart recoils.
    lead: Option<Lead>,
}

impl March {
    /// Starts at `section` at drive phase 0.
    pub fn new(setup: &Setup, section: ForecastSection) -> Self {
        let [q, v, e, w] = section;
        let state = HammerState {
            cart: [e, w],
            ..HammerState::new(&setup.rig, q, v)
        };
        let mut ledger = Ledger::default();
        let mut stride = setup.flight_steps.0;
        if state.mode == SwitchMode::Contact {
            ledger.resume(setup.drive.now(), state.approach);
            stride = setup.contact_steps.0;
        }
        Self {
            setup: *setup,
            drive: setup.drive,
            state,
            at: 0.0,
            stride,
            fresh: false,
            steps_in_contact: 0,
            ledger,
            latest: LatestContact::default(),
            lead: None,
        }
    }

    /// The rig and drive it was set up with.
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// Hammer and cart now.
    pub fn section(&self) -> ForecastSection {
        let [e, w] = self.state.cart;
        [self.state.q.hi, self.state.v.hi, e, w]
    }

    /// Starts at `section` at drive phase 0, and finds [`Self::lead_turns`] on the way.
    pub fn with_lead(setup: &Setup, section: ForecastSection) -> Self {
        Self {
            lead: setup.cart.map(|_| Lead::default()),
            ..Self::new(setup, section)
        }
    }

    /// By how much the cart leads its course, turns: the phase of its fundamental over the period so far.
    pub fn lead_turns(&self) -> f32 {
        let amplitude = self.setup.rig.amplitude();
        self.lead.as_ref().map_or(0.0, |lead| lead.turns(amplitude))
    }

    /// The latest onset, and the impulse since the start.
    pub fn latest_contact(&self) -> &LatestContact {
        &self.latest
    }

    /// Closes the contact record of the drive period that has just ended.
    pub fn close_period(&mut self) -> Period<f32> {
        let _ = self.ledger.take_finished();
        self.ledger.close_period()
    }

    /// One step. Bounded work: at most a dozen Runge–Kutta steps where a switch is located, one elsewhere.
    pub fn step(&mut self) -> MarchStep {
        let from = self.at;
        let to = from + self.stride;
        // A remainder of less than half a step is included in this one.
        let to = if to + 0.5 * self.stride >= 1.0 {
            1.0
        } else {
            to
        };
        let span = Span {
            drive: &self.drive,
            drive_acceleration: self.setup.drive_acceleration,
            cart: self.setup.cart.as_ref(),
            from,
            to,
        };
        let rig = &self.setup.rig;
        let leg = Corrected::leg(rig, &span, &self.state, self.fresh, LOCATION);
        if let Some(lead) = &mut self.lead {
            let ends = (self.state.cart, leg.moved.state.cart);
            lead.add(&self.drive, (from, leg.at), ends);
        }
        if self.state.mode == SwitchMode::Contact {
            let piece = piece(rig, &span, (from, leg.at), &self.state, &leg.moved);
            self.latest.impulse_n_s += piece.impulse;
            self.ledger.add(&piece);
        }
        self.state = leg.moved.state;
        if leg.switched {
            let rate = rig.kinematics(self.state.q.hi, self.state.v.hi).rate;
            let stamp = span.stamp(leg.at);
            match self.state.mode {
                // Moving away, with F near zero, where rounding decides: still the same contact.
                SwitchMode::Flight if self.setup.nonlinear && rate < 0.0 => {
                    self.state.mode = SwitchMode::Contact;
                    self.ledger.resume(stamp, self.state.approach);
                }
                SwitchMode::Flight => {
                    self.state.mode = SwitchMode::Contact;
                    self.state.approach = rate;
                    self.latest.onset = Some((stamp, rate));
                    self.ledger.onset(stamp, rate);
                }
                SwitchMode::Contact => {
                    self.state.mode = SwitchMode::Flight;
                    self.ledger.release(stamp, rate);
                }
            }
        }
        self.choose_stride(leg.switched);
        self.fresh = leg.switched;
        let tick_ended = leg.at >= 1.0;
        self.at = leg.at;
        if tick_ended {
            self.at = 0.0;
            self.drive.advance();
        }
        MarchStep {
            part: (from, leg.at),
            switched: leg.switched,
            tick_ended,
            period_ended: tick_ended && self.drive.now().phase == 0,
        }
    }

    fn choose_stride(&mut self, switched: bool) {
        let (mut first, longest) = self.setup.contact_steps;
        if self.setup.nonlinear && self.state.mode == SwitchMode::Contact {
            first = self.half_the_depth(first);
        }
        if switched {
            self.stride = first;
            self.steps_in_contact = 0;
        } else if self.state.mode == SwitchMode::Flight {
            let (slow_from, longest) = self.setup.flight_steps;
            self.stride = if self.stride < slow_from {
                Real::min(2.0 * self.stride, slow_from)
            } else {
                Real::min(self.setup.flight_growth * self.stride, longest)
            };
        } else {
            self.steps_in_contact = self.steps_in_contact.saturating_add(1);
            let of_a_contact = if self.setup.nonlinear {
                STEPS_OF_A_NONLINEAR_CONTACT
            } else {
                STEPS_OF_A_CONTACT
            };
            self.stride = if self.steps_in_contact > of_a_contact {
                Real::min(1.25 * self.stride, longest)
            } else {
                first
            };
        }
    }

    /// A step in which δ changes by half of itself, within limits; at most `usual`.
    fn half_the_depth(&self, usual: f32) -> f32 {
        let at = (self.setup.rig).kinematics(self.state.q.hi, self.state.v.hi);
        let half = 0.5 * at.delta / (libm::fabsf(at.rate) * self.drive.tick_s());
        // At δ̇ = 0 the quotient is NaN or infinite.
        if half < usual {
            Real::max(half, SHORTEST_STEP * usual)
        } else {
            usual
        }
    }
}
