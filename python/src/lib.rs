//! The Python package `vibroimpact`: the analyses of `numerics`, called with the arguments of the Python functions, with
//! records and tables as answers. What is documented for people, the classes of the answers, and every argument with its
//! default are in the Python files beside this package (`vibroimpact/`).
//!
//! Every function computes with the interpreter released and looks for Ctrl-C meanwhile (`work.rs`).

mod arguments;
mod basins;
mod bifurcation;
mod contact;
mod drill;
mod emulate;
mod error;
mod map;
mod modes;
mod orbits;
mod pick;
mod rig;
mod run;
mod section;
mod values;
mod work;

use pyo3::pymodule;

#[pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::{
        basins::basins,
        bifurcation::bifurcation,
        contact::{compare, contact, drop, identify},
        drill::drill,
        emulate::{emulate, scenarios, trials},
        map::map,
        modes::modes,
        orbits::orbits,
        pick::pick,
        rig::{PythonRig, presets},
        run::{simulate, sweep},
        section::{lyapunov, poincare},
    };

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
