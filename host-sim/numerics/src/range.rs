//! The ranges that the numbers of a request must be in.

use crate::error::Error;

/// Refuses the first of the numbers (its option, its value, the least and the most) that is out of its range.
pub(crate) fn within<const N: usize>(
    numbers: [(&'static str, f64, f64, f64); N],
) -> Result<(), Error> {
    let wrong = numbers
        .into_iter()
        .find(|(_, value, low, high)| !(low..=high).contains(&value));
    wrong.map_or(Ok(()), |(option, value, low, high)| {
        Err(Error::OutOfRange {
            option,
            value,
            low,
            high,
        })
    })
}

/// Refuses more samples than `most`.
pub(crate) fn within_samples(samples: u32, most: u32) -> Result<(), Error> {
    if samples > most {
        return Err(Error::Samples { samples, most });
    }
    Ok(())
}
