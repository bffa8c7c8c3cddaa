//! The quantities that measured tables hold, by the names and units that instruments and spreadsheets give them.

/// A quantity: the column's name here, what else it may be called, and its units with the factor to the unit of the name.
pub struct ColumnQuantity {
    pub column: &'static str,
    names: &'static [&'static str],
    units: &'static [(&'static str, f64)],
}

const LENGTHS: &[(&str, f64)] = &[
    ("mm", 1.0),
    ("m", 1e3),
    ("cm", 10.0),
    ("um", 1e-3),
    ("µm", 1e-3),
    ("μm", 1e-3),
    ("millimetre", 1.0),
    ("millimeter", 1.0),
    ("metre", 1e3),
    ("meter", 1e3),
];

const QUANTITIES: &[ColumnQuantity] = &[
    ColumnQuantity {
        column: "time_s",
        names: &["time", "t"],
        units: &[
            ("s", 1.0),
            ("ms", 1e-3),
            ("us", 1e-6),
            ("µs", 1e-6),
            ("μs", 1e-6),
            ("sec", 1.0),
            ("second", 1.0),
            ("seconds", 1.0),
            ("millisecond", 1e-3),
            ("milliseconds", 1e-3),
        ],
    },
    ColumnQuantity {
        column: "force_n",
        names: &["force"],
        units: &[
            ("N", 1.0),
            ("mN", 1e-3),
            ("kN", 1e3),
            ("newton", 1.0),
            ("newtons", 1.0),
        ],
    },
    ColumnQuantity {
        column: "displacement_mm",
        names: &["displacement", "hammer"],
        units: LENGTHS,
    },
    ColumnQuantity {
        column: "cart_mm",
        names: &["cart"],
        units: LENGTHS,
    },
    ColumnQuantity {
        column: "gap_mm",
        names: &["gap"],
        units: LENGTHS,
    },
    ColumnQuantity {
        column: "frequency_hz",
        names: &["frequency", "freq"],
        units: &[("Hz", 1.0), ("kHz", 1e3), ("hertz", 1.0)],
    },
    ColumnQuantity {
        column: "regime",
        names: &[],
        units: &[],
    },
];

/// What the name of a column says.
#[derive(Clone, Copy)]
pub struct NamedColumn {
    pub quantity: &'static ColumnQuantity,
    /// The unit in the name.
    pub unit: Option<Unit>,
    /// It is the name used here, unit included.
    pub plain: bool,
}

/// A unit of a quantity: its name, and the factor to the unit of the column here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    pub name: &'static str,
    pub factor: f64,
}

/// The quantity that a column's name says: `time_s`, `Time (ms)`, `force [kN]`, `displacement_m` or `Force`.
pub fn of_name(name: &str) -> Option<NamedColumn> {
    if let Some(quantity) = QUANTITIES.iter().find(|q| q.column == name) {
        return Some(NamedColumn {
            quantity,
            unit: quantity.units.first().map(unit),
            plain: true,
        });
    }
    let name = name.to_lowercase();
    let (base, unit) = match name.find(['(', '[']) {
        Some(at) => (&name[..at], Some(bare(&name[at..]))),
        None => match name.rsplit_once('_') {
            Some((base, unit)) => (base, Some(unit)),
            None => (name.as_str(), None),
        },
    };
    let base = base.trim();
    let quantity = QUANTITIES.iter().find(|q| q.names.contains(&base))?;
    let unit = match unit {
        Some(unit) => Some(quantity.unit(unit)?),
        None => None,
    };
    Some(NamedColumn {
        quantity,
        unit,
        plain: false,
    })
}

/// A unit without its brackets.
fn bare(text: &str) -> &str {
    text.trim_matches(|c: char| c.is_whitespace() || "()[]".contains(c))
}

fn unit((name, factor): &(&'static str, f64)) -> Unit {
    Unit {
        name,
        factor: *factor,
    }
}

impl ColumnQuantity {
    /// The unit of that name, in brackets or not.
    pub fn unit(&self, text: &str) -> Option<Unit> {
        let text = bare(text);
        let lower = text.to_lowercase();
        // "mN" and "MN" are a thousand million apart.
        if text.starts_with('M') && lower.len() <= 3 {
            return None;
        }
        self.units
            .iter()
            .find(|(name, _)| name.to_lowercase() == lower)
            .map(unit)
    }

    /// The units there are, in words.
    pub fn units(&self) -> String {
        let names: Vec<_> = self.units.iter().map(|(name, _)| *name).collect();
        names.join(", ")
    }

    /// Whether its values are numbers.
    pub fn is_number(&self) -> bool {
        !self.units.is_empty()
    }
}
