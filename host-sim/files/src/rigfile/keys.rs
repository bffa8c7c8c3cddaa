//! The keys of a rig file, and the error that names one.

use shared::model::params::ParamError;

use crate::UserError;

/// Every key a rig file or `--set` may use, with what it means.
pub const KEYS: [(&str, &str); 23] = [
    (
        "preset",
        "rig to start from: wires, beam-170, beam-150 or beam-135",
    ),
    ("support", "what the hammer hangs on: wires or beams"),
    ("mass_kg", "hammer mass m"),
    (
        "cart_mass_kg",
        "cart mass M (what the shaker must give, and how far the cart recoils)",
    ),
    ("amplitude_mm", "cart amplitude A0"),
    ("gap_mm", "clearance at rest; negative: pressed on"),
    (
        "natural_frequency_hz",
        "natural frequency; sets the wire length on wires",
    ),
    (
        "wire_length_mm",
        "wire length l; sets the natural frequency",
    ),
    ("gravity_m_per_s2", "gravity g (wires)"),
    (
        "torque",
        "moment of the contact force on wires: literal (F l, as printed) or cosine (F l cos)",
    ),
    ("damping_ratio", "damping ratio of the beams"),
    (
        "cubic_stiffness_n_per_m3",
        "cubic stiffness of the beams; left out: numerically k",
    ),
    (
        "contact_law",
        "spring-dashpot, hertz, hunt-crossley or lankarani-nikravesh",
    ),
    (
        "contact_stiffness_n_per_m",
        "ki (N/m^n for the nonlinear laws)",
    ),
    ("contact_damping_n_s_per_m", "ci (spring-dashpot)"),
    ("contact_exponent", "n (nonlinear laws)"),
    (
        "contact_damping_ratio_s_per_m",
        "lambda = ci/ki (hunt-crossley)",
    ),
    ("contact_restitution", "e (lankarani-nikravesh)"),
    (
        "shaker_loop_hz",
        "natural frequency of the shaker's position loop with the cart alone; left out: the cart does not recoil",
    ),
    ("shaker_damping_ratio", "damping ratio of that loop"),
    (
        "shaker_feed_forward",
        "share of the force on the cart's mass that the shaker feeds forward",
    ),
    (
        "shaker_max_force_n",
        "largest force that the shaker can give",
    ),
    ("description", "free text"),
];

/// ` (did you mean 'x'?)`, if one of the names is like `word`; else nothing.
pub fn nearest<'a>(word: &str, among: impl Iterator<Item = &'a str>) -> String {
    // Two letters that changed places weigh too much in a short word.
    let slip = |candidate: &str| word.len() > 2 && strsim::osa_distance(word, candidate) == 1;
    // The dashes of options are alike in all.
    let bare = |word: &'a str| word.trim_start_matches('-');
    let alike = |candidate| strsim::jaro_winkler(word.trim_start_matches('-'), bare(candidate));
    let likeness = |candidate: &'a str| match slip(candidate) {
        true => 0.9_f64.max(alike(candidate)),
        false => alike(candidate),
    };
    among
        .map(|candidate| (likeness(candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(String::new(), |(_, candidate)| {
            format!(" (did you mean '{candidate}'?)")
        })
}

/// Why keys and values make no rig.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NoRig {
    /// The key that is wrong or missing.
    pub key: String,
    /// What is wrong and what to do, in one line.
    line: String,
}

impl NoRig {
    pub fn new(key: &str, line: String) -> Self {
        Self {
            key: key.to_owned(),
            line,
        }
    }
}

impl From<ParamError> for NoRig {
    fn from(error: ParamError) -> Self {
        Self::new(error.key, error.to_string())
    }
}

impl From<NoRig> for UserError {
    fn from(error: NoRig) -> Self {
        Self::new(error.line)
    }
}
