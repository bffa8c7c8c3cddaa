//! Curves of periodic orbits over frequency or gap.

use numerics::continuation::table::OrbitsAnswer;
use numerics::continuation::{Along, OrbitsRequest, diagram};
use pyo3::prelude::*;

use crate::arguments::{Keywords, choice, two_frequencies};
use crate::error::{from_numerics, wrong};
use crate::values::{fields, record, table};

#[pyfunction]
pub fn orbits(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let mut rig = asked.rig()?;
    let (starts, checks) = (asked.take("starts")?, asked.take::<Option<_>>("checks")?);
    if checks > Some(20_000) {
        return Err(wrong("checks must be at most 20000"));
    }
    let natural_hz = rig.params.natural_frequency_hz();
    let (given, unit, argument) = match (asked.numbers("ratio")?, asked.numbers("frequency_hz")?) {
        (Some(_), Some(_)) => return Err(two_frequencies()),
        (Some(ratio), None) => (Some(ratio), 1.0, "ratio"),
        (None, Some(hz)) => (Some(hz), natural_hz, "frequency_hz"),
        (None, None) => (None, 1.0, "ratio"),
    };
    let pair = |argument: &str, values: &[f64]| match values {
        [from, to] if from < to && from.is_finite() && to.is_finite() => Ok((*from, *to)),
        _ => Err(wrong(format!(
            "{argument} must be a rising pair (from, to) of finite numbers"
        ))),
    };
    let gap_mm = asked.numbers("gap_mm")?;
    let (along, limits) = match asked.take::<String>("along")?.as_str() {
        "frequency" => {
            match gap_mm.as_deref() {
                None => {}
                Some([mm]) => {
                    let there = rig.params.with_gap_mm(*mm);
                    rig.params = there.map_err(|e| from_numerics(e.into()))?;
                }
                Some(_) => return Err(wrong("gap_mm must be one number with along=\"frequency\"")),
            }
            let usual = [0.8, 4.0];
            let (from, to) = pair(argument, given.as_deref().unwrap_or(&usual))?;
            if from <= 0.0 {
                return Err(wrong(format!(
                    "{argument} begins at {from}, must be positive"
                )));
            }
            (Along::Frequency, (from / unit, to / unit))
        }
        "gap" => {
            let hz = match given.as_deref() {
                Some([one]) if *one > 0.0 && one.is_finite() => match argument {
                    "ratio" => *one * natural_hz,
                    _ => *one,
                },
                _ => {
                    return Err(wrong(
                        "along=\"gap\" needs one drive frequency: ratio or frequency_hz",
                    ));
                }
            };
            let usual = [0.0, 3.56];
            let (from, to) = pair("gap_mm", gap_mm.as_deref().unwrap_or(&usual))?;
            for mm in [from, to] {
                let there = rig.params.with_gap_mm(mm);
                there.map_err(|e| from_numerics(e.into()))?;
            }
            let amplitude_mm = rig.params.amplitude_m * 1e3;
            (Along::Gap(hz), (from / amplitude_mm, to / amplitude_mm))
        }
        other => return Err(choice("along", other, &["frequency", "gap"])),
    };
    let request = OrbitsRequest {
        along,
        limits,
        periods: asked.take("periods")?,
        impacts: asked.take("impacts")?,
        starts,
        checks: checks.unwrap_or_else(|| OrbitsRequest::usual_checks(&rig.params, starts)),
    };
    request.check().map_err(from_numerics)?;
    let found = asked.run(request.simulations(), |watch| {
        diagram(&rig.params, &request, watch)
    })?;
    let answer = OrbitsAnswer::new(&rig.name, &found);
    let whole = fields(py, &answer)?;
    whole.set_item("orbits", table(py, &answer.orbits)?)?;
    whole.set_item("special_points", table(py, &answer.special_points)?)?;
    record(whole)
}
