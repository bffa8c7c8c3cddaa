//! The operating point.

use files::rigfile::WIDTHS;
use files::words::pick::WordedPick;
use numerics::PickLimits;
use numerics::pick::{Springs, pick_on, steps};
use numerics::uncertainty::Stated;
use pyo3::prelude::*;

use crate::arguments::Keywords;
use crate::error::{from_numerics, from_user, wrong};
use crate::values::{fields, put, record};

#[pyfunction]
pub fn pick(asked: Keywords<'_>) -> PyResult<Bound<'_, PyAny>> {
    let py = asked.py();
    let rig = asked.rig_at_gap()?;
    let nominal: bool = asked.take("nominal")?;
    let mut given = Stated::default();
    for width in &WIDTHS {
        let Some(value) = asked.take(width.key)? else {
            continue;
        };
        if nominal {
            return Err(wrong(format!(
                "nominal takes the parameters as exact; leave {} out",
                width.key
            )));
        }
        let set = width.set(&mut given, width.key, value);
        set.map_err(from_user)?;
    }
    let stated = given.or(&rig.stated);
    let (samples, seed) = (asked.take("samples")?, asked.take("seed")?);
    let whole = stated.complete(samples, seed, rig.params.cart.recoils());
    whole.check().map_err(from_numerics)?;
    let uncertainty = (!nominal).then_some(whole);
    let limit = |name: &str| match asked.take(name)? {
        Some(x) if !(x > 0.0 && x < f64::INFINITY) => {
            Err(wrong(format!("{name} is {x}, must be a positive number")))
        }
        given => Ok(given),
    };
    let limits = PickLimits {
        max_force_n: limit("max_force_n")?,
        max_frequency_hz: limit("max_frequency_hz")?,
        max_shaker_force_n: limit("max_shaker_force_n")?,
        rig_shaker_force_n: None,
    };
    let found = asked.run(steps(uncertainty), |watch| {
        pick_on(&rig, Springs::default(), uncertainty, limits, watch)
    })?;
    let answer = fields(py, &WordedPick::from(&found.answer))?;
    let curve = found.curve.iter();
    put(&answer, "curve_frequency_hz", curve.clone().map(|at| at.0))?;
    put(&answer, "curve_force_ratio", curve.map(|at| at.1))?;
    record(answer)
}
