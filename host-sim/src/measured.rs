//! Measured points from CSV files, to compare a result with. Each function tells `say` how the file was understood, if it was
//! not in the plain form.

use std::path::Path;

use files::{Measurements, TableLine, UserError};
use numerics::{bifurcation, map, sweep};
use shared::model::regime::{MAX_PERIODS, Regime};

/// Reads a CSV with the columns frequency_hz and force_n (others are passed over).
///
/// # Errors
/// One line naming file, line and mend.
pub fn force_curve(path: &Path, say: impl Fn(&str)) -> Result<sweep::MeasuredCurve, UserError> {
    let table = Measurements::read(path)?;
    let lines = table.lines(&["frequency_hz", "force_n"])?;
    let points = lines.map(|line| pair(&line?, "force_n"));
    let points = points.collect::<Result<_, _>>()?;
    table.said().into_iter().for_each(say);
    Ok(sweep::MeasuredCurve { points })
}

/// Reads a CSV with the column frequency_hz and displacement_mm, force_n or both.
///
/// # Errors
/// One line naming file, line and mend.
pub fn diagram(
    path: &Path,
    say: impl Fn(&str),
) -> Result<bifurcation::measured::MeasuredDiagram, UserError> {
    let table = Measurements::read(path)?;
    let [displacement, force] = ["displacement_mm", "force_n"].map(|column| table.has(column));
    if !displacement && !force {
        return Err(table.complaint("there is no column displacement_mm and none force_n; the first line must be frequency_hz,displacement_mm,force_n (one of the last two may be missing)"));
    }
    let pairs = |there: bool, column: &'static str| {
        if !there {
            return Ok(Vec::new());
        }
        let lines = table.lines(&["frequency_hz", column])?;
        lines.map(|line| pair(&line?, column)).collect()
    };
    let measured = bifurcation::measured::MeasuredDiagram {
        displacement_mm: pairs(displacement, "displacement_mm")?,
        force_n: pairs(force, "force_n")?,
    };
    table.said().into_iter().for_each(say);
    Ok(measured)
}

/// The frequency and the value of `column`; no force is negative.
fn pair(line: &TableLine, column: &str) -> Result<(f64, f64), UserError> {
    let hz = line.number("frequency_hz")?;
    if hz <= 0.0 {
        return Err(line.complaint(format!("frequency_hz is {hz}, must be positive")));
    }
    let value = line.number(column)?;
    if column == "force_n" && value < 0.0 {
        return Err(line.complaint(format!("force_n is {value}, must not be negative")));
    }
    Ok((hz, value))
}

/// Reads a CSV with the columns gap_mm, frequency_hz and regime ("1/1", "none", "aperiodic" or "chatter").
///
/// # Errors
/// One line naming file, line and mend.
pub fn regimes(
    path: &Path,
    say: impl Fn(&str),
) -> Result<Vec<map::measured::MeasuredRegime>, UserError> {
    let point = |line: &TableLine| {
        let frequency_hz = line.number("frequency_hz")?;
        if frequency_hz <= 0.0 {
            return Err(line.complaint(format!("frequency_hz is {frequency_hz}, must be positive")));
        }
        let text = line.text("regime");
        let regime = regime(text).ok_or_else(|| {
            line.complaint(format!(
                "regime is '{text}', must be p/n such as 1/1, or none, aperiodic or chatter"
            ))
        })?;
        Ok(map::measured::MeasuredRegime {
            gap_mm: line.number("gap_mm")?,
            frequency_hz,
            regime,
        })
    };
    let table = Measurements::read(path)?;
    let lines = table.lines(&["gap_mm", "frequency_hz", "regime"])?;
    let points = lines.map(|line| point(&line?));
    let points = points.collect::<Result<_, _>>()?;
    table.said().into_iter().for_each(say);
    Ok(points)
}

/// A regime by its name; how many impacts an aperiodic one has is not said by it.
fn regime(text: &str) -> Option<Regime> {
    match text {
        "none" => Some(Regime::None),
        "aperiodic" => Some(Regime::Aperiodic { impacts: 0 }),
        "chatter" => Some(Regime::Chatter {
            impacts: 0,
            periods: None,
        }),
        _ => {
            let (impacts, periods) = text.split_once('/')?;
            let (impacts, periods) = (impacts.trim().parse().ok()?, periods.trim().parse().ok()?);
            let known = (1..=MAX_PERIODS).contains(&usize::from(periods));
            known.then_some(Regime::Periodic { impacts, periods })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_line_is_named_by_its_number_whatever_is_blank_before_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("m.csv");
        let complaint = |text: &str| {
            std::fs::write(&path, text).unwrap();
            force_curve(&path, |_| {}).unwrap_err().to_string()
        };
        assert!(complaint("frequency_hz,force_n\n\n\nabc,1\n").contains("line 4: frequency_hz"));
        assert!(complaint("frequency_hz,force_n\r\n1,2\r\n3,x").contains("line 3: force_n"));
        assert!(complaint("frequency_hz,force_n\n1,2\n3\n").contains("line 3: 1 fields"));
    }
}
