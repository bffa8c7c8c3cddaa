//! Curves of periodic orbits over frequency or gap, and of their special points over two parameters.

use files::rigfile::nearest;
use numerics::NamedRig;
use numerics::continuation::table::OrbitsAnswer;
use numerics::continuation::two::{CurvesRequest, Dimension, Plane, Varied};
use numerics::continuation::{Along, FamilyDrive, OrbitsRequest, diagram};
use numerics::knob::Knob;
use numerics::progress::WithinStep;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shared::model::params::RigParams;

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
    let gap_mm = asked.numbers("gap_mm")?;
    let searches = asked.take("searches")?;
    if let Some(curve) = asked.take::<Option<Bound<'_, PyDict>>>("curve")? {
        let drive = (argument, given.as_deref());
        let plane = plane(&asked, &mut rig, &curve, drive, gap_mm.as_deref())?;
        let (periods, impacts) = (asked.take("periods")?, asked.take("impacts")?);
        let request = CurvesRequest {
            plane,
            search: CurvesRequest::search(periods, impacts, starts, checks.unwrap_or(0)),
            searches,
        };
        return curves(asked, &rig, &request);
    }
    let (along, limits) = match asked.take::<String>("along")?.as_str() {
        "frequency" => {
            match gap_mm.as_deref() {
                None => {}
                Some([mm]) => rig.params = at_gap(&rig, *mm)?,
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
                at_gap(&rig, mm)?;
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

/// The parameters of `rig` with another gap.
fn at_gap(rig: &NamedRig, mm: f64) -> PyResult<RigParams> {
    let there = rig.params.with_gap_mm(mm);
    there.map_err(|e| from_numerics(e.into()))
}

/// A range that rises.
fn pair(argument: &str, values: &[f64]) -> PyResult<(f64, f64)> {
    match values {
        [from, to] if from < to && from.is_finite() && to.is_finite() => Ok((*from, *to)),
        _ => Err(wrong(format!(
            "{argument} must be a rising pair (from, to) of finite numbers"
        ))),
    }
}

/// The plane over the one parameter of `curve` and the drive's frequency, or over its two at one frequency.
fn plane(
    asked: &Keywords<'_>,
    rig: &mut NamedRig,
    curve: &Bound<'_, PyDict>,
    (argument, given): (&'static str, Option<&[f64]>),
    gap_mm: Option<&[f64]>,
) -> PyResult<Plane> {
    if asked.take::<String>("along")? != "frequency" {
        return Err(wrong("curve goes with along=\"frequency\""));
    }
    match gap_mm {
        None => {}
        Some([mm]) if !curve.contains("gap_mm")? => rig.params = at_gap(rig, *mm)?,
        Some(_) => {
            return Err(wrong(
                "gap_mm must be one number, and left out with a curve over the gap",
            ));
        }
    }
    let (params, is_ratio) = (rig.params, argument == "ratio");
    let mut over = Vec::new();
    for (key, range) in curve {
        let key: String = key.extract()?;
        let knob = Knob::named(&key).ok_or_else(|| {
            let hint = nearest(&key, Knob::all().map(Knob::name));
            wrong(format!("curve: there is no number '{key}' of a rig{hint}"))
        })?;
        let (range, log) = match range.extract::<(f64, f64, String)>() {
            Ok((from, to, log)) if log == "log" => ([from, to], true),
            _ => (
                range.extract().map_err(|_| {
                    wrong(format!(
                        "curve: {key} must be (from, to) or (from, to, \"log\")"
                    ))
                })?,
                false,
            ),
        };
        let range = pair(&format!("curve: {key}"), &range)?;
        if log && range.0 <= 0.0 {
            return Err(wrong(format!(
                "curve: {key} begins at {}, must be positive with \"log\"",
                range.0
            )));
        }
        over.push(Dimension::new(Varied::Rig(knob), range, log, &params));
    }
    match (over.as_slice(), given) {
        (&[second], _) => {
            let range = pair(argument, given.unwrap_or(&[0.8, 4.0]))?;
            if range.0 <= 0.0 {
                return Err(wrong(format!(
                    "{argument} begins at {}, must be positive",
                    range.0
                )));
            }
            let varied = if is_ratio {
                Varied::Ratio
            } else {
                Varied::Frequency
            };
            Ok(Plane {
                params,
                drive: FamilyDrive::Ratio(1.0),
                dimensions: [Dimension::new(varied, range, false, &params), second],
            })
        }
        (&[first, second], Some(&[one])) if one > 0.0 && one.is_finite() => Ok(Plane {
            params,
            drive: if is_ratio {
                FamilyDrive::Ratio(one)
            } else {
                FamilyDrive::Hz(one)
            },
            dimensions: [first, second],
        }),
        ([_, _], _) => Err(wrong(
            "curve over two parameters of the rig needs one drive frequency: ratio or frequency_hz",
        )),
        _ => Err(wrong("curve must have one or two parameters")),
    }
}

/// Doublings, folds and grazes over two parameters.
fn curves<'py>(
    asked: Keywords<'py>,
    rig: &NamedRig,
    request: &CurvesRequest,
) -> PyResult<Bound<'py, PyAny>> {
    let py = asked.py();
    request.check().map_err(from_numerics)?;
    let answer = asked.run(request.simulations(), |watch| {
        let found = request.seeds(watch)?;
        request.curves(&rig.name, &found, &WithinStep(watch))
    })?;
    let whole = fields(py, &answer)?;
    whole.set_item("curves", table(py, &answer.curves)?)?;
    whole.set_item("codimension_two", table(py, &answer.codimension_two)?)?;
    whole.set_item("points", table(py, &answer.points)?)?;
    record(whole)
}
