//! The hammer with its bending modes in a cart that may recoil, and its 1/1 orbits.
//!
//! With a spring-dashpot contact both phases of the motion, flight and contact, are linear and driven by a sine. The state
//! with sin Ωt, cos Ωt and 1 beside it moves by Ż = A Z with one constant matrix per phase, so a step of any length is a
//! matrix exponential, exact but for rounding, and the derivative of the return map is a product of such matrices and of
//! the saltations at the switches.
//!
//! The modes are those of [`super::ModalRig`], now under the cart's own acceleration ÿ,
//! m_i (η̈_i + 2ζω_i η̇_i + ω_i² η_i) = −Γ_i ÿ − F, and momentum gives that of the cart, y = y* + e: with the shaker's force
//! Fs of [`shared::model::cart`],
//!
//! (M + m + m_b − Σ Γ_i²/m_i) ÿ = Fs + Σ Γ_i (F/m_i + 2ζω_i η̇_i + ω_i² η_i).
//!
//! Lengths are in A0 and times in 1/Ω.

use std::f64::consts::TAU;

use shared::model::cart::{CartDrive, LoopParams};
use shared::model::contact::Law;
use shared::model::params::RigParams;

use super::dense::{Square, dot};
use super::{Beam, ModalRig};
use crate::error::{Error, ModesError};

/// A step turns the fastest motion by no more than this, rad.
const TURN_PER_STEP: f64 = 0.5;
/// Halvings of a step in which a switch is located.
const HALVINGS: u32 = 44;
/// Newton steps before giving up.
const ITERATIONS: usize = 20;
/// A fixed point is found when the return map moves it by less than this share of A0 and A0 Ω.
const CLOSURE: f64 = 1e-9;
/// Onsets in a period beyond which it is given up.
const MOST_ONSETS: u32 = 60;

/// A shaker that holds a cart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// The position loop.
    pub held: LoopParams,
    /// Mass M of the cart, kg.
    pub cart_kg: f64,
    /// Mass of hammer and springs, kg.
    pub hung_kg: f64,
}

/// The motion at one drive frequency.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Number of modes.
    modes: usize,
    /// Whether the cart recoils.
    recoils: bool,
    frequency_hz: f64,
    /// A0 Ω² and A0 Ω.
    units: (f64, f64),
    free: Phase,
    pressing: Phase,
    /// δ/A0, δ̇/(A0 Ω) and the law's F/(A0 Ω²), kg, as rows on the state.
    delta: Vec<f64>,
    rate: Vec<f64>,
    force: Vec<f64>,
    /// Base step.
    step: f64,
}

/// One of the two linear phases.
#[derive(Clone, Debug)]
struct Phase {
    a: Square,
    /// e^(A h), e^(2 A h), e^(4 A h) ...
    ladder: Vec<Square>,
}

impl Phase {
    fn new(a: Square, step: f64) -> Self {
        let mut ladder = vec![a.exponential(step)];
        while step * 2.0_f64.powi(ladder.len() as i32) < TAU {
            let last = &ladder[ladder.len() - 1];
            ladder.push(last.times(last));
        }
        Self { a, ladder }
    }

    /// e^(A t).
    fn over(&self, t: f64, step: f64) -> Square {
        let whole = (t / step).floor();
        let mut product = self.a.exponential(t - whole * step);
        for (k, power) in self.ladder.iter().enumerate() {
            if (whole as u64) >> k & 1 == 1 {
                product = power.times(&product);
            }
        }
        product
    }
}

/// A 1/1 orbit, or what else repeats after one period.
#[derive(Clone, Debug, PartialEq)]
pub struct ModalOrbit {
    /// Drive frequency, Hz.
    pub frequency_hz: f64,
    /// Onsets in the period.
    pub impacts: u32,
    /// Largest contact force, N.
    pub force_n: f64,
    /// Approach speed of the contact with it, m/s.
    pub approach_m_per_s: f64,
    /// Largest modulus of a multiplier.
    pub multiplier: f64,
    /// Where it is at drive phase 0, in A0 and A0 Ω.
    section: Vec<f64>,
}

