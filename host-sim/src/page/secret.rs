//! The random part of the address.

use std::fmt::{self, Debug, Formatter, Write};

use files::UserError;
use subtle::ConstantTimeEq;

/// Random bytes in it.
const BYTES: usize = 32;

/// 256 random bits, as hexadecimal digits.
#[derive(Clone)]
pub struct Secret(String);

impl Secret {
    /// From the system's randomness.
    ///
    /// # Errors
    /// If the system gives none.
    pub fn new() -> Result<Self, UserError> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes).map_err(|e| {
            UserError::new(format!(
                "the system gives no random numbers ({e}), and without a secret the page is not served; try again"
            ))
        })?;
        let mut text = String::new();
        for byte in bytes {
            // Writing to a string does not fail.
            let _ = write!(text, "{byte:02x}");
        }
        Ok(Self(text))
    }

    /// Whether `given` is it, in a time that does not tell how much of it is right.
    pub fn is(&self, given: &str) -> bool {
        self.0.as_bytes().ct_eq(given.as_bytes()).into()
    }

    /// The secret as hexadecimal digits, as the address has it.
    pub fn text(&self) -> &str {
        &self.0
    }
}

/// Does not show it.
impl Debug for Secret {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("Secret")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_256_bits_differs_each_time_and_is_not_shown() {
        let [one, other] = [(); 2].map(|()| Secret::new().expect("randomness"));
        assert_eq!(one.text().len(), 64);
        assert_ne!(one.text(), other.text());
        assert!(one.is(one.text()));
        for wrong in [
            "",
            other.text(),
            &one.text()[1..],
            &one.text().to_uppercase(),
        ] {
            assert!(wrong == one.text() || !one.is(wrong), "{wrong}");
        }
        assert!(!format!("{one:?}").contains(one.text()));
    }
}
