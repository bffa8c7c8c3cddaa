//! A scenario that can be run.

use shared::control::{Basin, State};
use shared::fault::Fault;
use shared::model::params::{ParamError, RigParams};
use shared::settings::{Settings, TICK_S};

use super::event::Timed;
use crate::cart::Mounting;
use crate::ground::PlantGround;
use crate::motor::MotorParams;
use crate::plant::ShakerDrive;
use crate::sensors::SensorParams;
use crate::shaker::ShakerParams;

/// Longest run, s: the tick counter of the controller wraps after 2.5 days.
pub(super) const LONGEST_S: f64 = 2.0 * 86_400.0;

/// A scenario whose numbers have been checked: rig, settings, hardware, events, and what the run must end in.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Name of the scenario, which the verdict repeats.
    pub name: String,
    /// What it is for, in a sentence.
    pub description: String,
    /// Length of the run, s of rig time.
    pub duration_s: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Control ticks per block.
    pub block_ticks: usize,
    /// Slices of the forecast per block.
    pub slices_per_block: u32,
    /// By how much a true tick is longer than the controller assumes, in millionths.
    pub clock_ppm: f64,
    /// The rig as it truly is at the start.
    pub true_rig: RigParams,
    /// The settings of the controller, with the rig it believes in.
    pub settings: Settings,
    /// Why the controller is not told the shaker's position loop, where its settings do not take it.
    pub loop_left_out: Option<ParamError>,
    /// The shaker that moves the cart, unless its motion is prescribed or a motor moves it.
    pub shaker: ShakerParams,
    /// Whether the cart follows its set-point whatever force that takes.
    pub prescribed: bool,
    /// The motor that moves the cart in the shaker's place.
    pub motor: Option<MotorParams>,
    /// How the cart is mounted.
    pub mounting: Mounting,
    /// Ground that gives way, in place of the true rig's contact.
    pub ground: Option<PlantGround>,
    /// Errors of the sensors, their filters, and the ringing of the surface.
    pub sensors: SensorParams,
    /// What happens, by rising time.
    pub events: Vec<Timed>,
    /// What the run must end in.
    pub expect: Expect,
}

impl Scenario {
    /// True length of a tick, s.
    pub fn tick_s(&self) -> f64 {
        TICK_S * (1.0 + 1e-6 * self.clock_ppm)
    }

    /// What moves the cart.
    pub fn drive(&self) -> ShakerDrive {
        match self.motor {
            Some(motor) => ShakerDrive::Motor(motor),
            None if self.prescribed => ShakerDrive::Prescribed,
            None => ShakerDrive::Shaker(self.shaker),
        }
    }

    /// Blocks of the run.
    pub fn blocks(&self) -> u64 {
        let ticks = self.duration_s / self.tick_s();
        (ticks / self.block_ticks as f64).round().max(1.0) as u64
    }
}

/// What a run must end in. What is left out is not checked, except faults (those not named must not trip) and the
/// upper bound of the force share.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expect {
    /// State at the end.
    pub final_state: Option<State>,
    /// The faults that trip, in their order.
    pub faults: Vec<Fault>,
    /// Smallest share of the optimum's force from the first Hold on.
    pub min_force_share: Option<f64>,
    /// Largest; if left out, a little more than the whole.
    pub max_force_share: Option<f64>,
    /// Smallest share of the optimum's force from the first start on.
    pub min_share_from_start: Option<f64>,
    /// Largest true contact force, N.
    pub max_true_force_n: Option<f64>,
    /// Largest true cart displacement, mm.
    pub max_true_cart_mm: Option<f64>,
    /// Longest time for which the drive may stay powered while a fault of the scenario is present, s.
    pub max_driven_with_fault_s: Option<f64>,
    /// Hold must be reached this soon after the first start, s.
    pub hold_within_s: Option<f64>,
    /// Basin at the end.
    pub basin: Option<Basin>,
    /// Fewest times the regime must be lost and sought again.
    pub min_reseeks: Option<u16>,
    /// Most ticks from a fault's condition to the drive being off.
    pub drive_off_within_ticks: Option<u64>,
    /// Least rate of penetration from the first Hold on, µm/s, into ground that gives way.
    pub min_progress_um_per_s: Option<f64>,
}
