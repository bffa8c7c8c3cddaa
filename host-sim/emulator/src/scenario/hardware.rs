//! Shaker and sensors as a scenario writes them.

use serde::Deserialize;
use shared::model::params::RigParams;
use shared::settings::Settings;

use super::complaint::out_of_range;
use crate::cart::{Friction, Mounting, Stops};
use crate::motor::MotorParams;
use crate::sensors::SensorParams;
use crate::shaker::{ArmatureParams, ShakerParams};
use files::UserError;

/// How far a rig may be tilted, degrees.
pub const TILT_DEG: (f64, f64) = (-10.0, 10.0);

/// The table `[shaker]`: position loop, largest force, amplifier, suspension and armature.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShakerTable {
    pub prescribed: Option<bool>,
    loop_hz: Option<f64>,
    loop_damping_ratio: Option<f64>,
    force_n: Option<f64>,
    feed_forward: Option<f64>,
    lag_ms: Option<f64>,
    droop_hz: Option<f64>,
    suspension_hz: Option<f64>,
    suspension_damping_ratio: Option<f64>,
    impedance_n_s_per_m: Option<f64>,
    reversed: Option<bool>,
    armature_kg: Option<f64>,
    armature_hz: Option<f64>,
    armature_damping_ratio: Option<f64>,
}

/// The table `[cart]`: friction of its guide, end stops, and tilt of the rig.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CartTable {
    coulomb_n: Option<f64>,
    static_n: Option<f64>,
    viscous_n_s_per_m: Option<f64>,
    stop_mm: Option<f64>,
    stop_stiffness_n_per_m: Option<f64>,
    stop_damping_s_per_m: Option<f64>,
    tilt_deg: Option<f64>,
}

/// The table `[motor]`: a motor with a crank in place of the shaker.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorTable {
    crank_mm: Option<f64>,
    rod_ratio: Option<f64>,
    inertia_kg_m2: Option<f64>,
    slip_hz_per_n_m: Option<f64>,
    torque_n_m: Option<f64>,
    lag_ms: Option<f64>,
    coast_s: Option<f64>,
}

/// The table `[sensors]`: noise, offsets, gains, filters, ringing, and defects from the start.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorsTable {
    noise_percent: Option<f64>,
    force_noise_n: Option<f64>,
    hammer_noise_um: Option<f64>,
    cart_noise_um: Option<f64>,
    force_offset_n: Option<f64>,
    hammer_offset_um: Option<f64>,
    cart_offset_um: Option<f64>,
    force_gain_percent: Option<f64>,
    hammer_gain_percent: Option<f64>,
    cart_gain_percent: Option<f64>,
    force_filter_hz: Option<f64>,
    displacement_filter_hz: Option<f64>,
    ringing_hz: Option<f64>,
    ringing_percent: Option<f64>,
    ringing_decay_ms: Option<f64>,
    /// What is wrong from the start: each as an event of kind `sensor-fault` without its time.
    #[serde(default)]
    pub defects: Vec<toml::Table>,
}

/// The value of `key` times `unit`, or `otherwise` if there is none. The range is in the key's unit.
fn pick(
    key: &str,
    value: Option<f64>,
    (from, to): (f64, f64),
    unit: f64,
    otherwise: f64,
) -> Result<f64, UserError> {
    match value {
        None => Ok(otherwise),
        Some(x) if (from..=to).contains(&x) => Ok(x * unit),
        Some(x) => Err(out_of_range(key, x, &format!("{from} to {to}"))),
    }
}

/// Puts the numbers that a table has into those of a part. One line each: the key, its range in its own unit, that unit,
/// and the part's number.
macro_rules! put {
    ($table:expr => $part:expr; $($key:ident: $range:expr, $unit:expr => $number:ident;)*) => {
        $($part.$number = pick(stringify!($key), $table.$key, $range, $unit, $part.$number)?;)*
    };
}

