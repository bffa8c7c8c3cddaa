//! Licence expressions as Cargo's manifests have them, `(MIT OR Apache-2.0) AND Unicode-3.0`, and whether a list of licences
//! satisfies them.

/// Whether `text` can be satisfied with licences for which `allowed` is true; an error if it is no expression.
pub fn satisfied(text: &str, allowed: &dyn Fn(&str) -> bool) -> Result<bool, String> {
    // Older manifests have a slash for OR.
    let spaced = text
        .replace('/', " OR ")
        .replace('(', " ( ")
        .replace(')', " ) ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut reader = Reader {
        words: &words,
        allowed,
    };
    match reader.any() {
        Some(answer) if reader.words.is_empty() => Ok(answer),
        _ => Err(format!("cannot make sense of the licence '{text}'")),
    }
}

struct Reader<'a> {
    words: &'a [&'a str],
    allowed: &'a dyn Fn(&str) -> bool,
}

impl<'a> Reader<'a> {
    fn take(&mut self, word: &str) -> bool {
        let there = self.words.first() == Some(&word);
        if there {
            self.words = &self.words[1..];
        }
        there
    }

    fn any(&mut self) -> Option<bool> {
        let mut answer = self.all()?;
        while self.take("OR") {
            answer |= self.all()?;
        }
        Some(answer)
    }

    fn all(&mut self) -> Option<bool> {
        let mut answer = self.one()?;
        while self.take("AND") {
            answer &= self.one()?;
        }
        Some(answer)
    }

    fn one(&mut self) -> Option<bool> {
        if self.take("(") {
            let answer = self.any()?;
            return self.take(")").then_some(answer);
        }
        let name = self.name()?;
        if self.take("WITH") {
            let exception = self.name()?;
            return Some((self.allowed)(&format!("{name} WITH {exception}")));
        }
        Some((self.allowed)(name))
    }

    fn name(&mut self) -> Option<&'a str> {
        let (name, rest) = self.words.split_first()?;
        let word = !["(", ")", "AND", "OR", "WITH"].contains(name);
        self.words = rest;
        word.then_some(*name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(list: &[&str], text: &str) -> Result<bool, String> {
        satisfied(text, &|name| list.contains(&name))
    }

    #[test]
    fn and_binds_more_than_or_and_parentheses_more_than_both() {
        for (text, expected) in [
            ("MIT", true),
            ("GPL-3.0-only", false),
            ("MIT OR GPL-3.0-only", true),
            ("GPL-3.0-only AND MIT", false),
            ("GPL-3.0-only AND X OR MIT", true),
            ("GPL-3.0-only AND (X OR MIT)", false),
            ("(MIT OR X) AND Unicode-3.0", true),
            ("Unlicense/MIT", true),
            ("Apache-2.0 WITH LLVM-exception", false),
        ] {
            assert_eq!(with(&["MIT", "Unicode-3.0"], text), Ok(expected), "{text}");
        }
        let list = ["Apache-2.0 WITH LLVM-exception"];
        assert_eq!(with(&list, "Apache-2.0 WITH LLVM-exception"), Ok(true));
        assert_eq!(with(&list, "Apache-2.0"), Ok(false));
    }

    #[test]
    fn what_is_no_expression_is_an_error() {
        for text in ["", "MIT OR", "(MIT", "MIT MIT", "AND MIT", "MIT)"] {
            assert!(with(&["MIT"], text).is_err(), "{text}");
        }
    }
}
