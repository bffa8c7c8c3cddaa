//! Everything outside the controller: DAC, drive, rig, sensors, ADC. One tick at a time.

use shared::io::{Frame, Output};
use shared::model::params::{GRAVITY_M_PER_S2, ParamError, RigParams, SupportParams};

use super::chain::EmergencyChain;
use super::plant::Plant;
use super::scenario::{RigChange, Scenario, Stuck};
use super::schedule::Doing;
use super::sensors::{EmulatedSensor, Sensors};
use super::shaker::Smoother;
use super::stuck::Habit;

/// A change under way.
#[derive(Clone, Copy, Debug)]
struct Drift<T> {
    change: T,
    since_s: f64,
    over_s: f64,
}

impl<T> Drift<T> {
    /// How much of it is done, 0 to 1.
    fn share(&self, now_s: f64) -> f64 {
        if self.over_s > 0.0 {
            ((now_s - self.since_s) / self.over_s).min(1.0)
        } else {
            1.0
        }
    }
}

/// A surface that recedes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recession {
    /// By the energy that each blow leaves in it, m/J.
    pub m_per_j: f64,
    /// All the time, m/s.
    pub m_per_s: f64,
    /// How far it still may, m.
    pub left_m: f64,
}

/// The world of a scenario.
#[derive(Clone, Debug)]
pub struct World {
    plant: Plant,
    smoother: Smoother,
    sensors: Sensors,
    chain: EmergencyChain,
    m_per_code: f64,
    tick_s: f64,
    /// The rig without what has receded, and as it is.
    ground: RigParams,
    rig: RigParams,
    drift: Option<Drift<(RigParams, RigChange)>>,
    recession: Option<Recession>,
    receded_m: f64,
    tilt_rad: f64,
    tilt: Option<Drift<(f64, f64)>>,
    tilted: bool,
    /// Share of the way that a motor's converter goes to its set-point in a tick, and where it is, Hz.
    follow: Option<f64>,
    converter_hz: f64,
    stuck: Option<Stuck>,
    habit: Habit,
    powered: bool,
}

