//! A rig, from a preset, a file or a text, with parameters set by keyword.

use std::hash::{DefaultHasher, Hash, Hasher};

use files::rigfile;
use numerics::NamedRig;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use shared::model::params::PRESETS;

use crate::error::{from_user, wrong};
use crate::values::object;

/// A rig and where it came from.
#[pyclass(name = "Rig", module = "vibroimpact", frozen, skip_from_py_object)]
pub struct PythonRig {
    /// A preset's name or a file's path.
    source: String,
    /// The file's text, if it came from one: what is sent to another process.
    text: Option<String>,
    /// Set over it, `key=value`.
    settings: Vec<String>,
    /// The rig itself, with its name.
    pub named: NamedRig,
}

impl PythonRig {
    fn load(source: String, text: Option<String>, settings: Vec<String>) -> PyResult<Self> {
        let is_preset = PRESETS.iter().any(|(name, _)| *name == source);
        let text = match text {
            None if !is_preset => files::read_text(source.as_ref()).ok(),
            given => given,
        };
        let named = match &text {
            Some(text) => rigfile::load_text(&source, text, &settings),
            None => rigfile::load(&source, &settings),
        };
        Ok(Self {
            named: named.map_err(from_user)?,
            source,
            text,
            settings,
        })
    }
}

/// `key=value` of each keyword.
fn settings(keywords: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<String>> {
    let Some(keywords) = keywords else {
        return Ok(Vec::new());
    };
    let one = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract()?;
        if let Ok(text) = value.extract::<String>() {
            return Ok(format!("{key}={text}"));
        }
        let number: f64 = value
            .extract()
            .map_err(|_| wrong(format!("{key} is {value}, must be a number or a word")))?;
        Ok(format!("{key}={number:?}"))
    };
    keywords.iter().map(one).collect()
}

#[pymethods]
impl PythonRig {
    #[new]
    #[pyo3(signature = (source = "wires".to_owned(), /, **parameters))]
    fn new(source: String, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        Self::load(source, None, settings(parameters)?)
    }

    #[staticmethod]
    #[pyo3(signature = (text, name = "rig".to_owned(), settings = Vec::new()))]
    fn from_toml(text: String, name: String, settings: Vec<String>) -> PyResult<Self> {
        Self::load(name, Some(text), settings)
    }

    #[pyo3(signature = (**parameters))]
    fn replace(&self, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let settings = [self.settings.clone(), settings(parameters)?].concat();
        Self::load(self.source.clone(), self.text.clone(), settings)
    }

    #[getter]
    fn name(&self) -> &str {
        &self.named.name
    }

    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let whole = self.named.recoiling();
        object(
            py,
            &rigfile::parameters_of(&whole.as_ref().unwrap_or(&self.named).params),
        )
    }

    #[getter]
    fn natural_frequency_hz(&self) -> f64 {
        self.named.params.natural_frequency_hz()
    }

    #[getter]
    fn weight_n(&self) -> f64 {
        self.named.params.weight_n()
    }

    fn to_toml(&self) -> String {
        rigfile::to_toml(&self.named)
    }

    fn __getattr__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let all = self.parameters(py)?.cast_into::<PyDict>()?;
        all.get_item(key)?.ok_or_else(|| {
            pyo3::exceptions::PyAttributeError::new_err(format!(
                "rig {} has no parameter '{key}'; Rig.parameters has them all",
                self.named.name
            ))
        })
    }

    fn __repr__(&self) -> String {
        let mut shown = match &self.text {
            Some(_) if !self.source.contains(['/', '.']) => {
                format!("Rig.from_toml(..., {:?}", self.source)
            }
            _ => format!("Rig({:?}", self.source),
        };
        for setting in &self.settings {
            let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
            shown += &match value.parse::<f64>() {
                Ok(_) => format!(", {key}={value}"),
                Err(_) => format!(", {key}={value:?}"),
            };
        }
        shown + ")"
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.named == other.named
    }

    /// Of its name: equal rigs have equal names.
    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.named.name.hash(&mut hasher);
        hasher.finish()
    }

    fn __dir__<'py>(slf: &Bound<'py, Self>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let py = slf.py();
        let own = py.get_type::<PyAny>().call_method1("__dir__", (slf,))?;
        let parameters = slf.borrow().parameters(py)?;
        let names = own.try_iter()?.chain(parameters.try_iter()?);
        names.collect()
    }

    /// Preset and settings, or the file's text and settings: a rig travels to other processes without its file.
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let load = py.get_type::<Self>().getattr("_load")?;
        let parts = (
            self.source.clone(),
            self.text.clone(),
            self.settings.clone(),
        );
        Ok((load, parts.into_pyobject(py)?))
    }

    #[staticmethod]
    fn _load(source: String, text: Option<String>, settings: Vec<String>) -> PyResult<Self> {
        Self::load(source, text, settings)
    }
}

/// The names of the built-in rigs.
#[pyfunction]
pub fn presets() -> Vec<&'static str> {
    PRESETS.iter().map(|(name, _)| *name).collect()
}
