//! The keywords of a call, with the meaning and the defaults of the command line's options.

use numerics::engine::{Engine, Method, Plan, Precision, Setting, Start};
use numerics::progress::Progress;
use numerics::row::tidy;
use numerics::sweep::Direction;
use numerics::{Error, NamedRig};
use numpy::{AllowTypeChange, PyArrayLikeDyn};
use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{from_numerics, wrong};
use crate::rig::PythonRig;
use crate::work::How;

/// The longest tick at which the switch engine meets its accuracy, µs; the default.
const USUAL_TICK_US: f64 = 50.0;

const NO_FREQUENCY: &str = "there is no drive frequency; give ratio or frequency_hz";

/// The arguments of a Python function by their names, as `locals()` gives them there. Each is taken once, where it is
/// needed; [`Keywords::run`] refuses what nobody took.
pub struct Keywords<'py>(Bound<'py, PyDict>);

impl<'py> FromPyObject<'_, 'py> for Keywords<'py> {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(given.cast::<PyDict>()?.copy()?))
    }
}

impl<'py> Keywords<'py> {
    pub fn py(&self) -> Python<'py> {
        self.0.py()
    }

    /// Takes the argument `key`, or `None` if the function has no such argument. An error of its type names it.
    pub fn take<T: FromPyObjectOwned<'py>>(&self, key: &str) -> PyResult<T> {
        let py = self.py();
        let given = self.0.call_method1("pop", (key, py.None()))?;
        given.extract::<T>().map_err(|error| {
            let error: PyErr = error.into();
            if error.is_instance_of::<PyTypeError>(py) {
                return PyTypeError::new_err(format!("argument '{key}': {}", error.value(py)));
            }
            if error.is_instance_of::<PyOverflowError>(py) {
                return wrong(format!("{key} is {given}, which is out of range"));
            }
            error
        })
    }

    /// A number or anything that NumPy makes an array of.
    pub fn numbers(&self, key: &str) -> PyResult<Option<Vec<f64>>> {
        let given: Option<PyArrayLikeDyn<'py, f64, AllowTypeChange>> = self.take(key)?;
        Ok(given.map(|array| array.as_array().iter().copied().collect()))
    }

    /// Does `work`, which has `steps` steps, as `threads` and `progress` say.
    ///
    /// # Errors
    /// Those of [`How::run`]; if an argument is left that nobody took.
    pub fn run<T: Send>(
        self,
        steps: u64,
        work: impl FnOnce(&dyn Progress) -> Result<T, Error> + Send,
    ) -> PyResult<T> {
        let how = How {
            threads: self.take("threads")?,
            progress: self.take("progress")?,
        };
        if let Ok(left) = self.0.keys().get_item(0) {
            return Err(PyTypeError::new_err(format!("there is no argument {left}")));
        }
        how.run(self.py(), steps, work)
    }

    /// The rig as it is given.
    pub fn rig_as_given(&self) -> PyResult<NamedRig> {
        let rig: PyRef<'py, PythonRig> = self.take("rig")?;
        Ok(rig.named.clone())
    }

    /// The rig with its cart as asked for; without a word on the cart it recoils where its shaker is known.
    pub fn rig(&self) -> PyResult<NamedRig> {
        let rig = self.rig_as_given()?;
        match self.take::<Option<String>>("cart")?.as_deref() {
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

    /// [`Keywords::rig`] with its gap as asked for, too.
    pub fn rig_at_gap(&self) -> PyResult<NamedRig> {
        let mut rig = self.rig()?;
        if let Some(mm) = self.take("gap_mm")? {
            let there = rig.params.with_gap_mm(mm);
            rig.params = there.map_err(|e| from_numerics(e.into()))?;
        }
        Ok(rig)
    }

    /// One drive frequency, Hz, from exactly one of the two arguments.
    pub fn one_frequency(&self, rig: &NamedRig) -> PyResult<f64> {
        let given = self.frequency_if_given(rig)?;
        given.ok_or_else(|| wrong(NO_FREQUENCY))
    }

    /// One drive frequency, Hz, from one of the two arguments; none if neither is there.
    pub fn frequency_if_given(&self, rig: &NamedRig) -> PyResult<Option<f64>> {
        let given: (Option<f64>, _) = (self.take("ratio")?, self.take("frequency_hz")?);
        match given {
            (Some(ratio), None) => Ok(Some(ratio * rig.params.natural_frequency_hz())),
            (None, hz) => Ok(hz),
            (Some(_), Some(_)) => Err(two_frequencies()),
        }
    }

    /// Several drive frequencies, Hz, rising; none if neither argument is there.
    pub fn frequencies(&self, rig: &NamedRig) -> PyResult<Option<Vec<f64>>> {
        let given = (self.numbers("ratio")?, self.numbers("frequency_hz")?);
        let (argument, values, unit) = match given {
            (Some(_), Some(_)) => return Err(two_frequencies()),
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
    pub fn some_frequencies(&self, rig: &NamedRig) -> PyResult<Vec<f64>> {
        self.frequencies(rig)?.ok_or_else(|| wrong(NO_FREQUENCY))
    }

    /// How many cycles, and how many of the first are not recorded.
    pub fn plan(&self) -> PyResult<Plan> {
        Plan::new(self.take("cycles")?, self.take("transient")?).map_err(from_numerics)
    }

    /// Where a run begins: "rest", "fixed", or displacement in mm and velocity in m/s relative to the cart.
    pub fn start(&self) -> PyResult<Start> {
        let given: Bound<'py, PyAny> = self.take("start")?;
        match (
            given.extract::<String>().as_deref(),
            given.extract::<[f64; 2]>(),
        ) {
            (Ok("rest"), _) => Ok(Start::Rest),
            (Ok("fixed"), _) => Ok(Start::FixedFrameRest),
            (_, Ok([mm, velocity])) if mm.is_finite() && velocity.is_finite() => {
                Ok(Start::Moving(mm * 1e-3, velocity))
            }
            (_, Ok([mm, velocity])) => Err(wrong(format!(
                "start is ({mm}, {velocity}), must be finite numbers"
            ))),
            _ => Err(wrong(format!(
                "start is '{given}', must be 'rest', 'fixed' (at rest in the fixed frame), or (displacement_mm, velocity_m_per_s) relative to the cart"
            ))),
        }
    }

    /// What integrates: the event-located reference, or the microcontroller's switch model.
    pub fn engine(&self) -> PyResult<Engine> {
        self.engine_called(&self.take::<String>("engine")?)
    }

    /// The engine of this name, with the precision and the tick asked for.
    pub fn engine_called(&self, name: &str) -> PyResult<Engine> {
        let precision: Option<String> = self.take("precision")?;
        let tick_us: Option<f64> = self.take("tick_us")?;
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
                    precision: match precision.as_deref() {
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
}

/// The error that says what may stand for `argument`.
pub fn choice(argument: &str, given: &str, choices: &[&str]) -> PyErr {
    wrong(format!(
        "{argument} is '{given}', must be one of {}",
        choices.join(", ")
    ))
}

pub fn two_frequencies() -> PyErr {
    wrong("ratio and frequency_hz are two ways to say one thing; give one of them")
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

/// In which order the frequencies are visited.
pub fn direction(name: &str) -> PyResult<Direction> {
    let all = [Direction::Rest, Direction::Up, Direction::Down];
    let found = all.into_iter().find(|d| d.name() == name);
    found.ok_or_else(|| choice("direction", name, &["rest", "up", "down"]))
}
