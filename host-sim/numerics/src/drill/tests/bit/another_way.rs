//! The same equations once more, written apart: all bodies in the fixed frame, classical Runge–Kutta steps of fixed length,
//! and the end of each phase by bisection.

use super::bit;
use crate::drill::DrillSetting;
use crate::drill::blow::Feed;
use crate::drill::march::Drill;
use crate::drill::tests::rock;
use shared::model::params::{BEAM_170, SupportParams};

const M: f64 = 0.298;
const A0: f64 = 0.89e-3;
const K: f64 = 5.5e6;
const C: f64 = 1.2e3;
const PF: f64 = 25.0;

/// Hammer, its rate, bit, its rate, slider's bottom, top above it: all but the last in the fixed frame, m and m/s.
type State = [f64; 6];

#[derive(Clone, Copy, PartialEq)]
enum Ground {
    Off,
    Holds,
    Slips,
}

struct Model {
    omega: f64,
    natural: f64,
    zeta: f64,
    bit_kg: f64,
    feed_n: f64,
    blow: bool,
    ground: Ground,
}

impl Model {
    fn cart(&self, t: f64) -> (f64, f64) {
        let (sin, cos) = (self.omega * t).sin_cos();
        (A0 * sin, A0 * self.omega * cos)
    }

    fn blow_n(&self, s: &State) -> f64 {
        K * (s[0] - s[2]) + C * (s[1] - s[3])
    }

    /// Spring and dashpot under the bit, which is the slider's top; the bottom moves with the cart.
    fn held_n(&self, t: f64, s: &State) -> f64 {
        let (_, speed) = self.cart(t);
        K * (s[2] - s[4]) + C * (s[3] - speed)
    }

    fn rates(&self, t: f64, s: &State) -> State {
        let (y, speed) = self.cart(t);
        let blow = if self.blow { self.blow_n(s) } else { 0.0 };
        // The spring of the support has the cubic term of the model.
        let bent = s[0] - y;
        let k = M * self.natural * self.natural;
        let c = 2.0 * self.zeta * M * self.natural;
        let hammer = -(c * (s[1] - speed) + k * (bent + bent.powi(3)) + blow) / M;
        let (ground, bottom, top) = match self.ground {
            Ground::Off => (0.0, speed, -K / C * s[5]),
            Ground::Holds => (self.held_n(t, s), speed, s[3] - speed),
            Ground::Slips => {
                let top = (PF - K * s[5]) / C;
                (PF, s[3] - top, top)
            }
        };
        let bit = (blow + self.feed_n - ground) / self.bit_kg;
        [s[1], hammer, s[3], bit, bottom, top]
    }

    fn step(&self, t: f64, s: &State, h: f64) -> State {
        let along = |k: &State, by: f64| {
            let mut end = *s;
            (0..6).for_each(|i| end[i] += by * k[i]);
            end
        };
        let k1 = self.rates(t, s);
        let k2 = self.rates(t + 0.5 * h, &along(&k1, 0.5 * h));
        let k3 = self.rates(t + 0.5 * h, &along(&k2, 0.5 * h));
        let k4 = self.rates(t + h, &along(&k3, h));
        let mut end = *s;
        (0..6).for_each(|i| end[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        end
    }

    /// What the phases end by: positive while they last.
    fn last(&self, t: f64, s: &State) -> [f64; 2] {
        let x = K * (s[0] - s[2]);
        let blow = if self.blow {
            self.blow_n(s)
        } else {
            -x.min(self.blow_n(s))
        };
        let ground = match self.ground {
            Ground::Off => s[4] + s[5] - s[2],
            Ground::Holds => {
                let force = self.held_n(t, s);
                force.min(PF - force)
            }
            Ground::Slips => self.rates(t, s)[4] - self.cart(t).1,
        };
        [blow, ground]
    }

    fn switch(&mut self, t: f64, s: &State, which: usize) {
        if which == 0 {
            self.blow = !self.blow;
            return;
        }
        self.ground = match self.ground {
            Ground::Slips => Ground::Holds,
            Ground::Holds if self.held_n(t, s) < 0.5 * PF => Ground::Off,
            _ if self.held_n(t, s) >= PF || self.ground == Ground::Holds => Ground::Slips,
            _ => Ground::Holds,
        };
    }
}

/// Progress after `periods` drive periods from rest.
fn progress(model: &mut Model, periods: f64, h: f64) -> f64 {
    let (_, speed) = model.cart(0.0);
    let under = model.feed_n / K;
    let mut s: State = [0.0, speed, under, speed, 0.0, under];
    let (mut t, end) = (0.0, periods * std::f64::consts::TAU / model.omega);
    while t < end {
        let mut by = h.min(end - t);
        let mut to = model.step(t, &s, by);
        let ended = |last: [f64; 2]| last.iter().position(|x| *x < 0.0);
        let mut which = ended(model.last(t + by, &to));
        if which.is_some() {
            let (mut low, mut high) = (0.0, by);
            for _ in 0..60 {
                by = 0.5 * (low + high);
                let there = model.step(t, &s, by);
                match ended(model.last(t + by, &there)) {
                    Some(first) => (high, which) = (by, Some(first)),
                    None => low = by,
                }
            }
            by = high;
            to = model.step(t, &s, by);
        }
        (s, t) = (to, t + by);
        if let Some(which) = which {
            model.switch(t, &s, which);
        }
    }
    s[4] - model.cart(t).0
}

#[test]
fn another_integration_of_the_same_equations_digs_the_same() {
    let SupportParams::Beams {
        natural_frequency_hz,
        damping_ratio,
        ..
    } = BEAM_170.support
    else {
        panic!("beams");
    };
    let tau = std::f64::consts::TAU;
    let hz = 2.0 * natural_frequency_hz;
    for mass in [0.1, 0.4] {
        let bit = bit(mass);
        let mut model = Model {
            omega: tau * hz,
            natural: tau * natural_frequency_hz,
            zeta: damping_ratio,
            bit_kg: mass,
            feed_n: bit.feed_force,
            blow: false,
            ground: Ground::Holds,
        };
        let params = shared::model::params::RigParams {
            gap_m: 0.0,
            ..BEAM_170
        };
        let feed = Feed::Speed(0.0);
        let mut drill =
            Drill::<f64>::through(&params, &DrillSetting::new(rock(PF), Some(bit), feed), hz)
                .unwrap();
        for _ in 0..6 {
            drill.run_period(&mut Vec::new());
        }
        let known = progress(&mut model, 6.0, 2e-6);
        let apart = drill.drift_m() / known - 1.0;
        println!("{mass} kg: {} m, {apart}", drill.drift_m());
        assert!(known > 1e-5 && apart.abs() < 1e-7, "{mass} kg: {apart}");
    }
}
