//! What acts on the cart beside its drive and the hammer: friction of its guide, end stops, and gravity where the rig is
//! tilted.

/// Distance over which friction builds up before the cart slides, m.
const PRESLIDING_M: f64 = 20e-6;

/// Speed above which static friction has given way to sliding friction, m/s.
const STRIBECK_M_PER_S: f64 = 1e-3;

/// Friction of the cart's guide (LuGre without the bristles' own damping): Coulomb friction that sticks, and viscous
/// friction. The bristles' bend p is a state: ṗ = w − |w| p σ/g(w), friction = σ p + b w, where g falls from the
/// static to the sliding friction with speed. It takes σ² p² |w|/g + b w² ≥ 0 and stores σ p²/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// While it slides, N.
    pub coulomb_n: f64,
    /// Before it slides, N; at least `coulomb_n`.
    pub static_n: f64,
    /// Viscous friction per speed of the cart, N·s/m.
    pub viscous_n_s_per_m: f64,
}

impl Friction {
    fn stiffness(&self) -> f64 {
        self.static_n / PRESLIDING_M
    }

    /// Force against the motion (N), rate of the bristles' bend (m/s) and power lost (W) at a bend and a speed.
    #[inline]
    pub fn at(&self, bend_m: f64, speed: f64) -> (f64, f64, f64) {
        let viscous = self.viscous_n_s_per_m * speed;
        if self.static_n <= 0.0 {
            return (viscous, 0.0, viscous * speed);
        }
        let fast = speed / STRIBECK_M_PER_S;
        let level = self.coulomb_n + (self.static_n - self.coulomb_n) * (-fast * fast).exp();
        let spring = self.stiffness() * bend_m;
        let slip = speed.abs() * spring / level;
        (
            spring + viscous,
            speed - slip,
            spring * slip + viscous * speed,
        )
    }

    /// Energy in the bristles, J.
    pub fn energy_j(&self, bend_m: f64) -> f64 {
        0.5 * self.stiffness() * bend_m * bend_m
    }
}

/// End stops at both sides of the cart's travel: F = k d (1 + λ ḋ) ≥ 0 at a penetration d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stops {
    /// From the middle, m.
    pub at_m: f64,
    /// Stiffness k of a stop, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping λ of a stop: the share by which its force grows per speed of penetration, s/m.
    pub damping_s_per_m: f64,
}

impl Stops {
    /// Force on the cart (N) and power lost (W).
    #[inline]
    pub fn at(&self, position: f64, speed: f64) -> (f64, f64) {
        let depth = position.abs() - self.at_m;
        if depth <= 0.0 {
            return (0.0, 0.0);
        }
        let side = position.signum();
        let (rate, spring) = (side * speed, self.stiffness_n_per_m * depth);
        let force = (spring * (1.0 + self.damping_s_per_m * rate)).max(0.0);
        (-side * force, (force - spring) * rate)
    }

    /// Energy in the stop, J.
    pub fn energy_j(&self, position: f64) -> f64 {
        let depth = (position.abs() - self.at_m).max(0.0);
        0.5 * self.stiffness_n_per_m * depth * depth
    }
}

/// How the cart is mounted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mounting {
    /// Friction of the guide.
    pub friction: Option<Friction>,
    /// End stops at both sides of the cart's travel; none: it can move without limit.
    pub stops: Option<Stops>,
    /// Tilt of the whole rig, rad: positive, and the hammer falls towards the surface.
    pub tilt_rad: f64,
}
