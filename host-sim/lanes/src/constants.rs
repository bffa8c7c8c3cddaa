//! A cell without units: what the lanes need of a rig at one drive frequency.
//!
//! Time is the drive phase τ = Ωt, the coordinate x is [`shared::model::rig`]'s q over its scale (A0/l or A0), so that x is
//! measured from the surface in cart amplitudes and section tolerances are plain numbers. Then, with G = gap/A0,
//!
//! ```text
//! wires  x″ = cos θ sin τ − β sin θ/σ − N,             σ = A0/l, β = g/(l Ω²), sin θ/σ = G at x = 0
//! beams  x″ = sin τ − d x′ − k1 (x+G) − k3 (x+G)³ − N
//! ```
//!
//! where N = t (κc x + γc x′), the contact force over m A0 Ω² (times cos θ for the corrected torque), acts in contact.

use std::f64::consts::{PI, TAU};

use shared::model::cart::CartDrive;
use shared::model::contact::Law;
use shared::model::params::{RigParams, SupportParams, Torque};

use super::Cell;
use super::cart::{Around, Recoil};
use super::linear::{DampedPair, Hold};
use super::surface::LawSurface;

/// Which equation of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EquationKind {
    /// Pendulum on wires.
    Wires,
    /// Beam springs.
    Beams,
}

/// A cell without units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constants {
    /// Which equation of motion.
    pub kind: EquationKind,
    /// Coordinate per unit of x (rad or m).
    pub scale: f64,
    /// Angular frequency Ω of the drive, rad/s.
    pub omega: f64,
    /// Newton per unit of force, m A0 Ω².
    pub force_unit_n: f64,
    /// The surface from rest: wires θ_gap/σ, beams G.
    pub rest: f64,
    /// Wires: cos θ at the surface, which the drive acts by there. Beams: 1.
    pub drive: f64,
    /// Wires: σ². Beams: k3.
    pub bend: f64,
    /// Wires: β. Beams: k1.
    pub spring: f64,
    /// Beams: d. Wires: 0.
    pub damping: f64,
    /// Constant part of x″ at the surface, −β G or −k1 G − k3 G³.
    pub pull: f64,
    /// κc: force per x.
    pub contact_spring: f64,
    /// γc: force per x′.
    pub contact_damper: f64,
    /// Everything that multiplies x in contact, linearised at the surface.
    pub stiffness: f64,
    /// Everything that multiplies x′ in contact.
    pub damper: f64,
    /// μ = half of `damper`: the transient's decay per τ.
    pub decay: f64,
    /// ν: the transient's angular frequency per τ.
    pub pulsation: f64,
    /// sin τ's share in the contact's forced motion.
    pub forced_sin: f64,
    /// cos τ's share in the contact's forced motion.
    pub forced_cos: f64,
    /// Constant share in the contact's forced motion.
    pub forced_mean: f64,
    /// Transient phase φ = ν τ at which a contact without outer force releases.
    pub release_phase: f64,
    /// Transient phase at which its force peaks; 0: at onset.
    pub peak_phase: f64,
    /// Angular frequency of the flight, at least the drive's: what step lengths are measured by.
    pub fastest: f64,
    /// A cart that recoils.
    pub recoil: Option<Recoil>,
    /// A contact law without a closed form: the spring and damper above then stand for it where only their place counts.
    pub surface: Option<LawSurface>,
}

/// Slowest and fastest drive over the hammer's own frequency that lanes take: below, a drive cycle needs too many steps
/// to be worth a lane.
const RATIOS: std::ops::RangeInclusive<f64> = 0.1..=50.0;

/// Least angular frequency ν of a contact's transient, per drive phase, that lanes take: with less, contacts last too
/// long for the drive to be held to second order.
const SLOWEST_CONTACT: f64 = 16.0;

/// ν of the contact that stands for a law without a closed form: faster than anything else.
const STAND_IN: f64 = 1e4;

/// Widest swing (rad or m): beyond, the lanes' polynomials do not hold. At this swing that of cos θ is 3e-7 off.
const WIDEST: f64 = 0.25;

