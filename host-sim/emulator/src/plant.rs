//! The plant: a tick of true motion, switches located, contacts kept.
//!
//! In flight a tick is one step of order 4; in contact a step is at most a tenth of a tick, and ends on a
//! tenth (so that the force sensor's filter has its samples). Both switches are located by bisection on steps
//! of the integrator itself, to [`TIME_TOLERANCE_S`].

mod contacts;
mod drilling;
mod rest;

use std::f64::consts::TAU;

use numerics::root::narrowed;
use shared::model::params::{GRAVITY_M_PER_S2, ParamError, RigParams};
use shared::model::rig::{Kinematics, Rig, SwitchMode};

use super::bodies::{BodiesState, PlantBodies, PlantTotals};
use super::cart::{Friction, Mounting};
use super::motor::Motor;
use super::record::TrueContact;
#[doc(inline)]
pub use super::shaker::ShakerDrive;
use super::shaker::{Gains, Loop, SetPointPath};
use rest::{rest, upright};

/// Force samples per tick; also the steps per tick in contact, 5 µs each at 20 kHz.
pub const INNER: usize = 10;

/// Switches are located to this, s.
pub const TIME_TOLERANCE_S: f64 = 1e-13;

/// Switches in a tick after which the side of the switch is kept to its end: a hammer that rests on the very
/// edge of the surface.
const MAX_SWITCHES: usize = 64;

/// Contacts shorter than this, and switches closer together, are rounding and are ignored, s.
const SHORTEST_S: f64 = 1e-12;

/// A largest force within a contact: what makes the surface ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantBlow {
    /// When, s into the tick.
    pub at_s: f64,
    /// Contact force at this maximum, N.
    pub peak_n: f64,
}

/// Hammer, cart and shaker.
#[derive(Clone, Debug)]
pub struct Plant {
    bodies: PlantBodies,
    state: BodiesState,
    /// Where `state` has the hammer, and the clearance that goes with it.
    at: Kinematics<f64>,
    gap_m: f64,
    tick_s: f64,
    ticks: u64,
    totals: PlantTotals,
    open: Option<TrueContact>,
    rising: bool,
    inner: [f64; INNER],
    touched: bool,
    finished: Vec<TrueContact>,
    blows: Vec<PlantBlow>,
    progress_m: f64,
}

