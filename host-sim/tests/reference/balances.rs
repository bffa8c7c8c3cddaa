//! Energy and momentum: what goes in comes out, on every rig.

use numerics::reference::{LocatedContact, Reference, Segment, TrajectoryObserver};
use shared::model::params::{PRESETS, RigParams, SupportParams, Torque};

use crate::support::close;

const CYCLES: usize = 40;

/// Every preset, the wires with both torques, with a gap.
fn cases() -> Vec<(String, RigParams)> {
    let mut cases = Vec::new();
    for (name, params) in PRESETS {
        let params = RigParams {
            gap_m: 1e-3,
            ..params
        };
        cases.push((name.to_owned(), params));
        if let SupportParams::Wires { .. } = params.support {
            let mut corrected = params;
            if let SupportParams::Wires { torque, .. } = &mut corrected.support {
                *torque = Torque::Cosine;
            }
            cases.push((format!("{name}, F l cos"), corrected));
        }
    }
    cases
}

#[test]
fn work_in_is_work_out_and_energy_kept() {
    for (name, params) in cases() {
        let frequency_hz = 1.5 * params.natural_frequency_hz();
        let mut hammer = Reference::<f64>::at_rest(&params, frequency_hz).unwrap();
        let before = hammer.energy_j();
        let mut contacts = Vec::<LocatedContact>::new();
        for _ in 0..CYCLES {
            hammer.run_period(&mut contacts);
        }
        assert!(contacts.len() > CYCLES / 2, "{name}");
        let t = hammer.totals();
        let change = hammer.energy_j() - before;
        let balance = t.inertial_work - t.contact_work - t.damping_work - change;
        let relative = balance.abs() / t.inertial_work.abs();
        println!("{name}: {relative:.1e}");
        assert!(
            relative < 1e-11,
            "{name}: {relative:.1e} of the work put in"
        );
        let lost: f64 = contacts.iter().map(|c| c.energy_lost_j).sum();
        close(&name, lost, t.contact_work, 1e-12);
    }
}

/// ∫Δ dt and ∫Δ³ dt, from the integrator's own pieces.
#[derive(Default)]
struct Moments {
    gap_m: f64,
    first: f64,
    third: f64,
}

impl TrajectoryObserver for Moments {
    fn segment(&mut self, s: &Segment) {
        // Gauss–Legendre with 4 points.
        const NODES: [(f64, f64); 4] = [
            (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
            (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
        ];
        let (middle, half) = (0.5 * (s.start.t + s.end.t), 0.5 * (s.end.t - s.start.t));
        for (node, weight) in NODES {
            let x = s.at(middle + half * node).0 + self.gap_m;
            self.first += weight * half * x;
            self.third += weight * half * x.powi(3);
        }
    }
}

#[test]
fn the_contacts_impulse_balances_the_beams() {
    for (name, params) in PRESETS.into_iter().skip(1) {
        let params = RigParams {
            gap_m: 1e-3,
            ..params
        };
        let SupportParams::Beams {
            natural_frequency_hz,
            damping_ratio,
            ..
        } = params.support
        else {
            panic!("{name} hangs on beams");
        };
        let mut hammer = Reference::<f64>::at_rest(&params, 1.5 * natural_frequency_hz).unwrap();
        let mut moments = Moments {
            gap_m: params.gap_m,
            ..Moments::default()
        };
        for _ in 0..CYCLES {
            hammer.run_period(&mut moments);
        }
        let omega = std::f64::consts::TAU * natural_frequency_hz;
        let (m, k) = (params.mass_kg, params.mass_kg * omega * omega);
        let c = 2.0 * damping_ratio * omega * m;
        let (q, v) = hammer.state();
        // The drive's own impulse vanishes over whole periods.
        let expected = -m * v - c * (q + params.gap_m) - k * (moments.first + moments.third);
        // Limited by the quintic between the integrator's points, which only observers see.
        close(name, hammer.totals().impulse, expected, 1e-8);
    }
}
