//! The spring-dashpot contact in closed form, inverted.

use crate::model::trig::sin_cos_f32;

/// A contact of the spring-dashpot law, as it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringDashpotContact {
    /// ω₀ = √(k/m), rad/s.
    pub omega: f32,
    /// Damping ratio ζ = c/(2 m ω₀).
    pub damping_ratio: f32,
    /// How long it lasts, s.
    pub duration_s: f32,
}

/// How long the force was above a threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Above {
    /// Time for which the force was above the threshold, s.
    pub duration_s: f32,
    /// The threshold over m v, v the approach speed, 1/s.
    pub threshold: f32,
    /// Excess of that time, s: the first less the second times threshold over initial force.
    pub late_s: (f32, f32),
}

/// The spring-dashpot that rebounds at `restitution` of the approach speed and stays `above` a threshold that
/// long; the search starts at ω₀ = `guess` rad/s. None for a restitution below e⁻² = 0.135, which no underdamped
/// contact has, or of 1 and above, or if the search does not settle.
pub fn spring_dashpot(restitution: f32, above: &Above, guess: f32) -> Option<SpringDashpotContact> {
    if !(restitution > 0.14 && restitution < 0.99) {
        return None;
    }
    let psi = libm::sqrtf(angle_squared(-0.5 * libm::logf(restitution)));
    let (sin, zeta) = sin_cos_f32(psi);
    let turns = 2.0 * psi / sin;
    let (mut omega, mut change) = (guess, f32::INFINITY);
    for _ in 0..12 {
        let q = above.threshold / (omega * restitution);
        // ω₀τ + ζ(ω₀τ)² = q, the positive root without cancellation.
        let early = 2.0 * q / (1.0 + libm::sqrtf(1.0 + 4.0 * zeta * q));
        let (late, less) = above.late_s;
        let share = above.threshold / (2.0 * zeta * omega);
        let next = (turns - early) / (above.duration_s - (late - less * share));
        if !(next > 0.0 && next.is_finite()) {
            return None;
        }
        change = next / omega - 1.0;
        omega = next;
    }
    (change < 1e-3 && change > -1e-3).then_some(SpringDashpotContact {
        omega,
        damping_ratio: zeta,
        duration_s: turns / omega,
    })
}

/// u = ψ² with ψ cot ψ = `half`, 0 to 1, for ψ up to π/2: five Newton steps on the series
/// ψ cot ψ = 1 − u/3 − u²/45 − 2u³/945 − …, whose terms fall by u/π², at least fourfold.
fn angle_squared(half: f32) -> f32 {
    const SERIES: [f32; 10] = [
        1.0 / 3.0,
        1.0 / 45.0,
        2.0 / 945.0,
        1.0 / 4_725.0,
        2.0 / 93_555.0,
        1_382.0 / 638_512_875.0,
        4.0 / 18_243_225.0,
        3_617.0 / 162_820_783_125.0,
        87_734.0 / 38_979_295_480_125.0,
        349_222.0 / 1_531_329_465_290_625.0,
    ];
    let wanted = 1.0 - half;
    let mut u = 3.0 * wanted;
    for _ in 0..5 {
        let (mut value, mut slope) = (0.0_f32, 0.0_f32);
        for term in SERIES.iter().rev() {
            slope = slope * u + value;
            value = value * u + term;
        }
        // value is the series over u.
        let excess = u * value - wanted;
        u -= excess / (value + u * slope);
        u = if u > 0.0 { u } else { 0.0 };
    }
    u
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closed_form_gives_back_table_3_1() {
        // k 5.5e6, c 1.2e3, m 0.298: ω0 4296.0956, ζ 0.468666, restitution 0.316902, 0.570751 ms.
        let (omega, zeta) = (4_296.095_6_f64, 0.468_666_f64);
        let psi = zeta.acos();
        let restitution = (-2.0 * psi / psi.tan()).exp();
        let turns = 2.0 * psi / psi.sin();
        let above = Above {
            duration_s: (turns / omega) as f32,
            threshold: 0.0,
            late_s: (0.0, 0.0),
        };
        let found = spring_dashpot(restitution as f32, &above, 6_000.0).unwrap();
        assert!((f64::from(found.omega) / omega - 1.0).abs() < 1e-5);
        assert!((f64::from(found.damping_ratio) / zeta - 1.0).abs() < 1e-5);
        assert!((f64::from(found.duration_s) - 0.570_751e-3).abs() < 2e-8);
    }

    #[test]
    fn the_time_above_a_threshold_is_the_contact_less_its_end() {
        // Table 3.1 at 0.08 m/s, integrated until the force falls through 14.4 N.
        let (k, c, m, h) = (5.5e6_f64, 1.2e3, 0.298, 1e-8);
        let (mut x, mut v, mut t) = (0.0_f64, 0.08_f64, 0.0_f64);
        while k * x + c * v > 14.4 {
            v -= h * (k * x + c * v) / m;
            x += h * v;
            t += h;
        }
        let above = Above {
            duration_s: t as f32,
            threshold: (14.4 / (m * 0.08)) as f32,
            late_s: (0.0, 0.0),
        };
        let found = spring_dashpot(0.316_902, &above, 6_000.0).unwrap();
        // The end of the contact is taken to second order in τ.
        let off = f64::from(found.omega) / (k / m).sqrt() - 1.0;
        assert!(off.abs() < 0.01, "{off}");
    }

    #[test]
    fn the_series_is_inverted_over_its_whole_range() {
        for i in 1..=100 {
            let psi = f64::from(i) * 0.0155;
            let half = psi / psi.tan();
            let found = f64::from(angle_squared(half as f32)).sqrt();
            // Near ψ = 0 the square of ψ is the difference of two numbers near 1.
            assert!((found - psi).abs() < 2e-5 + 1e-7 / psi, "{psi}: {found}");
        }
    }
}
