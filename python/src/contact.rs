//! The contact itself: its laws, drop tests, and contact parameters from a record.

use files::words::identify::IdentifyAnswer;
use numerics::compare::{ComparisonRequest, MeasuredFrame, compare as compare_with};
use numerics::contact_law::{all_laws, rows};
use numerics::drop_test::{DropTest, record as record_of};
use numerics::identify::{Misfit, SearchSettings, identify as fit_all, release_m};
use numerics::signal::Signal;
use pyo3::prelude::*;
use pyo3::types::PyList;
use shared::model::contact::{LAWS, LawKind};

use crate::arguments::{Keywords, choice, rising};
use crate::error::{from_numerics, wrong};
use crate::values::{fields, record, table};

#[pyfunction]
pub fn contact(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    const FASTEST: f64 = 100.0;
    let py = asked.py();
    let usual = || (0..15).map(|i| 0.02 + f64::from(i) * 0.02).collect();
    let speed_m_per_s = asked.numbers("speed_m_per_s")?.unwrap_or_else(usual);
    if speed_m_per_s.is_empty() {
        return Err(wrong("speed_m_per_s is empty, must have a value"));
    }
    if let Some(v) = speed_m_per_s
        .iter()
        .find(|v| !(**v > 0.0 && **v <= FASTEST))
    {
        return Err(wrong(format!(
            "speed_m_per_s has {v}, must be above 0 and up to {FASTEST}"
        )));
    }
    let params = asked.rig_as_given()?.params;
    let own = params.contact;
    let laws = match asked.take::<String>("law")?.as_str() {
        "all" => all_laws(own),
        "own" => vec![(own.kind().name(), own)],
        other => return Err(choice("law", other, &["all", "own"])),
    };
    let all = asked.run(1, |_| {
        let each = laws
            .iter()
            .map(|(name, law)| rows(name, *law, params.mass_kg, &speed_m_per_s));
        Ok(each.collect::<Result<Vec<_>, _>>()?.concat())
    })?;
    table(py, &all)
}

#[pyfunction]
pub fn drop(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig_at_gap()?;
    let release_mm: f64 = asked.take("release_mm")?;
    let test = DropTest {
        release_m: release_mm * 1e-3,
        impacts: asked.take("impacts")?,
        sampling_hz: asked.take("sampling_hz")?,
        noise_n: asked.take("noise_n")?,
        ringing_share: asked.take("ringing")?,
        bits: asked.take("bits")?,
        full_scale_n: asked.take("full_scale_n")?,
        force_gain_percent: asked.take("force_gain_percent")?,
        offset_n: asked.take("offset_n")?,
        drift_n_per_s: asked.take("drift_n_per_s")?,
        filter_hz: asked.take("filter_hz")?,
        displacement_gain_percent: asked.take("displacement_gain_percent")?,
        seed: asked.take("seed")?,
        ..DropTest::default()
    };
    let all = asked.run(1, |_| record_of(&rig.params, &test))?;
    table(py, &all)
}

#[pyfunction]
pub fn identify(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let laws = LAWS.map(|(_, law)| law.kind());
    let families = chosen(&asked, "law", &laws, LawKind::name)?;
    let both = [Misfit::Force, Misfit::Peaks];
    let misfits = chosen(&asked, "misfit", &both, Misfit::name)?;
    let signal = signal(&asked)?;
    let rig = asked.rig_at_gap()?;
    let settings = SearchSettings {
        release_m: release_m(asked.take("release_mm")?, &signal).map_err(from_numerics)?,
        seek_release: asked.take("seek_release")?,
        seek_exponent: asked.take("seek_exponent")?,
        impacts: asked.take("impacts")?,
        gain_percent: asked.take("gain_percent")?,
        release_height_percent: asked.take("release_height_percent")?,
        clock_percent: asked.take("clock_percent")?,
    };
    settings.check().map_err(from_numerics)?;
    let searches = families.len() * misfits.len();
    let (measured, fits) = asked.run(searches as u64, |watch| {
        fit_all(&signal, &rig.params, &families, &misfits, &settings, watch)
    })?;
    let answer = IdentifyAnswer::new(&rig, &measured, &settings, &fits);
    let found = fields(py, &answer)?;
    found.del_item("file")?;
    let list = PyList::empty(py);
    for worded in &answer.fits {
        let one = fields(py, worded)?;
        one.set_item("impacts", table(py, &worded.fit.impacts)?)?;
        list.append(one)?;
    }
    found.set_item("fits", list)?;
    record(found)
}

#[pyfunction]
pub fn compare(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let signal = signal(&asked)?;
    let rig = asked.rig_at_gap()?;
    let question = ComparisonRequest {
        params: rig.params,
        engine: asked.engine()?,
        frequency_hz: asked.frequency_if_given(&rig)?,
        start: asked.start()?,
        plan: asked.plan()?,
        frame: match asked.take::<String>("frame")?.as_str() {
            "fixed" => MeasuredFrame::Fixed,
            "relative" => MeasuredFrame::Relative,
            other => return Err(choice("frame", other, &["fixed", "relative"])),
        },
    };
    let found = asked.run(1, |_| compare_with(&signal, &question))?;
    let answer = fields(py, &found.errors)?;
    answer.set_item("rows", table(py, &found.rows)?)?;
    record(answer)
}

/// What the names given, one or several, stand for.
fn chosen<T: Copy>(
    asked: &Keywords<'_>,
    argument: &str,
    all: &[T],
    name: fn(T) -> &'static str,
) -> PyResult<Vec<T>> {
    let given: Bound<'_, PyAny> = asked.take(argument)?;
    let names = match given.extract::<String>() {
        Ok(one) => vec![one],
        Err(_) => given.extract()?,
    };
    let one = |given: &String| {
        let found = all.iter().copied().find(|t| name(*t) == given);
        found.ok_or_else(|| {
            let known: Vec<_> = all.iter().map(|t| name(*t)).collect();
            choice(argument, given, &known)
        })
    };
    names.iter().map(one).collect()
}

/// The record: columns of one length, times rising, every value a number.
fn signal(asked: &Keywords<'_>) -> PyResult<Signal> {
    let time_s = asked.numbers("time_s")?.unwrap_or_default();
    let force_n = asked.numbers("force_n")?;
    let displacement_mm = asked.numbers("displacement_mm")?;
    let cart_mm = asked.numbers("cart_mm")?;
    let count = time_s.len();
    for (argument, column) in [
        ("force_n", &force_n),
        ("displacement_mm", &displacement_mm),
        ("cart_mm", &cart_mm),
    ] {
        let Some(column) = column else { continue };
        if column.len() != count {
            return Err(wrong(format!(
                "{argument} has {} values, must have {count}, as time_s",
                column.len()
            )));
        }
        if let Some(bad) = column.iter().find(|v| !v.is_finite()) {
            return Err(wrong(format!(
                "{argument} has {bad}, must be finite numbers"
            )));
        }
    }
    if count < numerics::signal::FEWEST_SAMPLES {
        return Err(wrong(format!(
            "time_s has {count} values, must have at least {}",
            numerics::signal::FEWEST_SAMPLES
        )));
    }
    rising("time_s", &time_s)?;
    Ok(Signal {
        name: "the record".to_owned(),
        time_s,
        force_n,
        displacement_mm,
        cart_mm,
    })
}
