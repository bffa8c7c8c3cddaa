//! Decimal commas where a number needs a point.

/// What to write for the first number in `text` that has a decimal comma: `write 1.7 with a point`. None if there is none.
pub fn comma(text: &str) -> Option<String> {
    let part_of_number = |c: char| c.is_ascii_digit() || ",.+-".contains(c);
    let mut words = text.split(|c| !part_of_number(c));
    let pointed = words.find_map(|word| {
        let (whole, decimals) = word.split_once(',')?;
        let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        let signless = whole.trim_start_matches(['+', '-']);
        (digits(signless) && digits(decimals)).then(|| format!("{whole}.{decimals}"))
    })?;
    Some(format!("write {pointed} with a point"))
}

/// The advice of [`comma`] as the end of a message: `; write 1.7 with a point`. Empty if no number has a decimal comma.
pub fn hint(text: &str) -> String {
    comma(text).map_or(String::new(), |write| format!("; {write}"))
}

/// The advice of [`comma`] for line `number` (from 1) of a TOML file, without its comment. None if there is none.
pub fn comma_at(text: &str, number: usize) -> Option<String> {
    let line = text.lines().nth(number.checked_sub(1)?)?;
    let (_, value) = line.split_once('=')?;
    comma(value.split('#').next()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_with_a_decimal_comma_is_found() {
        for (text, pointed) in [
            ("10,99", "10.99"),
            ("mass_kg=0,3", "0.3"),
            ("1:3:0,01", "0.01"),
            (" -1,5mm ", "-1.5"),
        ] {
            let said = format!("write {pointed} with a point");
            assert_eq!(comma(text), Some(said.clone()), "{text}");
            assert_eq!(hint(text), format!("; {said}"), "{text}");
        }
        for text in ["", "1.5", "1,", "a,b", "1.5,2", "298,299,297", "5, 3"] {
            assert_eq!((comma(text), &*hint(text)), (None, ""), "{text}");
        }
    }
}