impl Constants {
    /// The cell without units; none where lanes cannot run it: an overdamped
    /// contact, a start inside the surface or with too wide a swing, frequencies or sizes far from any rig's.
    ///
    /// Also none where something cannot be at all; the reference then says what.
    pub fn new(cell: &Cell) -> Option<Self> {
        let rig = &cell.params;
        let possible = rig.check().is_ok()
            && cell.start.iter().all(|s| s.is_finite())
            && cell.start[0] <= 0.0
            && (0.0..1.0).contains(&cell.phase);
        if !possible {
            return None;
        }
        let omega = TAU * cell.frequency_hz;
        let mass = rig.mass_kg;
        let (stiffness, damping) = match rig.contact {
            Law::SpringDashpot { stiffness, damping } => (stiffness, damping),
            _ => {
                let fast = STAND_IN * omega;
                (mass * fast * fast, 0.2 * mass * fast)
            }
        };
        let contact_spring = stiffness / (mass * omega * omega);
        let contact_damper = damping / (mass * omega);
        let gap = rig.gap_m / rig.amplitude_m;
        let ratio = cell.frequency_hz / rig.natural_frequency_hz();
        if !RATIOS.contains(&ratio) || rig.gap_m < 0.0 || gap > 50.0 {
            return None;
        }
        let support = Support::new(rig, omega, gap)?;
        let stiffness = support.torque * support.drive * contact_spring + support.stiffness;
        let damper = support.torque * support.drive * contact_damper + support.damping;
        let recoil = match &rig.cart {
            CartDrive::Prescribed => None,
            CartDrive::Loop(held) => {
                let around = support.around(rig, stiffness, damper);
                Some(Recoil::new(held, omega, &around)?)
            }
        };
        let bounce = recoil.map_or(
            DampedPair {
                a: damper,
                b: stiffness,
            },
            |recoil| recoil.touch,
        );
        let (decay, pulsation) = bounce.oscillation()?;
        if pulsation < SLOWEST_CONTACT {
            return None;
        }
        let forced = (stiffness - 1.0).powi(2) + damper * damper;
        let alone = [
            support.drive * (stiffness - 1.0) / forced,
            -support.drive * damper / forced,
        ];
        let [forced_sin, forced_cos] = recoil.map_or(alone, |recoil| recoil.forced);
        let contact_spring = support.drive * contact_spring;
        let contact_damper = support.drive * contact_damper;
        let constants = Self {
            kind: support.kind,
            scale: support.scale,
            omega,
            force_unit_n: mass * rig.amplitude_m * omega * omega,
            rest: support.rest,
            drive: support.drive,
            bend: support.bend,
            spring: support.spring,
            damping: support.damping,
            pull: support.pull,
            contact_spring,
            contact_damper,
            stiffness,
            damper,
            decay,
            pulsation,
            forced_sin,
            forced_cos,
            forced_mean: support.pull / stiffness,
            release_phase: (contact_damper * pulsation)
                .atan2(contact_damper * decay - contact_spring)
                .rem_euclid(PI),
            peak_phase: 0.0,
            fastest: support.fastest.max(1.0),
            recoil,
            surface: None,
        };
        let nonlinear = !matches!(rig.contact, Law::SpringDashpot { .. });
        let surface = nonlinear.then_some(LawSurface {
            law: rig.contact,
            depth_m: rig.amplitude_m * support.drive,
            rate_m_per_s: rig.amplitude_m * omega * support.drive,
            torque: support.torque,
            beside: support.stiffness,
        });
        let constants = Self {
            surface,
            ..constants
        };
        let [x, v] = cell.start;
        let swing2 = (x / support.scale + support.rest).powi(2)
            + (v / (support.scale * omega)).powi(2) / support.spring;
        (swing2 < constants.widest2()).then(|| constants.with_peak_phase())
    }

    /// The square of the widest swing about rest that lanes follow.
    pub fn widest2(&self) -> f64 {
        (WIDEST / self.scale).powi(2)
    }

