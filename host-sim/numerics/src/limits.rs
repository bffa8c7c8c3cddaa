//! What an operating point must respect.

use serde::Serialize;
use shared::model::cart::{CartDrive, UNLIMITED_N};
use shared::model::params::RigParams;

/// What the operating point must respect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PickLimits {
    /// Largest contact force allowed, N, for every member of the uncertainty.
    pub max_force_n: Option<f64>,
    /// Largest drive frequency allowed, Hz.
    pub max_frequency_hz: Option<f64>,
    /// Largest force of the shaker, N: with a cart that recoils the largest of its position loop, the recoil included; with a
    /// prescribed one what moves M + m. It takes the place of the rig's own.
    pub max_shaker_force_n: Option<f64>,
    /// Largest force of the rig's own shaker, N, if its cart recoils and it has one; `max_shaker_force_n` replaces it.
    pub rig_shaker_force_n: Option<f64>,
}

impl PickLimits {
    /// These limits and the one of the shaker of `params`, if its cart recoils.
    #[must_use]
    pub fn with_shaker_of(self, params: &RigParams) -> Self {
        let rig_shaker_force_n = match params.cart {
            CartDrive::Loop(held) if self.max_shaker_force_n.is_none() => {
                Some(held.max_force_n).filter(|most| *most < UNLIMITED_N)
            }
            _ => None,
        };
        Self {
            rig_shaker_force_n,
            ..self
        }
    }

    /// The largest force of the shaker of `params`, N.
    pub fn shaker_force_n(&self, params: &RigParams) -> Option<f64> {
        let of_rig = self.rig_shaker_force_n.filter(|_| params.cart.recoils());
        self.max_shaker_force_n.or(of_rig)
    }

    /// The others of these limits.
    #[must_use]
    pub fn without_the_shaker(self) -> Self {
        Self {
            max_shaker_force_n: None,
            rig_shaker_force_n: None,
            ..self
        }
    }

    /// Which of them decide: `more` says whether those that are left allow more. Where no limit does so alone, two do together:
    /// the fewest whose end gives more.
    pub fn which_decide(self, more: impl Fn(Self) -> bool) -> Vec<LimitUse> {
        let all = [
            ("max_force_n", self.max_force_n, 1),
            ("max_frequency_hz", self.max_frequency_hz, 2),
            ("max_shaker_force_n", self.max_shaker_force_n, 4),
            ("shaker_max_force_n", self.rig_shaker_force_n, 4),
        ];
        let given: Vec<_> = all.into_iter().filter(|l| l.1.is_some()).collect();
        let without = |ended: u32| {
            let mut left = match ended & 4 {
                0 => self,
                _ => self.without_the_shaker(),
            };
            left.max_force_n = left.max_force_n.filter(|_| ended & 1 == 0);
            left.max_frequency_hz = left.max_frequency_hz.filter(|_| ended & 2 == 0);
            left
        };
        let there = given.iter().fold(0, |all, (.., bit)| all | bit);
        let decide = |count: u32| {
            let sets = (1..8_u32).filter(move |set| set & !there == 0 && set.count_ones() == count);
            let found = sets.filter(|set| more(without(*set)));
            found.reduce(|all, set| all | set)
        };
        let fewest = (1..=3).find_map(|count| Some((count, decide(count)?)));
        let (count, deciding) = fewest.unwrap_or((0, 0));
        let used = given.into_iter().map(|(name, limit, bit)| LimitUse {
            name,
            limit,
            binds: deciding & bit != 0,
            together: deciding & bit != 0 && count > 1,
            ..LimitUse::default()
        });
        used.collect()
    }
}

/// A limit, and whether it decided the choice.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LimitUse {
    /// Its name, with its unit.
    pub name: &'static str,
    /// The limit; for the uncertainty, the band it leaves is `robust_band_hz`.
    pub limit: Option<f64>,
    /// Whether a larger force lies beyond it (or beyond it and another that decides).
    pub binds: bool,
    /// Whether it does so only together with another: without it alone there is no more.
    #[serde(skip)]
    pub together: bool,
    /// Whether nobody stated it: it is that of a shaker assumed for a preset.
    #[serde(skip)]
    pub assumed: bool,
}

impl LimitUse {
    /// The reserve that the frequency keeps from the ends of the robust range, where it decided.
    /// `kept`, Hz, is what it leaves of the range: one frequency where the range is too narrow for it.
    pub fn reserve(kept: (f64, f64)) -> Self {
        Self {
            name: if kept.0 < kept.1 { RESERVE } else { NARROW },
            binds: true,
            ..Self::default()
        }
    }

    /// Whether it is that reserve, and whole.
    pub fn is_reserve(&self) -> bool {
        self.name == RESERVE
    }

    /// Whether it is that reserve where the range is too narrow for it.
    pub fn is_narrow_reserve(&self) -> bool {
        self.name == NARROW
    }
}

/// The name of the reserve.
const RESERVE: &str = "the reserve of 1 %";
/// Its name where there is less of it.
const NARROW: &str = "a reserve of less than 1 %";
