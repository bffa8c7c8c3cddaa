//! Everything outside the controller: DAC, shaker, rig, sensors, ADC. One tick at a time.

use shared::io::{Frame, NormallyClosed, Output};
use shared::model::params::{ParamError, RigParams};

use super::mock::ChainPin;
use super::plant::Plant;
use super::scenario::{Change, Scenario};
use super::sensors::{Defect, Sensor, Sensors};
use super::shaker::Smoother;

/// A change under way.
#[derive(Clone, Copy, Debug)]
struct Drift {
    from: RigParams,
    change: Change,
    since_s: f64,
    over_s: f64,
}

/// The world of a scenario.
#[derive(Debug)]
pub struct World {
    plant: Plant,
    smoother: Smoother,
    sensors: Sensors,
    chain: NormallyClosed<ChainPin>,
    m_per_code: f64,
    rig: RigParams,
    drift: Option<Drift>,
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
        let plant = if scenario.prescribed {
            Plant::prescribed(&rig, tick_s)?
        } else {
            Plant::new(&rig, &scenario.shaker, tick_s)?
        };
        let settings = &scenario.settings;
        Ok(Self {
            plant,
            smoother: Smoother::new(&scenario.shaker, tick_s),
            sensors: Sensors::new(&scenario.sensors, settings, tick_s, scenario.seed),
            chain: NormallyClosed(ChainPin::default()),
            m_per_code: f64::from(settings.drive.m_per_code),
            rig,
            drift: None,
            powered: false,
        })
    }

    /// The plant.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The rig as it is now.
    pub fn rig(&self) -> &RigParams {
        &self.rig
    }

    /// Whether the drive had power during the last tick.
    pub fn is_powered(&self) -> bool {
        self.powered
    }

    /// Whether something of the scenario's is wrong with sensors or chain.
    pub fn is_faulty(&self) -> bool {
        self.chain.0.open || self.sensors.is_defective()
    }

    /// A tick with `output` at the drive; returns what the ADC reads at its end.
    #[inline]
    pub fn tick(&mut self, output: &Output) -> Frame {
        let played = if output.enable { *output } else { Output::SAFE };
        let metres = (f64::from(played.dac.0) - 2048.0) * self.m_per_code;
        self.powered = played.enable;
        let path = self.smoother.tick(metres);
        self.plant.tick(path, played.enable);
        let [force, hammer, cart] = self.sensors.read(&self.plant);
        Frame {
            force,
            hammer,
            cart,
            emergency: self.chain.is_open(),
        }
    }

    /// Opens or closes the emergency-stop chain.
    pub fn set_emergency(&mut self, open: bool) {
        self.chain.0.open = open;
    }

    /// Sensors get defects, in the order of their codes; `id` ends them again.
    pub fn begin_defects(&mut self, id: usize, defects: &[Option<Defect>; 3]) {
        for (sensor, defect) in Sensor::ALL.into_iter().zip(defects) {
            if let Some(defect) = defect {
                self.sensors.begin(sensor, id, *defect);
            }
        }
    }

    /// The defects of this `id` are over.
    pub fn end_defects(&mut self, id: usize) {
        self.sensors.end(id);
    }

    /// Pushes the hammer.
    pub fn push(&mut self, speed_m_per_s: f64) {
        self.plant.push(speed_m_per_s);
    }

    /// Begins a change of the rig; an earlier one stops where it is.
    pub fn begin_drift(&mut self, change: Change, over_s: f64) {
        self.drift = Some(Drift {
            from: self.rig,
            change,
            since_s: self.plant.time_s(),
            over_s,
        });
    }

    /// Goes on with the change under way. It ends where the rig would become invalid.
    pub fn drift(&mut self) {
        let Some(drift) = self.drift else {
            return;
        };
        let passed = self.plant.time_s() - drift.since_s;
        let share = if drift.over_s > 0.0 {
            (passed / drift.over_s).min(1.0)
        } else {
            1.0
        };
        let rig = drift.change.apply(&drift.from, share);
        match self.plant.set_rig(&rig) {
            // In contact: tried again after the next block.
            Ok(false) => {}
            Ok(true) => {
                self.rig = rig;
                if share >= 1.0 {
                    self.drift = None;
                }
            }
            Err(_) => self.drift = None,
        }
    }
}
