//! Bifurcations of the impact oscillator x″ + b x′ + x = F cos ωt with a hard stop at x = 1 against published values:
//! I. Ghosh, D. J. W. Simpson, "The VIVID function for numerically continuing periodic orbits arising from grazing
//! bifurcations of hybrid dynamical systems" (2025), arXiv:2510.16218; the numbers are those of the data that the authors
//! published with it (repository indrag49/VIVID). Their method shares nothing with this one: a closed-form flight, an
//! instantaneous impact with Newton's restitution, and Newton's iteration on a displacement instead of a return map.
//!
//! Here the stop is a spring and a damper of restitution 0.9. The limit of no contact time is taken by extrapolation.

use std::f64::consts::{PI, TAU};

use numerics::continuation::{Along, Family, Node, Special, Until, march};
use numerics::orbit::on_course;
use shared::model::contact::Law;
use shared::model::params::{BEAM_170, RigParams, SupportParams};

use crate::support::close;

const DAMPING: f64 = 0.04;
/// Damping ratio of the contact with restitution 0.9: the root of −2ζ/√(1 − ζ²) acos ζ = ln 0.9.
const CONTACT_ZETA: f64 = 0.034_265_204_126_232_7;

/// A published orbit with one impact in two drive periods: drive frequency and amplitude, time of the impact, the
/// velocity after it, and the multipliers, all without dimension.
struct Published {
    omega: f64,
    force: f64,
    impact_time: f64,
    velocity_after: f64,
    multipliers: [f64; 2],
}

const fn published(
    omega: f64,
    force: f64,
    impact_time: f64,
    velocity_after: f64,
    multipliers: [f64; 2],
) -> Published {
    Published {
        omega,
        force,
        impact_time,
        velocity_after,
        multipliers,
    }
}

/// A multiplier is −1, to 1e-5.
const DOUBLINGS: [Published; 6] = [
    published(
        0.80249,
        0.3576022084717227,
        7.936499440526944,
        -0.0151915948369205,
        [-1.0000009898961864, -0.4329682070279812],
    ),
    published(
        0.81,
        0.3475333988945534,
        7.853621017760602,
        -0.0587735894658258,
        [-0.9999966562546645, -0.435491848954372],
    ),
    published(
        0.83991,
        0.3258950696317931,
        7.54527783700457,
        -0.2405584283329816,
        [-0.9999918999130591, -0.4452249348845645],
    ),
    published(
        0.86991,
        0.3287420039833202,
        7.267914531224346,
        -0.4410949517703775,
        [-0.9999949990461723, -0.4545079056093076],
    ),
    published(
        0.92991,
        0.4035328993774537,
        6.7923913793733535,
        -0.9467051080202584,
        [-1.000005916568326, -0.471767821975666],
    ),
    published(
        0.98991,
        0.3670557392161986,
        6.438592986207429,
        -1.0326867486464448,
        [-0.999999175117101, -0.4874836565514036],
    ),
];

/// A multiplier is +1, to 1e-5.
const FOLDS: [Published; 5] = [
    published(
        0.799481,
        0.3622129610781197,
        0.0940693818417275,
        -0.0478825040478622,
        [0.4319481262743743, 1.000002327725857],
    ),
    published(
        0.799,
        0.3628362019762544,
        0.0717540987528719,
        -0.1116779142041118,
        [0.4317851125949386, 1.0000012958600444],
    ),
    published(
        0.797018,
        0.3642195966013557,
        -0.0196013568671589,
        -0.3676189298291192,
        [0.4311069904022914, 1.0000086000781878],
    ),
    published(
        0.793018,
        0.3615981065141077,
        -0.1979824377180655,
        -0.8261126798291532,
        [0.4297423818929037, 0.9999978697936707],
    ),
    published(
        0.789018,
        0.353133502077837,
        -0.3632201050102327,
        -1.1750454923291835,
        [0.4283610331303331, 1.0000040479597443],
    ),
];

/// The oscillator with a contact `times` shorter than Table 3.1's, at a gap of `1/force` in units of A0/ω².
fn oscillator(times: f64, gap_ratio: f64) -> RigParams {
    let stiffness = 5.5e6 * times * times;
    RigParams {
        support: SupportParams::Beams {
            natural_frequency_hz: BEAM_170.natural_frequency_hz(),
            damping_ratio: 0.5 * DAMPING,
            cubic_stiffness_n_per_m3: Some(0.0),
        },
        gap_m: gap_ratio * BEAM_170.amplitude_m,
        contact: Law::SpringDashpot {
            stiffness,
            damping: 2.0 * CONTACT_ZETA * (stiffness * BEAM_170.mass_kg).sqrt(),
        },
        ..BEAM_170
    }
}

impl Published {
    fn gap_ratio(&self) -> f64 {
        self.omega * self.omega / self.force
    }

    /// Coordinate from the surface and rate, where the drive of the cart has phase 0: there sin Ωt begins to rise, so
    /// ωt = −π/2 in the paper's cos ωt. From the impact on the flight is linear.
    fn section(&self) -> [f64; 2] {
        let (w, half) = (self.omega, 0.5 * DAMPING);
        let turning = (1.0 - half * half).sqrt();
        let (stiff, damp) = (1.0 - w * w, DAMPING * w);
        let forced = self.force / stiff.hypot(damp);
        let lag = damp.atan2(stiff);
        let particular = |t: f64| {
            let angle = w * t - lag;
            [forced * angle.cos(), -forced * w * angle.sin()]
        };
        let [x, v] = particular(self.impact_time);
        let (a, rate) = (1.0 - x, self.velocity_after - v);
        let phase = w * self.impact_time + 0.5 * PI;
        let flight = (TAU - phase.rem_euclid(TAU)) / w;
        let (sin, cos) = (turning * flight).sin_cos();
        let fade = (-half * flight).exp();
        let b = (rate + half * a) / turning;
        let free = fade * (a * cos + b * sin);
        let free_rate = fade * ((turning * b - half * a) * cos - (turning * a + half * b) * sin);
        let [x, v] = particular(self.impact_time + flight);
        let gap_m = self.gap_ratio() * BEAM_170.amplitude_m;
        let natural = TAU * BEAM_170.natural_frequency_hz();
        [(x + free - 1.0) * gap_m, (v + free_rate) * gap_m * natural]
    }