impl Plant {
    /// At rest, the drive off, moved by `drive`, with its cart mounted so. A tick lasts `tick_s`.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn mounted(
        params: &RigParams,
        drive: &ShakerDrive,
        mounting: &Mounting,
        tick_s: f64,
    ) -> Result<Self, ParamError> {
        let shaker = match drive {
            ShakerDrive::Shaker(shaker) => Loop::Force(Gains::new(shaker, params.cart_mass_kg)),
            ShakerDrive::Prescribed => Loop::Prescribed,
            ShakerDrive::Motor(motor) => Loop::Crank(Motor::new(motor)),
        };
        let rig = Rig::new(&upright(params, mounting.tilt_rad))?;
        let along = GRAVITY_M_PER_S2 * mounting.tilt_rad.sin();
        let state = rest(&rig, &shaker, params, along);
        let mut plant = Self {
            bodies: PlantBodies {
                rig,
                cart_mass_kg: params.cart_mass_kg,
                shaker,
                mounting: *mounting,
                ground: None,
                along,
                wanted_rad_s: 0.0,
                path: SetPointPath::default(),
                on: false,
                mode: SwitchMode::Flight,
                approach: 0.0,
            },
            state,
            at: rig.kinematics(state.q, state.v),
            gap_m: params.gap_m,
            tick_s,
            ticks: 0,
            totals: PlantTotals::default(),
            open: None,
            rising: false,
            inner: [0.0; INNER],
            touched: false,
            finished: Vec::with_capacity(4),
            blows: Vec::with_capacity(4),
            progress_m: 0.0,
        };
        if plant.bodies.indicator(&plant.state) > 0.0 {
            plant.begin_contact(0.0);
        }
        Ok(plant)
    }

    /// This plant with ticks of `tick_s` seconds.
    #[must_use]
    pub fn with_tick(mut self, tick_s: f64) -> Self {
        self.tick_s = tick_s;
        self
    }

    /// True time since the start, s: ticks done times their length.
    pub fn time_s(&self) -> f64 {
        self.ticks as f64 * self.tick_s
    }

    /// Where both bodies are.
    pub fn state(&self) -> &BodiesState {
        &self.state
    }

    /// Places both bodies, out of contact.
    pub fn set_state(&mut self, state: BodiesState) {
        self.state = state;
        self.at = self.bodies.kinematics(&state);
        self.bodies.mode = SwitchMode::Flight;
        self.open = None;
        if self.bodies.indicator(&state) > 0.0 {
            self.begin_contact(0.0);
        }
    }

    /// Hammer, cart, drive and ground, and what acts on them during this tick.
    pub fn bodies(&self) -> &PlantBodies {
        &self.bodies
    }

    /// Where energy and momentum went since the start.
    pub fn totals(&self) -> &PlantTotals {
        &self.totals
    }

    /// Hammer displacement in the fixed frame, x = y + l sin θ or y + Δ, m.
    pub fn hammer_m(&self) -> f64 {
        self.state.y + self.at.delta + self.gap_m
    }

    /// Cart displacement, y, m.
    pub fn cart_m(&self) -> f64 {
        self.state.y
    }

    /// Contact force now, N.
    pub fn force_n(&self) -> f64 {
        self.inner[INNER - 1]
    }

    /// Contact force at each tenth of the tick, ending with its end, N.
    pub fn inner_forces_n(&self) -> &[f64; INNER] {
        &self.inner
    }

    /// Whether there was contact during the tick.
    pub fn touched(&self) -> bool {
        self.touched
    }

    /// Contacts that ended during the tick.
    pub fn finished(&self) -> &[TrueContact] {
        &self.finished
    }

    /// Largest forces passed during the tick.
    pub fn blows(&self) -> &[PlantBlow] {
        &self.blows
    }

    /// Adds `change_m_per_s` to the hammer's speed.
    pub fn push(&mut self, change_m_per_s: f64) {
        let rig = &self.bodies.rig;
        self.state.v += rig.coordinate_rate_at(self.state.q, change_m_per_s);
        self.at = self.bodies.kinematics(&self.state);
    }

    /// Changes the rig without changing its motion: a drift. Returns whether it was done; in contact it is not, so
    /// try again.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn set_rig(&mut self, params: &RigParams) -> Result<bool, ParamError> {
        if self.bodies.mode == SwitchMode::Contact {
            return Ok(false);
        }
        let tilt_rad = self.bodies.mounting.tilt_rad;
        let rig = Rig::<f64>::new(&upright(params, tilt_rad))?;
        let old = &self.bodies.rig;
        let relative_m = old.relative_displacement(self.state.q);
        let rate = self.bodies.kinematics(&self.state).rate;
        self.state.q = rig.coordinate_at(relative_m);
        self.state.v = rig.coordinate_rate_at(self.state.q, rate);
        self.bodies.rig = rig;
        self.at = self.bodies.kinematics(&self.state);
        self.gap_m = params.gap_m;
        Ok(true)
    }

    /// Tilts the whole rig; [`set_rig`](Self::set_rig) turns the hammer's own gravity after it.
    pub fn set_tilt(&mut self, tilt_rad: f64) {
        self.bodies.mounting.tilt_rad = tilt_rad;
        self.bodies.along = GRAVITY_M_PER_S2 * tilt_rad.sin();
    }

    /// Changes the friction of the cart's guide; it holds the cart where it is.
    pub fn set_friction(&mut self, friction: Option<Friction>) {
        self.bodies.mounting.friction = friction;
        self.state.p = 0.0;
    }

    /// The speed that the motor is to have from now on, Hz.
    pub fn set_motor_hz(&mut self, hz: f64) {
        self.bodies.wanted_rad_s = TAU * hz;
    }

    /// One tick along `path` with the drive enabled or not.
    #[inline]
    pub fn tick(&mut self, path: SetPointPath, on: bool) {
        self.bodies.path = path;
        self.bodies.on = on;
        self.finished.clear();
        self.blows.clear();
        if self.touched {
            self.inner = [0.0; INNER];
            self.touched = false;
        }
        if self.bodies.mode == SwitchMode::Contact || !self.fly() {
            self.careful_tick();
            self.at = self.bodies.kinematics(&self.state);
        }
        self.feed();
        self.ticks += 1;
    }

    /// A tick of flight in one step, if the surface cannot be met in it.
    #[inline]
    fn fly(&mut self) -> bool {
        let mut totals = self.totals;
        let end = self.bodies.step(&self.state, 0.0, self.tick_s, &mut totals);
        let at = self.bodies.kinematics(&end);
        let reach = self.tick_s * (self.at.rate.abs() + at.rate.abs());
        let out_of_reach = self.at.delta.max(at.delta) + reach < 0.0;
        if out_of_reach {
            self.state = end;
            self.at = at;
            self.totals = totals;
        }
        out_of_reach
    }

    /// A tick in which the surface may be met or left.
    fn careful_tick(&mut self) {
        let (mut s, mut switches) = (0.0, 0);
        while s < self.tick_s {
            let grid = self.next_grid(s);
            let h = match self.bodies.mode {
                SwitchMode::Contact => grid.1 - s,
                // Just released and still inside the surface: short steps, so that no hop is stepped over.
                SwitchMode::Flight if self.bodies.kinematics(&self.state).delta > 0.0 => grid.1 - s,
                SwitchMode::Flight => self.tick_s - s,
            };
            let free = switches < MAX_SWITCHES;
            match self.switch_within(s, h).filter(|_| free) {
                Some(at) => {
                    switches += 1;
                    self.advance(s, at);
                    s += at;
                    self.switch(s);
                }
                None => {
                    self.advance(s, h);
                    s = if h == grid.1 - s { grid.1 } else { self.tick_s };
                    if self.bodies.mode == SwitchMode::Contact && s == grid.1 {
                        let at = self.bodies.kinematics(&self.state);
                        let force = self.bodies.contact_force(&at, &self.state);
                        self.inner[grid.0] = force.max(0.0);
                    }
                }
            }
        }
    }

    /// The next tenth of the tick after `s`: its index and its time.
    fn next_grid(&self, s: f64) -> (usize, f64) {
        let width = self.tick_s / INNER as f64;
        let mut index = (s / width) as usize;
        // A time on the grid, within rounding, belongs to the tenth it begins.
        if (index + 1) as f64 * width - s < SHORTEST_S {
            index += 1;
        }
        let index = index.min(INNER - 1);
        let end = if index + 1 == INNER {
            self.tick_s
        } else {
            (index + 1) as f64 * width
        };
        (index, end)
    }

    /// How far into a step of length `h` from `s` the mode's side of the switch is left, if it is.
    fn switch_within(&self, s: f64, h: f64) -> Option<f64> {
        let bodies = &self.bodies;
        let end_of = |part: f64| bodies.step(&self.state, s, part, &mut PlantTotals::default());
        let sign = match bodies.mode {
            SwitchMode::Flight => 1.0,
            SwitchMode::Contact => -1.0,
        };
        let left = |part: f64| sign * bodies.indicator(&end_of(part)) > 0.0;
        let mut beyond = h;
        if !left(h) {
            // Only a hammer that comes and turns away within the step can have touched.
            if bodies.mode == SwitchMode::Contact {
                return None;
            }
            let (from, to) = (
                bodies.kinematics(&self.state),
                bodies.kinematics(&end_of(h)),
            );
            if !(from.rate > 0.0 && to.rate < 0.0) {
                return None;
            }
            // The surface is nearest where the rate vanishes.
            let nearest = bisect(h, |part| bodies.kinematics(&end_of(part)).rate < 0.0);
            if !left(nearest) {
                return None;
            }
            beyond = nearest;
        }
        Some(bisect(beyond, left))
    }

    /// Goes `h` on from `s`.
    fn advance(&mut self, s: f64, h: f64) {
        let before = self.state;
        let mut totals = PlantTotals::default();
        self.state = self.bodies.step(&before, s, h, &mut totals);
        self.totals.add(&totals, 1.0);
        self.progress_m += self.state.front - before.front;
        if self.bodies.mode == SwitchMode::Contact {
            self.keep(&before, s, h, &totals);
        }
    }
}

/// The first place in 0 … `h` at which `beyond` holds, given that it holds at `h` and has not before; never
/// nearer than [`SHORTEST_S`] to 0, so that every step gets on.
fn bisect(h: f64, beyond: impl Fn(f64) -> bool) -> f64 {
    let (_, first) = narrowed((0.0, h), TIME_TOLERANCE_S, beyond);
    first.max(SHORTEST_S.min(h))
}
