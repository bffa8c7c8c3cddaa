//! A number of a rig as people meet it: its key, its meaning, its range, and the mistake of a number out of range.

/// A number of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// As rig files and the command line name it, with its unit.
    pub key: &'static str,
    /// What the number is, in words.
    pub meaning: &'static str,
    /// How many of its key's units one SI unit is.
    pub per_si_unit: f64,
    // Behind a reference, so that an image that checks ranges does not carry the meanings.
    allowed: &'static Allowed,
}

impl Number {
    pub(super) const fn new(
        key: &'static str,
        meaning: &'static str,
        allowed: &'static Allowed,
    ) -> Self {
        Self {
            key,
            meaning,
            per_si_unit: 1.0,
            allowed,
        }
    }

    /// This number with its key in millimetres.
    pub(super) const fn in_mm(self) -> Self {
        Self {
            per_si_unit: 1e3,
            ..self
        }
    }

    /// Lowest and highest value, in the unit of its key.
    pub const fn range(&self) -> (f64, f64) {
        (self.allowed.0, self.allowed.1)
    }

    /// Checks a value in SI units.
    #[inline]
    pub(super) fn check(&self, value: f64) -> Result<(), ParamError> {
        within(self.key, value * self.per_si_unit, self.allowed)
    }
}

/// Range of a number: lowest, highest, and the range in words. It is far wider than any rig; beyond it the
/// arithmetic overflows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Allowed(pub(super) f64, pub(super) f64, pub(super) &'static str);

/// A number out of range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParamError {
    /// Which number, with its unit, as the command line and rig files name it.
    pub key: &'static str,
    /// What it was, in the unit of `key`.
    pub value: f64,
    /// What it must be.
    pub must_be: &'static str,
}

impl core::fmt::Display for ParamError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            key,
            value,
            must_be,
        } = self;
        let size = value.abs();
        if size != 0.0 && !(1e-4..1e7).contains(&size) {
            // Without hundreds of digits.
            write!(f, "{key} is {value:e}, must be {must_be}")
        } else {
            write!(f, "{key} is {value}, must be {must_be}")
        }
    }
}

impl core::error::Error for ParamError {}

// One copy of it in the image is enough.
#[inline(never)]
pub(super) fn within(key: &'static str, value: f64, allowed: &Allowed) -> Result<(), ParamError> {
    let Allowed(from, to, must_be) = *allowed;
    ensure((from..=to).contains(&value), key, value, must_be)
}

pub(super) fn ensure(
    holds: bool,
    key: &'static str,
    value: f64,
    must_be: &'static str,
) -> Result<(), ParamError> {
    if holds {
        Ok(())
    } else {
        Err(ParamError {
            key,
            value,
            must_be,
        })
    }
}