    fn family(&self, times: f64) -> Family {
        let hz = self.omega * BEAM_170.natural_frequency_hz();
        let params = oscillator(times, self.gap_ratio());
        Family::new(&params, Along::Gap(hz), 2).expect("a rig that can be computed")
    }

    /// The amplitude F at which the orbit followed from the published one has the special point `kind`.
    fn special(&self, kind: Special, times: f64) -> f64 {
        let family = self.family(times);
        let start = family.place(on_course(self.section()), self.gap_ratio());
        let along = [0.0, 1.0, 0.0, 0.0, 0.0];
        let seed = family
            .correct(start, along)
            .expect("the published orbit is near");
        let limits = (0.9 * self.gap_ratio(), 1.1 * self.gap_ratio());
        let is = |node: &Node| node.special == Some(kind);
        let found = [seed.clone(), seed.turned()]
            .into_iter()
            .flat_map(|seed| march(&family, &seed, limits, Until::Special).0);
        let distance = |n: &Node| (n.parameter() / self.gap_ratio() - 1.0).abs();
        let node = found
            .filter(is)
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let node = node.unwrap_or_else(|| panic!("{kind:?} at {} not found", self.omega));
        self.omega * self.omega / node.parameter()
    }
}

/// The limit of no contact time, from contacts 512, 1024 and 2048 times shorter than Table 3.1's: the errors of first and
/// second order cancel.
fn limit(found: [f64; 3]) -> f64 {
    let once = [0, 1].map(|k| 2.0 * found[k + 1] - found[k]);
    (4.0 * once[1] - once[0]) / 3.0
}

const TIMES: [f64; 3] = [512.0, 1024.0, 2048.0];

/// At a fold the multiplier leaves 1 with the root of the distance, so the published 1e-5 of a multiplier is 1e-10 of F.
#[test]
fn folds_are_the_published_ones() {
    for row in &FOLDS {
        let found = TIMES.map(|times| row.special(Special::Fold, times));
        println!("ω {}: {:.1e}", row.omega, limit(found) / row.force - 1.0);
        close("fold", limit(found), row.force, 1e-10);
        for (now, then) in found.iter().zip(&found[1..]) {
            let order = ((now / row.force - 1.0) / (then / row.force - 1.0)).log2();
            assert!(
                (order - 1.0).abs() < 0.05,
                "order {order} in the contact time"
            );
        }
    }
}

/// The doublings are published to 1e-5 of the multiplier, so the orbit's own multipliers are compared, too: at the
/// published place they are the published ones. Their product is e² exp(−b T), with nothing published.
#[test]
fn period_doublings_are_the_published_ones() {
    for row in &DOUBLINGS {
        let found = limit(TIMES.map(|times| row.special(Special::PeriodDoubling, times)));
        println!("ω {}: {:.1e}", row.omega, found / row.force - 1.0);
        close("doubling", found, row.force, 5e-6);
        let pairs = TIMES.map(|times| {
            let family = row.family(times);
            let node = family.node_at(row.gap_ratio(), on_course(row.section()));
            node.expect("the published orbit is near")
                .orbit
                .eigenvalues()
        });
        let mut product = 1.0;
        for (k, published) in row.multipliers.into_iter().enumerate() {
            let nearest = |pair: [(f64, f64); 2]| {
                let [a, b] = pair.map(|(real, _)| real);
                if (a < b) == (k == 0) { a } else { b }
            };
            let found = limit(pairs.map(nearest));
            println!("    multiplier {found:.9}, published {published:.9}");
            close("multiplier", found, published, 5e-8);
            product *= found;
        }
        let lost = 0.81 * (-DAMPING * 2.0 * TAU / row.omega).exp();
        println!("    product {:.1e}", product / lost - 1.0);
        close("product", product, lost, 5e-8);
    }
}

/// Away from bifurcations, to the five digits published.
#[test]
fn multipliers_on_the_way_are_the_published_ones() {
    let at = |omega, force, time, after| published(omega, force, time, after, [f64::NAN; 2]);
    let rows = [
        (
            at(
                0.81,
                0.36,
                7.755_681_336_950_062,
                -0.9 * 0.409_097_036_428_9,
            ),
            [(0.43378, -0.49732), (0.43378, 0.49732)],
        ),
        (
            at(
                0.799,
                0.363,
                0.034_154_055_932_653,
                -0.9 * 0.245_022_580_357_925,
            ),
            [(0.48702, 0.0), (0.88659, 0.0)],
        ),
    ];
    for (row, multipliers) in rows {
        let pairs = TIMES.map(|times| {
            let node = row
                .family(times)
                .node_at(row.gap_ratio(), on_course(row.section()));
            let mut pair = node
                .expect("the published orbit is near")
                .orbit
                .eigenvalues();
            pair.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            pair
        });
        for (k, (real, imaginary)) in multipliers.into_iter().enumerate() {
            let found = (limit(pairs.map(|p| p[k].0)), limit(pairs.map(|p| p[k].1)));
            let off = (found.0 - real).hypot(found.1 - imaginary);
            assert!(
                off < 1e-5,
                "ω {}: {found:?} for {real} {imaginary:+} i",
                row.omega
            );
        }
    }
}