    /// Both amplitudes of F's transient, e^(−μτ)(a cos φ + b sin φ), for the displacement's `a`, `b`.
    pub fn force_amplitudes(&self, a: f64, b: f64) -> (f64, f64) {
        let (k, c) = (self.contact_spring, self.contact_damper);
        (
            k * a + c * (self.pulsation * b - self.decay * a),
            k * b - c * (self.decay * b + self.pulsation * a),
        )
    }

    fn with_peak_phase(mut self) -> Self {
        // Where the slope of e^(−ρφ)(A cos φ + B sin φ) first vanishes, for a hammer that arrives at x = 0.
        let (a, b) = self.force_amplitudes(0.0, 1.0);
        let rho = self.decay / self.pulsation;
        let (rise, fall) = (b - rho * a, a + rho * b);
        if rise > 0.0 {
            self.peak_phase = rise.atan2(fall).rem_euclid(PI);
        }
        if self.release_phase <= 0.0 {
            self.release_phase += PI;
        }
        self
    }
}

struct Support {
    kind: EquationKind,
    scale: f64,
    rest: f64,
    drive: f64,
    torque: f64,
    bend: f64,
    spring: f64,
    damping: f64,
    pull: f64,
    /// The support's own share of what multiplies x in contact.
    stiffness: f64,
    fastest: f64,
}

impl Support {
    /// For a cart that recoils: `stiffness` and `damper` are those of support and surface.
    fn around(&self, rig: &RigParams, stiffness: f64, damper: f64) -> Around {
        let hold = |stiffness, damping| Hold { stiffness, damping };
        Around {
            mass_ratio: rig.mass_kg / rig.cart_mass_kg,
            sin: (1.0 - self.drive * self.drive).max(0.0).sqrt(),
            wires: self.kind == EquationKind::Wires,
            rest: hold(self.spring, self.damping),
            beside: hold(self.stiffness, self.damping),
            touch: hold(stiffness, damper),
        }
    }

    fn new(rig: &RigParams, omega: f64, gap: f64) -> Option<Self> {
        Some(match rig.support {
            SupportParams::Wires {
                length_m,
                gravity_m_per_s2,
                torque,
                ..
            } => {
                let scale = rig.amplitude_m / length_m;
                let sin = rig.gap_m / length_m;
                if sin > 0.2 || scale > 0.1 {
                    return None;
                }
                let cos = (1.0 - sin * sin).sqrt();
                let beta = gravity_m_per_s2 / (length_m * omega * omega);
                Self {
                    kind: EquationKind::Wires,
                    scale,
                    rest: libm::asin(sin) / scale,
                    drive: cos,
                    torque: match torque {
                        Torque::Literal => 1.0,
                        Torque::Cosine => cos,
                    },
                    bend: scale * scale,
                    spring: beta,
                    damping: 0.0,
                    pull: -beta * gap,
                    stiffness: beta * cos,
                    fastest: beta.sqrt(),
                }
            }
            SupportParams::Beams {
                natural_frequency_hz,
                damping_ratio,
                cubic_stiffness_n_per_m3,
            } => {
                let own = TAU * natural_frequency_hz;
                let k = rig.mass_kg * own * own;
                let k1 = (own / omega).powi(2);
                let cubic = cubic_stiffness_n_per_m3.unwrap_or(k);
                let k3 = cubic / k * k1 * rig.amplitude_m * rig.amplitude_m;
                if k3 > 1e-3 * k1 {
                    return None;
                }
                Self {
                    kind: EquationKind::Beams,
                    scale: rig.amplitude_m,
                    rest: gap,
                    drive: 1.0,
                    torque: 1.0,
                    bend: k3,
                    spring: k1,
                    damping: 2.0 * damping_ratio * own / omega,
                    pull: -gap * (k1 + k3 * gap * gap),
                    stiffness: k1 + 3.0 * k3 * gap * gap,
                    fastest: k1.sqrt(),
                }
            }
        })
    }
}
