//! The scenarios that come with the program.

/// Embeds a scenario's text under its name.
macro_rules! scenarios {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../../scenarios/", $name, ".toml")))),*]
    };
}

/// Name and text of each: what must be held first, then one per fault, by the fault's number.
pub const BUILTIN: [(&str, &str); 37] = scenarios![
    "field",
    "held-wires",
    "held-beam-170",
    "held-beam-150",
    "held-beam-135",
    "jump",
    "sudden-softening",
    "sudden-gap",
    "push",
    "push-stays",
    "drift",
    "softening",
    "receding",
    "drill",
    "hardening",
    "dropouts",
    "preload",
    "force-wanted",
    "emergency-stop",
    "over-force",
    "over-travel",
    "sensor-saturated",
    "sensor-open",
    "sensor-frozen",
    "sensor-out-of-family",
    "no-contact",
    "regime-lost",
    "overrun",
    "stale-samples",
    "link-timeout",
    "corrupt-settings",
    "watchdog-reset",
    "brown-out",
    "reset-while-driving",
    "crash",
    "not-off",
    "board-unfit",
];