impl ModalOrbit {
    /// Whether this is a stable 1/1.
    pub fn is_stable_one_one(&self) -> bool {
        self.impacts == 1 && self.multiplier < 1.0
    }
}

/// What happened in a period.
#[derive(Clone, Debug, Default)]
struct Seen {
    onsets: u32,
    /// Largest F/(A0 Ω²), kg, and the approach speed of its contact.
    force: f64,
    approach: f64,
    /// Phases passed: whether in contact, and for how long; after each but the last a saltation.
    pieces: Vec<(bool, f64)>,
    saltations: Vec<Square>,
}

impl Motion {
    /// `params` with the `count` lowest modes of `beam` at `frequency_hz`, its cart as in `params`.
    ///
    /// # Errors
    /// As [`ModalRig::new`], except that a gap may be negative: the orbits are not those of a start from rest, free of the
    /// surface. Also if the frequency is not a positive number.
    pub fn of(
        params: &RigParams,
        beam: Beam,
        count: usize,
        frequency_hz: f64,
    ) -> Result<Self, Error> {
        let open = RigParams {
            gap_m: params.gap_m.max(0.0),
            ..*params
        };
        let mut rig = ModalRig::new(&open, beam, count)?;
        rig.gap_m = params.gap_m;
        if !(frequency_hz > 0.0 && frequency_hz.is_finite()) {
            return Err(Error::Frequency(frequency_hz));
        }
        let held = match params.cart {
            CartDrive::Prescribed => None,
            CartDrive::Loop(held) => Some(Held {
                held,
                cart_kg: params.cart_mass_kg,
                hung_kg: params.mass_kg * (1.0 + beam.mass_ratio),
            }),
        };
        Self::new(&rig, held, frequency_hz)
    }

    /// `rig` at `frequency_hz`, held by `held` or prescribed.
    ///
    /// # Errors
    /// If the law is not the spring-dashpot.
    pub fn new(rig: &ModalRig, held: Option<Held>, frequency_hz: f64) -> Result<Self, Error> {
        let Law::SpringDashpot { stiffness, damping } = rig.law else {
            return Err(ModesError::Law.into());
        };
        let omega = TAU * frequency_hz;
        let n = rig.modes.len();
        let size = 2 * n + if held.is_some() { 2 } else { 0 } + 3;
        let one = size - 1;
        let (mut delta, mut rate) = (vec![0.0; size], vec![0.0; size]);
        delta[..n].fill(1.0);
        delta[one] = -rig.gap_m / rig.amplitude_m;
        rate[n..2 * n].fill(1.0);
        let force: Vec<f64> = (0..size)
            .map(|i| (stiffness * delta[i] / omega + damping * rate[i]) / omega)
            .collect();
        let inverse_mass: f64 = rig.modes.iter().map(|m| 1.0 / m.mass_kg).sum();
        let highest = rig.modes.iter().map(|m| m.omega).fold(0.0, f64::max);
        let in_contact = (stiffness * inverse_mass)
            .sqrt()
            .max(damping * inverse_mass);
        let step = TURN_PER_STEP * omega / highest.max(in_contact);
        let phase = |force: &[f64]| Phase::new(field(rig, held, omega, force), step);
        Ok(Self {
            modes: n,
            recoils: held.is_some(),
            frequency_hz,
            units: (rig.amplitude_m * omega * omega, rig.amplitude_m * omega),
            free: phase(&vec![0.0; size]),
            pressing: phase(&force),
            delta,
            rate,
            force,
            step,
        })
    }

    /// Size of the section.
    fn section_size(&self) -> usize {
        2 * self.modes + if self.recoils { 2 } else { 0 }
    }

    /// The state at drive phase 0 over a section point.
    fn at_phase_zero(&self, section: &[f64]) -> Vec<f64> {
        let mut z = section.to_vec();
        z.extend([0.0, 1.0, 1.0]);
        z
    }

    fn phase(&self, touching: bool) -> &Phase {
        if touching { &self.pressing } else { &self.free }
    }

