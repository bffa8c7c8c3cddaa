//! Arguments that several functions take, with the meaning and the defaults of the command line's options.

use numerics::NamedRig;
use numerics::engine::{Engine, Method, Plan, Precision, Setting, Start};
use numerics::row::tidy;
use numerics::sweep::Direction;
use pyo3::prelude::*;

use crate::error::{from_user, wrong};
use crate::rig::PythonRig;

/// The longest tick at which the switch engine meets its accuracy, µs; the default.
const USUAL_TICK_US: f64 = 50.0;

/// The rig with its gap and its cart as asked for; without a word on the cart it recoils where its shaker is known.
pub fn at(rig: &PythonRig, gap_mm: Option<f64>, cart: Option<&str>) -> PyResult<NamedRig> {
    let rig = with_gap(rig, gap_mm)?;
    match cart {
        None => Ok(rig.recoiling().unwrap_or(rig)),
        Some("prescribed") => Ok(rig.prescribed()),
        Some("recoil") => rig.recoiling().ok_or_else(|| {
            wrong(format!(
                "cart is 'recoil', but the shaker of rig {} is not known; give shaker_loop_hz",
                rig.name
            ))
        }),
        Some(other) => Err(choice("cart", other, &["prescribed", "recoil"])),
    }
}

/// The rig with its gap as asked for.
pub fn with_gap(rig: &PythonRig, gap_mm: Option<f64>) -> PyResult<NamedRig> {
    let mut rig = rig.named.clone();
    if let Some(mm) = gap_mm {
        rig.params = rig
            .params
            .with_gap_mm(mm)
            .map_err(|e| from_user(numerics::Error::from(e).into()))?;
    }
    Ok(rig)
}

/// The error that says what may stand for `argument`.
pub fn choice(argument: &str, given: &str, choices: &[&str]) -> PyErr {
    wrong(format!(
        "{argument} is '{given}', must be one of {}",
        choices.join(", ")
    ))
}

/// One drive frequency, Hz, from exactly one of the two arguments.
pub fn one_frequency(
    rig: &NamedRig,
    ratio: Option<f64>,
    frequency_hz: Option<f64>,
) -> PyResult<f64> {
    match (ratio, frequency_hz) {
        (Some(ratio), None) => Ok(ratio * rig.params.natural_frequency_hz()),
        (None, Some(hz)) => Ok(hz),
        (None, None) => Err(wrong(
            "there is no drive frequency; give ratio or frequency_hz",
        )),
        (Some(_), Some(_)) => Err(wrong(
            "ratio and frequency_hz are two ways to say one thing; give one of them",
        )),
    }
}

/// Several drive frequencies, Hz, rising; none if neither argument is there.
pub fn frequencies(
    rig: &NamedRig,
    ratio: Option<Vec<f64>>,
    frequency_hz: Option<Vec<f64>>,
) -> PyResult<Option<Vec<f64>>> {
    let (argument, values, unit) = match (ratio, frequency_hz) {
        (Some(_), Some(_)) => {
            return Err(wrong(
                "ratio and frequency_hz are two ways to say one thing; give one of them",
            ));
        }
        (Some(ratios), None) => ("ratio", ratios, rig.params.natural_frequency_hz()),
        (None, Some(hz)) => ("frequency_hz", hz, 1.0),
        (None, None) => return Ok(None),
    };
    rising(argument, &values)?;
    if let Some(bad) = values.iter().find(|v| **v <= 0.0) {
        return Err(wrong(format!("{argument} has {bad}, must be positive")));
    }
    Ok(Some(
        values.into_iter().map(|v| tidy(tidy(v) * unit)).collect(),
    ))
}

/// Several drive frequencies, Hz, rising; an error if neither argument is there.
pub fn some_frequencies(
    rig: &NamedRig,
    ratio: Option<Vec<f64>>,
    frequency_hz: Option<Vec<f64>>,
) -> PyResult<Vec<f64>> {
    frequencies(rig, ratio, frequency_hz)?
        .ok_or_else(|| wrong("there is no drive frequency; give ratio or frequency_hz"))
}