/// The largest force that a scenario's shaker may have, N.
pub(crate) const MOST_FORCE_N: f64 = 1e6;

/// The fastest a position loop may be, its damping counted in, Hz.
const FASTEST_LOOP_HZ: f64 = 2000.0;

/// The shaker, its defaults for what is left out.
pub fn shaker(file: &ShakerTable) -> Result<ShakerParams, UserError> {
    let mut shaker = ShakerParams::default();
    put! { file => shaker;
        loop_hz: (1.0, 500.0), 1.0 => loop_hz;
        loop_damping_ratio: (0.05, 5.0), 1.0 => loop_damping_ratio;
        force_n: (0.0, MOST_FORCE_N), 1.0 => force_n;
        feed_forward: (0.0, 2.0), 1.0 => feed_forward;
        lag_ms: (0.05, 100.0), 1e-3 => lag_s;
        droop_hz: (1.0, 3000.0), 1.0 => droop_hz;
        suspension_hz: (0.1, 100.0), 1.0 => suspension_hz;
        suspension_damping_ratio: (0.0, 10.0), 1.0 => suspension_damping_ratio;
        impedance_n_s_per_m: (0.0, 1e4), 1.0 => impedance_n_s_per_m;
    }
    shaker.reversed = file.reversed.unwrap_or_default();
    shaker.armature = armature(file)?;
    // For faster loops the plant's step in flight is too long.
    let damping = shaker.loop_damping_ratio;
    let faster = damping + (damping * damping - 1.0).max(0.0).sqrt();
    if shaker.loop_hz * faster > FASTEST_LOOP_HZ {
        let most = FASTEST_LOOP_HZ / faster;
        return Err(out_of_range(
            "loop_hz",
            shaker.loop_hz,
            &format!("at most {most:.0} with loop_damping_ratio {damping}"),
        ));
    }
    Ok(shaker)
}

/// The armature, if it has a mode of its own.
fn armature(file: &ShakerTable) -> Result<Option<ArmatureParams>, UserError> {
    if file.armature_kg.is_none() {
        let orphan = [
            ("armature_hz", file.armature_hz),
            ("armature_damping_ratio", file.armature_damping_ratio),
        ];
        return match orphan.iter().find(|(_, value)| value.is_some()) {
            Some((key, _)) => Err(UserError::new(format!("{key} needs armature_kg = MASS"))),
            None => Ok(None),
        };
    }
    let mut armature = ArmatureParams {
        mass_kg: 0.0,
        hz: 100.0,
        damping_ratio: 0.02,
    };
    // The joint's own mode must stay slow against a tick.
    put! { file => armature;
        armature_kg: (0.05, 1000.0), 1.0 => mass_kg;
        armature_hz: (0.5, 300.0), 1.0 => hz;
        armature_damping_ratio: (0.0, 2.0), 1.0 => damping_ratio;
    }
    Ok(Some(armature))
}

/// Friction of the cart's guide; none where there is none.
pub fn friction(
    coulomb_n: Option<f64>,
    static_n: Option<f64>,
    viscous: Option<f64>,
) -> Result<Option<Friction>, UserError> {
    let coulomb_n = pick("coulomb_n", coulomb_n, (0.0, 1000.0), 1.0, 0.0)?;
    let range = (coulomb_n, 3.0 * coulomb_n);
    let friction = Friction {
        coulomb_n,
        static_n: pick("static_n", static_n, range, 1.0, coulomb_n)?,
        viscous_n_s_per_m: pick("viscous_n_s_per_m", viscous, (0.0, 1e4), 1.0, 0.0)?,
    };
    let none = friction.coulomb_n == 0.0 && friction.viscous_n_s_per_m == 0.0;
    Ok((!none).then_some(friction))
}