    /// Whether the hammer touches and pushes.
    fn pushes(&self, z: &[f64]) -> bool {
        dot(&self.delta, z) > 0.0 && dot(&self.force, z) > 0.0
    }

    /// Runs from drive phase 0 to drive phase 0. `None` if the motion cannot be followed.
    fn run(&self, section: &[f64], mut seen: Option<&mut Seen>) -> Option<Vec<f64>> {
        let mut z = self.at_phase_zero(section);
        let mut touching = self.pushes(&z);
        let (mut left, mut since, mut onsets) = (TAU, 0.0, 0_u32);
        let mut approach = dot(&self.rate, &z);
        let mut next = z.clone();
        loop {
            let phase = self.phase(touching);
            let last = left <= self.step;
            let h = if last { left } else { self.step };
            if last {
                next = phase.a.exponential_of(h, &z);
            } else {
                phase.ladder[0].apply(&z, &mut next);
            }
            let switch = self.switch_within(touching, &z, &next, h);
            if touching && let Some(seen) = seen.as_deref_mut() {
                let until = switch.unwrap_or(h);
                let top = self.largest_force(&z, until);
                if top > seen.force {
                    (seen.force, seen.approach) = (top, approach);
                }
            }
            let Some(t) = switch else {
                since += h;
                if last {
                    if let Some(seen) = seen {
                        seen.onsets = onsets;
                        seen.pieces.push((touching, since));
                    }
                    next.truncate(self.section_size());
                    return next.iter().all(|x| x.is_finite()).then_some(next);
                }
                left -= h;
                std::mem::swap(&mut z, &mut next);
                continue;
            };
            z = phase.a.exponential_of(t, &z);
            left -= t;
            if let Some(seen) = seen.as_deref_mut() {
                seen.pieces.push((touching, since + t));
                seen.saltations.push(self.saltation(touching, &z)?);
            }
            (touching, since) = (!touching, 0.0);
            if touching {
                approach = dot(&self.rate, &z);
                onsets += 1;
                if onsets > MOST_ONSETS {
                    return None;
                }
            }
        }
    }

    /// When the hammer switches within a step of length `h` that begins at `z` and ends at `end`, as time since `z`: the
    /// first instant at which it is seen to push (or no more to).
    fn switch_within(&self, touching: bool, z: &[f64], end: &[f64], h: f64) -> Option<f64> {
        let phase = self.phase(touching);
        let switched = |z: &[f64]| self.pushes(z) != touching;
        let mut high = if switched(end) {
            h
        } else {
            // A short contact, or a short hop, inside the step: at the extreme of what is watched.
            let watched = if !touching && dot(&self.delta, z).min(dot(&self.delta, end)) < 0.0 {
                &self.delta
            } else {
                &self.force
            };
            let slope = |z: &[f64]| {
                let mut rate = vec![0.0; z.len()];
                phase.a.apply(z, &mut rate);
                dot(watched, &rate)
            };
            let turns = if touching {
                slope(z) < 0.0 && slope(end) > 0.0
            } else {
                slope(z) > 0.0 && slope(end) < 0.0
            };
            if !turns {
                return None;
            }
            let inside = bisect(h, 30, |t| {
                let there = slope(&phase.a.exponential_of(t, z));
                if touching { there > 0.0 } else { there < 0.0 }
            });
            if !switched(&phase.a.exponential_of(inside, z)) {
                return None;
            }
            inside
        };
        // Just after a switch the state is on the border and may round to either side.
        if switched(z) {
            high = high.min(h);
            let early = phase.a.exponential_of(1e-6 * h, z);
            if switched(&early) {
                return Some(1e-6 * h);
            }
        }
        Some(bisect(high, HALVINGS, |t| {
            switched(&phase.a.exponential_of(t, z))
        }))
    }