/// Refuses values that are no numbers, none at all, or not rising.
pub fn rising(argument: &str, values: &[f64]) -> PyResult<()> {
    if values.is_empty() {
        return Err(wrong(format!("{argument} is empty, must have a value")));
    }
    if let Some(bad) = values.iter().find(|v| !v.is_finite()) {
        return Err(wrong(format!(
            "{argument} has {bad}, must be finite numbers"
        )));
    }
    match values.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(wrong(format!(
            "{argument}: {} does not come after {}; give the values in rising order, each once",
            pair[1], pair[0]
        ))),
        None => Ok(()),
    }
}

/// How many cycles, and how many of the first are not recorded.
pub fn plan(cycles: u32, transient: u32) -> PyResult<Plan> {
    if transient >= cycles {
        return Err(wrong(format!(
            "transient is {transient}, leaves nothing of {cycles} cycles to record; it must be smaller"
        )));
    }
    Ok(Plan { cycles, transient })
}

/// Where a run begins: "rest", "fixed", or displacement in mm and velocity in m/s relative to the cart.
#[derive(FromPyObject)]
pub enum StartArgument {
    /// "rest" or "fixed".
    Named(String),
    /// Displacement, mm, and velocity, m/s.
    Moving(f64, f64),
}

impl StartArgument {
    /// As the engines take it.
    pub fn start(self) -> PyResult<Start> {
        match self {
            Self::Named(name) => match name.as_str() {
                "rest" => Ok(Start::Rest),
                "fixed" => Ok(Start::FixedFrameRest),
                other => Err(wrong(format!(
                    "start is '{other}', must be 'rest', 'fixed' (at rest in the fixed frame), or (displacement_mm, velocity_m_per_s) relative to the cart"
                ))),
            },
            Self::Moving(mm, velocity) if mm.is_finite() && velocity.is_finite() => {
                Ok(Start::Moving(mm * 1e-3, velocity))
            }
            Self::Moving(mm, velocity) => Err(wrong(format!(
                "start is ({mm}, {velocity}), must be finite numbers"
            ))),
        }
    }
}

/// What integrates: the event-located reference, or the microcontroller's switch model.
pub fn engine(name: &str, precision: Option<&str>, tick_us: Option<f64>) -> PyResult<Engine> {
    match name {
        "event" => {
            let given = [
                ("precision", precision.is_some()),
                ("tick_us", tick_us.is_some()),
            ];
            match given.iter().find(|(_, given)| *given) {
                Some((argument, _)) => Err(wrong(format!(
                    "{argument} belongs to the switch engine; add engine=\"switch\" or leave it out"
                ))),
                None => Ok(Engine::Event),
            }
        }
        "switch" => {
            let tick_us = tick_us.unwrap_or(USUAL_TICK_US);
            if !(0.05..=1000.0).contains(&tick_us) {
                return Err(wrong(format!(
                    "tick_us is {tick_us}, must be from 0.05 to 1000 microseconds"
                )));
            }
            Ok(Engine::Switch(Setting {
                method: Method::Corrected,
                precision: match precision {
                    None | Some("f32") => Precision::F32,
                    Some("f64") => Precision::F64,
                    Some(other) => return Err(choice("precision", other, &["f32", "f64"])),
                },
                tick_s: tick_us * 1e-6,
            }))
        }
        other => Err(choice("engine", other, &["event", "switch"])),
    }
}

/// In which order the frequencies are visited.
pub fn direction(name: &str) -> PyResult<Direction> {
    let all = [Direction::Rest, Direction::Up, Direction::Down];
    let found = all.into_iter().find(|d| d.name() == name);
    found.ok_or_else(|| choice("direction", name, &["rest", "up", "down"]))
}
