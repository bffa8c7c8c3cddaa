//! The contact itself: its laws, drop tests, and contact parameters from a record.

use files::words::identify::WordedFit;
use numerics::contact_law::{all_laws, rows};
use numerics::drop_test::{DropTest, record as record_of};
use numerics::identify::{IdentifiedFit, Misfit, SearchSettings, fit, free_cart_percent, measure};
use numerics::row::tidy;
use numerics::signal::Signal;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use shared::model::contact::{LAWS, LawKind};

use crate::arguments;
use crate::error::wrong;
use crate::rig::PythonRig;
use crate::values::{columns, object, record};
use crate::work::How;

#[pyfunction]
#[pyo3(signature = (rig, *, speed_m_per_s, law))]
pub fn contact<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    speed_m_per_s: Vec<f64>,
    law: &str,
) -> PyResult<Bound<'py, PyDict>> {
    const FASTEST: f64 = 100.0;
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
    let params = rig.named.params;
    let own = params.contact;
    let laws = match law {
        "all" => all_laws(own),
        "own" => vec![(own.kind().name(), own)],
        other => return Err(arguments::choice("law", other, &["all", "own"])),
    };
    let how = How {
        threads: None,
        progress: None,
    };
    let all = how.run(py, 1, |_| {
        let each = laws
            .iter()
            .map(|(name, law)| rows(name, *law, params.mass_kg, &speed_m_per_s));
        Ok(each.collect::<Result<Vec<_>, _>>()?.concat())
    })?;
    columns(py, &all)
}

#[pyfunction]
#[pyo3(signature = (rig, *, gap_mm, release_mm, impacts, sampling_hz, noise_n, ringing, bits, full_scale_n, force_gain_percent, offset_n, drift_n_per_s, filter_hz, displacement_gain_percent, seed))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn drop<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    gap_mm: Option<f64>,
    release_mm: f64,
    impacts: usize,
    sampling_hz: f64,
    noise_n: f64,
    ringing: f64,
    bits: u32,
    full_scale_n: f64,
    force_gain_percent: f64,
    offset_n: f64,
    drift_n_per_s: f64,
    filter_hz: f64,
    displacement_gain_percent: f64,
    seed: u64,
) -> PyResult<Bound<'py, PyDict>> {
    for (argument, value, low, high) in [
        ("release_mm", release_mm, -1000.0, 1000.0),
        ("impacts", impacts as f64, 1.0, 100.0),
        ("sampling_hz", sampling_hz, 100.0, 10e6),
        ("noise_n", noise_n, 0.0, 1e6),
        ("ringing", ringing, 0.0, 10.0),
        ("bits", f64::from(bits), 0.0, 24.0),
        ("full_scale_n", full_scale_n, 1e-6, 1e9),
        ("force_gain_percent", force_gain_percent, -90.0, 900.0),
        ("offset_n", offset_n, -1e6, 1e6),
        ("drift_n_per_s", drift_n_per_s, -1e6, 1e6),
        ("filter_hz", filter_hz, 0.0, 1e6),
        (
            "displacement_gain_percent",
            displacement_gain_percent,
            -90.0,
            900.0,
        ),
    ] {
        if !(value >= low && value <= high) {
            return Err(wrong(format!(
                "{argument} is {value}, must be from {low} to {high}"
            )));
        }
    }
    let rig = arguments::at(rig, gap_mm, None)?;
    let test = DropTest {
        release_m: release_mm * 1e-3,
        impacts,
        sampling_hz,
        noise_n,
        ringing_share: ringing,
        bits,
        full_scale_n,
        force_gain_percent,
        offset_n,
        drift_n_per_s,
        filter_hz,
        displacement_gain_percent,
        seed,
        ..DropTest::default()
    };
    let how = How {
        threads: None,
        progress: None,
    };
    let all = how.run(py, 1, |_| record_of(&rig.params, &test))?;
    columns(py, &all)
}