    /// The largest force within `h` from `z` on, in contact.
    fn largest_force(&self, z: &[f64], h: f64) -> f64 {
        let a = &self.pressing.a;
        let slope = |z: &[f64]| {
            let mut rate = vec![0.0; z.len()];
            a.apply(z, &mut rate);
            dot(&self.force, &rate)
        };
        let end = a.exponential_of(h, z);
        let ends = dot(&self.force, z).max(dot(&self.force, &end));
        if slope(z) > 0.0 && slope(&end) < 0.0 {
            let top = bisect(h, 30, |t| slope(&a.exponential_of(t, z)) < 0.0);
            return ends.max(dot(&self.force, &a.exponential_of(top, z)));
        }
        ends
    }

    /// What the switch out of `touching` at `z` makes of a small deviation. `None` where it grazes.
    fn saltation(&self, touching: bool, z: &[f64]) -> Option<Square> {
        let size = z.len();
        let (mut before, mut after) = (vec![0.0; size], vec![0.0; size]);
        self.phase(touching).a.apply(z, &mut before);
        self.phase(!touching).a.apply(z, &mut after);
        // An onset is where the later of the two becomes positive; a release, where the force vanishes.
        let by_force =
            touching || dot(&self.force, z) / self.stiffness_unit() < dot(&self.delta, z);
        let normal = if by_force { &self.force } else { &self.delta };
        let crossing = dot(normal, &before);
        if crossing == 0.0 {
            return None;
        }
        let mut saltation = Square::one(size);
        for i in 0..size {
            let jump = (after[i] - before[i]) / crossing;
            for (x, n) in saltation.row_mut(i).iter_mut().zip(normal) {
                *x += jump * n;
            }
        }
        Some(saltation)
    }

    /// F/(A0 Ω²) per δ/A0, kg.
    fn stiffness_unit(&self) -> f64 {
        self.force[0]
    }

    /// The section point after one period from `section`, and the derivative of the return map there.
    fn image(&self, section: &[f64]) -> Option<(Vec<f64>, Square, Seen)> {
        let mut seen = Seen::default();
        let end = self.run(section, Some(&mut seen))?;
        let mut product = Square::one(section.len() + 3);
        for (i, (touching, time)) in seen.pieces.iter().enumerate() {
            product = self.phase(*touching).over(*time, self.step).times(&product);
            if let Some(saltation) = seen.saltations.get(i) {
                product = saltation.times(&product);
            }
        }
        Some((end, product.block(section.len()), seen))
    }

    /// Where `periods` drive periods from rest lead.
    pub fn from_rest(&self, periods: u32) -> Option<Vec<f64>> {
        self.after(&vec![0.0; self.section_size()], periods)
    }

    /// Where `periods` drive periods lead from `section`.
    pub fn after(&self, section: &[f64], periods: u32) -> Option<Vec<f64>> {
        let mut at = section.to_vec();
        for _ in 0..periods {
            at = self.run(&at, None)?;
        }
        Some(at)
    }

    /// The orbit of one drive period near `guess`, by Newton's iteration on the return map. `None` if it does not settle,
    /// or leaves the hammer without contact.
    pub fn shoot(&self, guess: &[f64]) -> Option<ModalOrbit> {
        if guess.len() != self.section_size() {
            return None;
        }
        let mut x = guess.to_vec();
        for _ in 0..ITERATIONS {
            let (end, monodromy, seen) = self.image(&x)?;
            let miss: Vec<f64> = end.iter().zip(&x).map(|(e, x)| e - x).collect();
            let off = miss.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if off < CLOSURE {
                return (seen.force > 0.0).then(|| ModalOrbit {
                    frequency_hz: self.frequency_hz,
                    impacts: seen.onsets,
                    force_n: seen.force * self.units.0,
                    approach_m_per_s: seen.approach * self.units.1,
                    multiplier: monodromy.spectral_radius(),
                    section: x,
                });
            }
            let step = monodromy.solve_fixed(&miss)?;
            let length = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if !length.is_finite() {
                return None;
            }
            let damping = (3.0 / length).min(1.0);
            x.iter_mut().zip(step).for_each(|(x, s)| *x += damping * s);
        }
        None
    }

