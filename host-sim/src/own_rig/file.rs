//! The text of a rig file in which every value has its source beside it.

use std::fmt::Write as _;

use files::rigfile::WIDTHS;
use files::words::digits::significant;

/// A rig file in the making.
#[derive(Clone, Debug, Default)]
pub struct RigFile {
    keys: Vec<Entry>,
    widths: Vec<Entry>,
}

#[derive(Clone, Debug)]
struct Entry {
    key: &'static str,
    value: String,
    source: String,
}

impl RigFile {
    /// Adds a key whose value is a word, with the source of it.
    pub fn word(&mut self, key: &'static str, word: &str, source: &str) {
        let value = format!("\"{word}\"");
        self.push(key, value, source);
    }

    /// Adds a key whose value is a number, rounded to six digits, with the source of it.
    pub fn number(&mut self, key: &'static str, value: f64, source: &str) {
        self.push(key, digits(value), source);
    }

    fn push(&mut self, key: &'static str, value: String, source: &str) {
        self.keys.push(Entry {
            key,
            value,
            source: one_line(source),
        });
    }

    /// The half-width `key`, rounded up to two digits and kept within what a rig file may state; where it is kept there, the
    /// source says so.
    pub fn width(&mut self, key: &'static str, value: f64, source: &str) {
        let below = WIDTHS.iter().find(|width| width.key == key);
        let most = below.map_or(f64::MAX, |width| 0.99 * width.below);
        let up = rounded_up(value);
        let source = if up > most {
            let unit = match key.rsplit('_').next() {
                Some("percent") => " %",
                Some("mm") => " mm",
                _ => "",
            };
            let found = significant(value, 3);
            format!("the most that is allowed; {source}: {found}{unit}")
        } else {
            source.to_owned()
        };
        self.widths.push(Entry {
            key,
            value: format!("{:?}", up.min(most)),
            source: one_line(&source),
        });
    }

    /// The lines for a person: what is known and from where.
    pub fn sources(&self) -> impl Iterator<Item = (&'static str, &str, &str)> {
        let all = self.keys.iter().chain(&self.widths);
        all.map(|entry| (entry.key, &*entry.value, &*entry.source))
    }

    /// The file for the rig `name`.
    pub fn text(&self, name: &str) -> String {
        let mut text = format!(
            "# Rig \"{}\", written by host-sim rig new {}. Use it with: host-sim pick --rig FILE.toml\n\n",
            one_line(name),
            env!("CARGO_PKG_VERSION")
        );
        let lines = |text: &mut String, entries: &[Entry]| {
            for Entry { key, value, source } in entries {
                // Writing into a string cannot fail.
                let _ = writeln!(text, "{key} = {value}  # {source}");
            }
        };
        lines(&mut text, &self.keys);
        text += "\n# How well each is known, either way. pick reads these; its options come before them.\n[uncertainty]\n";
        lines(&mut text, &self.widths);
        text
    }
}

/// Six digits: no one measures more.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// Two digits, never less than `value`.
fn rounded_up(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return 0.0;
    }
    let places = 1 - value.log10().floor() as i32;
    let scale = 10f64.powi(places);
    // What is only rounding above two digits is not another digit.
    let up = (value * scale - 1e-9).ceil();
    format!("{:e}", up / scale).parse().unwrap_or(value)
}

/// `text` as it may stand in a comment.
fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_rounded_up_to_two_digits() {
        for (value, shown) in [
            (0.0, 0.0),
            (0.1677, 0.17),
            (2.0, 2.0),
            (2.001, 2.1),
            (13.4, 14.0),
            (0.05, 0.05),
        ] {
            assert_eq!(rounded_up(value), shown);
        }
    }

    #[test]
    fn a_width_that_is_not_allowed_says_so() {
        let mut file = RigFile::default();
        file.width("mass_percent", 294.1, "as stated");
        file.width("gap_tolerance_mm", 12.0, "as stated");
        file.width("contact_stiffness_factor", 990.0, "contact time");
        let text = file.text("a");
        for said in [
            "mass_percent = 49.5  # the most that is allowed; as stated: 294 %\n",
            "gap_tolerance_mm = 9.9  # the most that is allowed; as stated: 12.0 mm\n",
            "contact_stiffness_factor = 990.0  # contact time\n",
        ] {
            assert!(text.contains(said), "{said}: {text}");
        }
    }

    #[test]
    fn a_line_break_in_a_source_does_not_end_the_comment() {
        let mut file = RigFile::default();
        file.number("mass_kg", 0.298_166_666, "weighed\nmass_kg = 1");
        file.width("mass_percent", 0.66, "");
        let text = file.text("a\nb");
        assert!(
            text.contains("mass_kg = 0.298167  # weighed mass_kg = 1\n"),
            "{text}"
        );
        assert_eq!(text.lines().count(), 7, "{text}");
    }
}