#[pyfunction]
#[pyo3(signature = (rig, *, time_s, force_n, displacement_mm, gap_mm, laws, misfits, release_mm, seek_release, seek_exponent, impacts, gain_percent, release_height_percent, clock_percent, threads, progress))]
#[allow(
    clippy::too_many_arguments,
    reason = "each is a keyword of the Python function"
)]
pub fn identify<'py>(
    py: Python<'py>,
    rig: &PythonRig,
    time_s: Vec<f64>,
    force_n: Vec<f64>,
    displacement_mm: Option<Vec<f64>>,
    gap_mm: Option<f64>,
    laws: Vec<String>,
    misfits: Vec<String>,
    release_mm: Option<f64>,
    seek_release: bool,
    seek_exponent: bool,
    impacts: usize,
    gain_percent: f64,
    release_height_percent: f64,
    clock_percent: f64,
    threads: Option<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let families = chosen(
        "law",
        &laws,
        &LAWS.map(|(_, law)| law.kind()),
        LawKind::name,
    )?;
    let misfits = chosen(
        "misfit",
        &misfits,
        &[Misfit::Force, Misfit::Peaks],
        Misfit::name,
    )?;
    if !(1..=50).contains(&impacts) {
        return Err(wrong(format!("impacts is {impacts}, must be from 1 to 50")));
    }
    for (argument, value, high) in [
        ("gain_percent", gain_percent, 100.0),
        ("release_height_percent", release_height_percent, 50.0),
        ("clock_percent", clock_percent, 50.0),
    ] {
        if !(0.0..=high).contains(&value) {
            return Err(wrong(format!(
                "{argument} is {value}, must be from 0 to {high}"
            )));
        }
    }
    let signal = signal(time_s, force_n, displacement_mm)?;
    let rig = arguments::at(rig, gap_mm, None)?;
    let settings = SearchSettings {
        release_m: release(release_mm, &signal)? * 1e-3,
        seek_release,
        seek_exponent,
        impacts,
        gain_percent,
        release_height_percent,
        clock_percent,
    };
    let how = How { threads, progress };
    let searches = families.len() * misfits.len();
    let (measured, fits) = how.run(py, searches as u64, |watch| {
        let measured = measure(&signal, &settings)?;
        let mut fits = Vec::with_capacity(searches);
        for family in &families {
            for misfit in &misfits {
                fits.push(fit(&measured, &rig.params, *family, *misfit, &settings)?);
                numerics::progress::step(watch, 1)?;
            }
        }
        Ok((measured, fits))
    })?;
    let found = PyDict::new(py);
    found.set_item("rig", &rig.name)?;
    found.set_item("gap_mm", tidy(rig.params.gap_m * 1e3))?;
    found.set_item("release_mm", tidy(settings.release_m * 1e3))?;
    found.set_item("impacts", measured.impacts.len())?;
    found.set_item("sampling_hz", tidy(1.0 / measured.sample_s))?;
    found.set_item("noise_n", measured.noise_n)?;
    found.set_item("offset_n", measured.offset_n)?;
    found.set_item("drift_n_per_s", measured.drift_n_per_s)?;
    found.set_item("gain_percent", gain_percent)?;
    found.set_item("release_height_percent", release_height_percent)?;
    found.set_item("clock_percent", clock_percent)?;
    found.set_item("free_cart_percent", free_cart_percent(&rig.params))?;
    let shaped = fits.iter().filter(|f| f.misfit == Misfit::Force);
    let best: Option<&IdentifiedFit> = shaped.min_by(|a, b| a.rms_n.total_cmp(&b.rms_n));
    let ring = best.or(fits.first()).and_then(|fit| fit.ring);
    found.set_item("ring", object(py, &ring)?)?;
    let list = PyList::empty(py);
    for fit in &fits {
        let one = record(py, &WordedFit::from(fit))?;
        one.set_item("impacts", columns(py, &fit.impacts)?)?;
        list.append(one)?;
    }
    found.set_item("fits", list)?;
    Ok(found)
}

fn chosen<T: Copy>(
    argument: &str,
    names: &[String],
    all: &[T],
    name: fn(T) -> &'static str,
) -> PyResult<Vec<T>> {
    let one = |given: &String| {
        let found = all.iter().copied().find(|t| name(*t) == given);
        found.ok_or_else(|| {
            let known: Vec<_> = all.iter().map(|t| name(*t)).collect();
            arguments::choice(argument, given, &known)
        })
    };
    names.iter().map(one).collect()
}

/// The record: columns of one length, times rising, every value a number.
fn signal(
    time_s: Vec<f64>,
    force_n: Vec<f64>,
    displacement_mm: Option<Vec<f64>>,
) -> PyResult<Signal> {
    let count = time_s.len();
    for (argument, column) in [
        ("force_n", Some(&force_n)),
        ("displacement_mm", displacement_mm.as_ref()),
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
    arguments::rising("time_s", &time_s)?;
    Ok(Signal {
        name: "the record".to_owned(),
        time_s,
        force_n: Some(force_n),
        displacement_mm,
        cart_mm: None,
    })
}

/// Where the hammer was released, mm: as given, else the record's first displacement, else 3 mm from rest.
fn release(given: Option<f64>, signal: &Signal) -> PyResult<f64> {
    let shown = signal.displacement_mm.as_ref().map(|d| {
        let first = &d[..d.len().min(5)];
        let mean = first.iter().sum::<f64>() / first.len() as f64;
        (mean * 1e6).round() / 1e6
    });
    let mm = given.or(shown).unwrap_or(-3.0);
    if mm.is_finite() {
        return Ok(mm);
    }
    Err(wrong(format!("release_mm is {mm}, must be a number")))
}