    /// The orbit that this motion settles on or near, sought first next to `near`, then after some periods from there, then
    /// from rest.
    pub fn orbit(&self, near: Option<&ModalOrbit>) -> Option<ModalOrbit> {
        const SETTLE: u32 = 60;
        const FROM_REST: u32 = 250;
        let stable = |found: Option<ModalOrbit>| found.filter(ModalOrbit::is_stable_one_one);
        let direct = near.and_then(|orbit| stable(self.shoot(&orbit.section)));
        let settled = || {
            let at = self.after(&near?.section, SETTLE)?;
            stable(self.shoot(&at))
        };
        let from_rest = || stable(self.shoot(&self.from_rest(FROM_REST)?));
        direct.or_else(settled).or_else(from_rest)
    }
}

/// The matrix of a phase whose contact force over A0 Ω² is `force`, as a row on the state.
fn field(rig: &ModalRig, held: Option<Held>, omega: f64, force: &[f64]) -> Square {
    let size = force.len();
    let (n, sine) = (rig.modes.len(), size - 3);
    let mut a = Square::zero(size);
    a.row_mut(sine)[sine + 1] = 1.0;
    a.row_mut(sine + 1)[sine] = -1.0;
    // What spring and damper of mode i hold back, over its mass.
    let holding = |i: usize| {
        let (own, mut row) = (rig.modes[i].omega / omega, vec![0.0; size]);
        row[i] = own * own;
        row[n + i] = 2.0 * rig.damping_ratio * own;
        row
    };
    let mut cart = vec![0.0; size];
    cart[sine] = -1.0;
    if let Some(Held {
        held,
        cart_kg,
        hung_kg,
    }) = held
    {
        let own = TAU * held.frequency_hz / omega;
        let carried: f64 = rig
            .modes
            .iter()
            .map(|m| m.participation_kg * m.participation_kg / m.mass_kg)
            .sum();
        let moved = cart_kg + hung_kg - carried;
        let mut push = vec![0.0; size];
        push[2 * n] = -cart_kg * own * own;
        push[2 * n + 1] = -2.0 * held.damping_ratio * cart_kg * own;
        push[sine] = -held.feed_forward * cart_kg;
        for (i, mode) in rig.modes.iter().enumerate() {
            for (sum, (h, f)) in push.iter_mut().zip(holding(i).iter().zip(force)) {
                *sum += mode.participation_kg * (h + f / mode.mass_kg);
            }
        }
        cart = push.iter().map(|x| x / moved).collect();
        a.row_mut(2 * n)[2 * n + 1] = 1.0;
        let deviation = a.row_mut(2 * n + 1);
        deviation.copy_from_slice(&cart);
        deviation[sine] += 1.0;
    }
    for (i, mode) in rig.modes.iter().enumerate() {
        a.row_mut(i)[n + i] = 1.0;
        let held_back = holding(i);
        let row = a.row_mut(n + i);
        for k in 0..size {
            row[k] = -(mode.participation_kg * cart[k] + force[k]) / mode.mass_kg - held_back[k];
        }
    }
    a
}

