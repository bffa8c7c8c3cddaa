//! Sentences about answers, which the command line prints and its JSON carries.

pub mod digits;
#[cfg(not(target_family = "wasm"))]
pub mod identify;
pub mod pick;

/// So many of `what`, which is in the singular: "1 gap", "2 gaps", "3 frequencies".
pub fn count(n: usize, what: &str) -> String {
    match what.strip_suffix('y') {
        _ if n == 1 => format!("1 {what}"),
        Some(stem) => format!("{n} {stem}ies"),
        None => format!("{n} {what}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::count;

    #[test]
    fn one_is_singular() {
        let frequencies = [0, 1, 2].map(|n| count(n, "frequency"));
        assert_eq!(
            frequencies,
            ["0 frequencies", "1 frequency", "2 frequencies"]
        );
        assert_eq!([count(1, "gap"), count(2, "gap")], ["1 gap", "2 gaps"]);
    }
}
