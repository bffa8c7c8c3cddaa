//! How narrow the chapter's band must be, and how small a tick it then needs.

use std::f64::consts::PI;

use shared::model::contact::TABLE_3_1;
use shared::model::contacts::Contact;
use shared::model::drive::Drive;
use shared::model::params::{BEAM_170, RigParams, SupportParams};
use shared::model::rig::Rig;
use shared::model::step::{HammerState, Stepper};
use shared::model::twin::Twin;

use numerics::engine::{Method, Plan, Precision, Setting};
use numerics::pick::sensitivity::{contact_damping_ratio, restitution};
use numerics::{Error, parallel};

use crate::named::{NamedPoint, StepperCell};

/// Where the band is studied.
pub const POINT: NamedPoint = NamedPoint {
    rig: "beam-150",
    gap_mm: 1.0,
    ratio: 1.5,
};

/// Ticks, µs: one that resolves the band, and three that do not.
pub const TICKS_US: [f64; 4] = [0.05, 1.0, 10.0, 50.0];

/// Started on the orbit; it contracts tenfold within three periods.
const PLAN: Plan = Plan {
    cycles: 10,
    transient: 6,
};

/// η_α compared, m.
pub const ETA_ALPHA_M: [f64; 6] = [1e-5, 1e-6, 1e-7, 5e-8, 1e-8, 1e-9];

/// ε_α of the smoothing method compared, m (ε_β is 1e7 N/m times that).
pub const EPSILON_M: [f64; 4] = [1e-6, 2.5e-7, 6.25e-8, 1.5e-8];

/// The errors of a width at each of [`TICKS_US`].
pub type ErrorsOverTicks = Vec<Option<StepperCell>>;

fn rows(widths: &[f64], method: impl Fn(f64) -> Method + Sync) -> Vec<(f64, ErrorsOverTicks)> {
    let row = |width: &f64| {
        let at = |tick_us: &f64| {
            let setting = Setting {
                method: method(*width),
                precision: Precision::F64,
                tick_s: tick_us * 1e-6,
            };
            POINT.cell(setting, PLAN)
        };
        (*width, TICKS_US.iter().map(at).collect())
    };
    parallel::map(widths, row)
}

/// Errors against η_α, with η_β = 0.001 N.
pub fn by_eta_alpha() -> Vec<(f64, ErrorsOverTicks)> {
    rows(&ETA_ALPHA_M, |eta_alpha_m| Method::Banded {
        eta_alpha_m,
        eta_beta_n: 1e-3,
    })
}

/// Errors of the smoothing method against ε_α.
pub fn by_epsilon() -> Vec<(f64, ErrorsOverTicks)> {
    rows(&EPSILON_M, |epsilon_alpha_m| Method::Smoothed {
        epsilon_alpha_m,
        epsilon_beta_n: 1e7 * epsilon_alpha_m,
    })
}

/// Approach speed of the single contacts, m/s.
const APPROACH_M_PER_S: f64 = 0.08;

/// Contact damping ratio of the free mass on the spring-dashpot of Table 3.1.
fn damping_ratio() -> f64 {
    contact_damping_ratio(&free_mass()).expect("Table 3.1 is a spring-dashpot")
}

/// A mass that nothing but the surface acts on.
fn free_mass() -> RigParams {
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: 1e-3,
            damping_ratio: 0.0,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        amplitude_m: 1e-6,
        contact: TABLE_3_1,
        ..BEAM_170
    }
}

/// One contact of a free mass at 0.08 m/s, begun `clearance_m` before the surface.
fn single(
    stepper: impl Stepper<f32>,
    tick_s: f64,
    clearance_m: f64,
) -> Result<Option<Contact<f32>>, Error> {
    let rig = Rig::new(&free_mass())?;
    let state = HammerState::new(&rig, -clearance_m as f32, APPROACH_M_PER_S as f32);
    let mut twin = Twin::new(rig, Drive::new(0.1, tick_s)?, stepper, state);
    Ok((0..1_000_000).find_map(|_| twin.tick().contact))
}

/// Largest errors of (peak force, rebound speed) of one contact of a free mass, over onsets anywhere in
/// the tick, in f32. The law is linear, so they hold for every approach speed.
///
/// # Errors
/// If a simulation fails, which none does at a tick that resolves the drive.
pub fn worst_single<S: Stepper<f32> + Copy>(stepper: S, tick_s: f64) -> Result<(f64, f64), Error> {
    const ONSETS: u32 = 100;
    let mass_kg = free_mass().mass_kg;
    let (mut force, mut rebound) = (0.0_f64, 0.0_f64);
    for k in 0..ONSETS {
        let ticks = 2.0 + (f64::from(k) + 0.5) / f64::from(ONSETS);
        let contact = single(stepper, tick_s, APPROACH_M_PER_S * tick_s * ticks)?;
        let (peak, back) = contact.map_or((f64::NAN, f64::NAN), |c| {
            (f64::from(c.peak_force), f64::from(c.rebound_speed))
        });
        force = force.max((peak / peak_force(mass_kg) - 1.0).abs());
        rebound =
            rebound.max((back / (restitution(damping_ratio()) * APPROACH_M_PER_S) - 1.0).abs());
    }
    Ok((force, rebound))
}

/// Peak force of the spring-dashpot of Table 3.1 at [`APPROACH_M_PER_S`], in closed form, N.
fn peak_force(mass_kg: f64) -> f64 {
    let zeta = damping_ratio();
    let omega = (TABLE_3_1.stiffness() / mass_kg).sqrt();
    let angle = (3.0 * zeta.acos() - PI) / (1.0 - zeta * zeta).sqrt();
    mass_kg * APPROACH_M_PER_S * omega * (-zeta * angle).exp()
}
