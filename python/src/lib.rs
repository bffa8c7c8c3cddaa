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

use pyo3::prelude::*;

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<rig::PythonRig>()?;
    module.add_function(wrap_pyfunction!(rig::presets, module)?)?;
    module.add_function(wrap_pyfunction!(run::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(run::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(pick::pick, module)?)?;
    module.add_function(wrap_pyfunction!(map::map, module)?)?;
    module.add_function(wrap_pyfunction!(basins::basins, module)?)?;
    module.add_function(wrap_pyfunction!(bifurcation::bifurcation, module)?)?;
    module.add_function(wrap_pyfunction!(orbits::orbits, module)?)?;
    module.add_function(wrap_pyfunction!(section::poincare, module)?)?;
    module.add_function(wrap_pyfunction!(section::lyapunov, module)?)?;
    module.add_function(wrap_pyfunction!(contact::contact, module)?)?;
    module.add_function(wrap_pyfunction!(contact::drop, module)?)?;
    module.add_function(wrap_pyfunction!(contact::identify, module)?)?;
    module.add_function(wrap_pyfunction!(contact::compare, module)?)?;
    module.add_function(wrap_pyfunction!(modes::modes, module)?)?;
    module.add_function(wrap_pyfunction!(drill::drill, module)?)?;
    module.add_function(wrap_pyfunction!(emulate::emulate, module)?)?;
    module.add_function(wrap_pyfunction!(emulate::scenarios, module)?)?;
    Ok(())
}