/// The first time up to `h` at which `after` holds, if it holds from there to `h`.
fn bisect(h: f64, halvings: u32, after: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, h);
    for _ in 0..halvings {
        let middle = 0.5 * (low + high);
        if after(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use shared::model::cart::ASSUMED_SHAKER;
    use shared::model::params::{BEAM_135, BEAM_170, SupportParams};

    use super::*;
    use crate::branch::one_one_branches;
    use crate::engine::Plan;
    use crate::modes::{BendingMode, Tip, observe};
    use crate::orbit::shoot_at;

    const BEAM: Beam = Beam {
        tip: Tip::Guided,
        mass_ratio: 0.1,
    };

    fn off(a: f64, b: f64) -> f64 {
        (a / b - 1.0).abs()
    }

    /// With one mode that has the hammer's mass this is the lumped rig, whose orbit the reference finds with a recoiling
    /// cart: another method, and the equations of `shared`.
    #[test]
    fn one_mode_of_the_hammer_s_mass_is_the_reference_with_a_recoiling_cart() {
        for (params, gap_m, ratio, loop_hz) in [
            (BEAM_170, 0.0, 2.0, 50.0),
            (BEAM_135, 1e-3, 1.7, 12.0),
            (BEAM_170, -0.05e-3, 1.5, 200.0),
        ] {
            let held = LoopParams {
                frequency_hz: loop_hz,
                feed_forward: 0.8,
                ..ASSUMED_SHAKER
            };
            let natural_frequency_hz = params.natural_frequency_hz();
            let params = RigParams {
                gap_m,
                cart: CartDrive::Loop(held),
                support: SupportParams::Beams {
                    natural_frequency_hz,
                    damping_ratio: 0.004,
                    cubic_stiffness_n_per_m3: Some(0.0),
                },
                ..params
            };
            let hz = ratio * natural_frequency_hz;
            let branch = &one_one_branches(&params, (1.0, 3.0))[0];
            let known = branch.at(&params, hz).unwrap();
            let open = RigParams {
                gap_m: gap_m.max(0.0),
                ..params
            };
            let mut rig = ModalRig::new(&open, BEAM, 1).unwrap();
            rig.gap_m = gap_m;
            rig.modes = vec![BendingMode {
                root: 1.0,
                omega: TAU * natural_frequency_hz,
                mass_kg: params.mass_kg,
                participation_kg: params.mass_kg,
            }];
            let held = Held {
                held,
                cart_kg: params.cart_mass_kg,
                hung_kg: params.mass_kg,
            };
            let motion = Motion::new(&rig, Some(held), hz).unwrap();
            let found = motion.orbit(None).unwrap();
            assert!(off(found.force_n, known.force_n) < 1e-7, "{found:?}");
            let speed = known.contact.approach_speed_m_per_s;
            assert!(off(found.approach_m_per_s, speed) < 1e-7, "{speed}");
            let multiplier = known.multipliers().modulus();
            assert!(off(found.multiplier, multiplier) < 1e-3, "{multiplier}");
            let shot = shoot_at(&params, hz, known.at(), 1).unwrap();
            assert!(off(shot.force_n, found.force_n) < 1e-7);
        }
    }

    /// With five modes and a prescribed cart, against runs from rest of the engine with closed-form flights and integrated
    /// contacts.
    #[test]
    fn five_modes_are_those_of_the_other_engine() {
        let cycles = Plan {
            cycles: 400,
            transient: 390,
        };
        for hz in [8.6, 9.07, 9.45] {
            let rig = ModalRig::new(&BEAM_170, BEAM, 5).unwrap();
            let found = Motion::of(&BEAM_170, BEAM, 5, hz).unwrap().orbit(None);
            let found = found.unwrap();
            let seen = observe(rig, hz, cycles).unwrap();
            assert!(off(found.force_n, seen.force_n) < 1e-6, "{hz}: {found:?}");
            let approach = seen.approach_m_per_s.unwrap();
            assert!(off(found.approach_m_per_s, approach) < 1e-6, "{hz}");
        }
    }

    /// The derivative of the return map against differences, in every direction, with five modes and a recoiling cart.
    #[test]
    fn the_derivative_is_that_of_the_return_map() {
        let params = RigParams {
            cart: CartDrive::Loop(ASSUMED_SHAKER),
            ..BEAM_170
        };
        let motion = Motion::of(&params, BEAM, 5, 9.0).unwrap();
        let orbit = motion.orbit(None).unwrap();
        let (_, derivative, _) = motion.image(&orbit.section).unwrap();
        for k in 0..orbit.section.len() {
            let h = 1e-6;
            let moved = |by: f64| {
                let mut at = orbit.section.clone();
                at[k] += by;
                motion.run(&at, None).unwrap()
            };
            let (up, down) = (moved(h), moved(-h));
            for i in 0..up.len() {
                let difference = (up[i] - down[i]) / (2.0 * h);
                let exact = derivative.row(i)[k];
                let size = exact.abs().max(1.0);
                assert!((difference - exact).abs() < 2e-4 * size, "{i} {k}");
            }
        }
    }
}