impl World {
    /// At rest, the drive off.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn new(scenario: &Scenario) -> Result<Self, ParamError> {
        let tick_s = scenario.tick_s();
        let rig = scenario.true_rig;
        let plant = Plant::mounted(&rig, &scenario.drive(), &scenario.mounting, tick_s)?
            .on_ground(scenario.ground);
        let settings = &scenario.settings;
        let polarity = if scenario.shaker.reversed { -1.0 } else { 1.0 };
        Ok(Self {
            plant,
            smoother: Smoother::new(&scenario.shaker, tick_s),
            sensors: Sensors::new(&scenario.sensors, settings, tick_s, scenario.seed),
            chain: EmergencyChain::default(),
            m_per_code: f64::from(settings.drive.m_per_code) * polarity,
            tick_s,
            ground: rig,
            rig,
            drift: None,
            recession: None,
            receded_m: 0.0,
            tilt_rad: scenario.mounting.tilt_rad,
            tilt: None,
            tilted: false,
            follow: scenario.motor.map(|m| 1.0 - (-tick_s / m.lag_s).exp()),
            converter_hz: 0.0,
            stuck: None,
            habit: Habit::default(),
            powered: false,
        })
    }

    /// The plant: hammer, cart and drive, as they truly are.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The rig as it is now; a tilt shows in its gap.
    pub fn rig(&self) -> RigParams {
        levelled(&self.rig, self.tilt_rad)
    }

    /// Whether the drive had power during the last tick.
    pub fn is_powered(&self) -> bool {
        self.powered
    }

    /// Whether something of the scenario's is wrong with sensors, chain or drive.
    pub fn is_faulty(&self) -> bool {
        self.chain.is_open() || self.stuck.is_some() || self.sensors.is_defective()
    }

    /// A tick with `output` at the drive; returns what the ADC reads at its end.
    #[inline]
    pub fn tick(&mut self, output: &Output) -> Frame {
        let asked = if output.enable { *output } else { Output::SAFE };
        let metres = (f64::from(asked.dac.0) - 2048.0) * self.m_per_code;
        let (metres, hz) = self.obeyed(output, metres);
        let path = self.smoother.tick(metres);
        if let Some(follow) = self.follow {
            self.converter_hz += follow * (hz - self.converter_hz);
            self.plant.set_motor_hz(self.converter_hz);
        }
        let from_s = self.plant.time_s();
        self.plant.tick(path, self.powered);
        if self.recession.is_some() {
            self.wear();
        }
        let [force, hammer, cart] = self.sensors.read(&self.plant);
        Frame {
            force,
            hammer,
            cart,
            emergency: self.chain.tick(from_s, self.plant.time_s()),
        }
    }

    /// What the drive does with a set-point in m: it obeys, or is stuck. Sets whether it has power; gives its set-point
    /// and frequency.
    #[inline]
    fn obeyed(&mut self, output: &Output, metres: f64) -> (f64, f64) {
        let hz = f64::from(output.frequency_hz);
        self.powered = output.enable || self.stuck.is_some();
        if output.enable {
            self.habit.sees(metres, hz, self.tick_s);
            return (metres, hz);
        }
        match self.stuck {
            Some(Stuck::RunsOn) => self.habit.goes_on(self.tick_s),
            Some(Stuck::Powered) | None => (metres, 0.0),
        }
    }

    /// The surface gives way.
    fn wear(&mut self) {
        let Some(recession) = &mut self.recession else {
            return;
        };
        let energy: f64 = self.plant.finished().iter().map(|c| c.energy_lost_j).sum();
        let by = recession.m_per_j * energy + recession.m_per_s * self.tick_s;
        let by = by.min(recession.left_m);
        recession.left_m -= by;
        self.receded_m += by;
    }

    /// An action of the scenario on the rig; one on the controller does nothing here. A drift or a tilt begins, and an
    /// earlier one stops where it is.
    pub fn happen(&mut self, what: Doing) {
        let since_s = self.plant.time_s();
        match what {
            Doing::Emergency(open, at_s) => self.chain.flip(open, at_s),
            Doing::Defects(id, defects) => {
                for (sensor, defect) in EmulatedSensor::ALL.into_iter().zip(defects) {
                    if let Some(defect) = defect {
                        self.sensors.begin(sensor, id, defect);
                    }
                }
            }
            Doing::DefectsOver(id) => self.sensors.end(id),
            Doing::Push(speed_m_per_s) => self.plant.push(speed_m_per_s),
            Doing::Drift(change, over_s) => {
                self.drift = Some(Drift {
                    change: (self.ground, change),
                    since_s,
                    over_s,
                });
            }
            Doing::Recede(recession) => self.recession = recession,
            Doing::Stuck(how) => self.stuck = how,
            Doing::Tilt(to_rad, over_s) => {
                self.tilt = Some(Drift {
                    change: (self.tilt_rad, to_rad),
                    since_s,
                    over_s,
                });
            }
            Doing::Friction(friction) => self.plant.set_friction(friction),
            Doing::Command(_)
            | Doing::Link(_)
            | Doing::Overrun(_)
            | Doing::Lost(_)
            | Doing::Reset(_) => {}
        }
    }

    /// Goes on with the changes under way. One ends where the rig would become invalid.
    pub fn drift(&mut self) {
        let now_s = self.plant.time_s();
        if let Some(tilt) = self.tilt {
            let (from, to) = tilt.change;
            let share = tilt.share(now_s);
            self.tilt_rad = from + share * (to - from);
            self.plant.set_tilt(self.tilt_rad);
            self.tilted = true;
            if share >= 1.0 {
                self.tilt = None;
            }
        }
        let (ground, share) = match &self.drift {
            Some(drift) => {
                let share = drift.share(now_s);
                (drift.change.1.apply(&drift.change.0, share), share)
            }
            None => (self.ground, 0.0),
        };
        let mut rig = ground;
        rig.gap_m += self.receded_m;
        if rig == self.rig && !self.tilted {
            self.drift = self.drift.filter(|_| share < 1.0);
            return;
        }
        match self.plant.set_rig(&rig) {
            // In contact: tried again after the next block.
            Ok(false) => {}
            Ok(true) => {
                self.rig = rig;
                self.ground = ground;
                self.tilted = false;
                self.drift = self.drift.filter(|_| share < 1.0);
            }
            Err(_) => {
                self.drift = None;
                self.recession = None;
            }
        }
    }
}

/// The rig that stands level and has the same clearance as `rig` tilted by `tilt_rad`.
pub fn levelled(rig: &RigParams, tilt_rad: f64) -> RigParams {
    if tilt_rad == 0.0 {
        return *rig;
    }
    let mut level = *rig;
    level.gap_m -= match rig.support {
        SupportParams::Wires { length_m, .. } => length_m * tilt_rad.sin(),
        SupportParams::Beams {
            natural_frequency_hz,
            ..
        } => {
            let omega = std::f64::consts::TAU * natural_frequency_hz;
            GRAVITY_M_PER_S2 * tilt_rad.sin() / (omega * omega)
        }
    };
    level
}
