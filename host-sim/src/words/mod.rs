//! Sentences that put an answer into words.

pub mod compare;
pub mod gaps;
pub mod map;
pub mod over;

/// A number with so many digits behind the point; a dash where there is none.
pub fn number(x: Option<f64>, digits: usize) -> String {
    x.map_or("-".to_owned(), |x| format!("{x:.digits$}"))
}

/// As many rows as a person reads, evenly chosen, and the line that says how many there are if some are left out.
pub fn some_of<T>(rows: &[T]) -> (impl Iterator<Item = &T>, String) {
    let (count, every) = (rows.len(), rows.len().div_ceil(40).max(1));
    let left_out = match every {
        1 => String::new(),
        _ => format!("(every {every} of {count} rows; --format csv gives all)\n"),
    };
    (rows.iter().step_by(every), left_out)
}