/// How the cart is mounted.
pub fn mounting(file: &CartTable) -> Result<Mounting, UserError> {
    let mut stops = Stops {
        at_m: 0.0,
        stiffness_n_per_m: 1e6,
        damping_s_per_m: 1.0,
    };
    put! { file => stops;
        stop_stiffness_n_per_m: (1e3, 1e7), 1.0 => stiffness_n_per_m;
        stop_damping_s_per_m: (0.0, 100.0), 1.0 => damping_s_per_m;
    }
    let tilt = pick("tilt_deg", file.tilt_deg, TILT_DEG, 1.0, 0.0)?;
    let friction = friction(file.coulomb_n, file.static_n, file.viscous_n_s_per_m)?;
    put! { file => stops;
        stop_mm: (0.01, 1000.0), 1e-3 => at_m;
    }
    Ok(Mounting {
        friction,
        stops: file.stop_mm.map(|_| stops),
        tilt_rad: tilt.to_radians(),
    })
}

/// The motor that moves the cart of `rig`.
pub fn motor(file: &MotorTable, rig: &RigParams) -> Result<MotorParams, UserError> {
    let whole_mm = 1e3 * rig.amplitude_m;
    let range_mm = (0.01, 100.0);
    let crank_m = pick("crank_mm", file.crank_mm, range_mm, 1e-3, 1e-3 * whole_mm)?;
    let mut motor = MotorParams::for_cart(crank_m, rig.cart_mass_kg + rig.mass_kg);
    let positive = (1e-12, 1e6);
    put! { file => motor;
        rod_ratio: (0.0, 0.9), 1.0 => rod_ratio;
        inertia_kg_m2: positive, 1.0 => inertia_kg_m2;
        slip_hz_per_n_m: positive, 1.0 => slip_hz_per_n_m;
        torque_n_m: positive, 1.0 => torque_n_m;
        lag_ms: (0.05, 10_000.0), 1e-3 => lag_s;
        coast_s: (1e-3, 1e3), 1.0 => coast_s;
    }
    Ok(motor)
}

/// The sensors, their defaults for what is left out.
pub fn sensors(file: &SensorsTable, settings: &Settings) -> Result<SensorParams, UserError> {
    /// Farthest offset and largest noise, N or µm.
    const REACH: f64 = 1e5;
    let mut sensors = SensorParams::default();
    let share = pick("noise_percent", file.noise_percent, (0.0, 50.0), 0.01, 0.0)?;
    // Noise in percent is of what is typical: the strongest 1/1, a fifth of the force sensor's range, and A0.
    let typical_n = 3300.0 / 5.0 * f64::from(settings.force.unit_per_code.abs());
    let typical_m = settings.rig.amplitude_m;
    sensors.force.noise = share * typical_n;
    sensors.hammer.noise = share * typical_m;
    sensors.cart.noise = share * typical_m;
    let (offset, gain_percent, noise) = ((-REACH, REACH), (-50.0, 100.0), (0.0, REACH));
    put! { file => sensors.force;
        force_offset_n: offset, 1.0 => offset;
        force_gain_percent: gain_percent, 0.01 => gain_error;
        force_noise_n: noise, 1.0 => noise;
    }
    put! { file => sensors.hammer;
        hammer_offset_um: offset, 1e-6 => offset;
        hammer_gain_percent: gain_percent, 0.01 => gain_error;
        hammer_noise_um: noise, 1e-6 => noise;
    }
    put! { file => sensors.cart;
        cart_offset_um: offset, 1e-6 => offset;
        cart_gain_percent: gain_percent, 0.01 => gain_error;
        cart_noise_um: noise, 1e-6 => noise;
    }
    let corner = (10.0, 50_000.0);
    put! { file => sensors;
        force_filter_hz: corner, 1.0 => force_filter_hz;
        displacement_filter_hz: corner, 1.0 => displacement_filter_hz;
        ringing_hz: (100.0, 20_000.0), 1.0 => ringing_hz;
        ringing_percent: (0.0, 200.0), 0.01 => ringing_share;
        ringing_decay_ms: (0.01, 100.0), 1e-3 => ringing_decay_s;
    }
    Ok(sensors)
}
