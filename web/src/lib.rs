//! What the page computes, compiled to WebAssembly: arguments checked, the analyses of `numerics` called, values out.
//!
//! The page's scripts know one door (`door.rs`): the name of a function and its argument as bytes, the answer as bytes.
//! Most arguments and answers are JSON; cells of a map and what comes by the thousand are packed ([`bytes`]). A binding
//! generator is not used: it would be one more program to get and to build, for a dozen functions.
//!
//! | folder | holds |
//! |---|---|
//! | `explore/` | the rig, its map, an orbit, the operating point |
//! | `wire/` | the serial protocol: bytes of a board in, messages out |
//! | `scope/`, `record.rs` | the last seconds of a board's ticks; a log of all of them |
//! | `emulated/` | the emulated rig and its board |

pub mod bytes;
#[cfg(target_family = "wasm")]
mod door;
pub mod emulated;
pub mod explore;
mod json;
mod record;
mod scope;
pub mod wire;

/// A function of the page: its argument and its answer, or one line that says what is wrong.
pub type Function = fn(&[u8]) -> Result<Vec<u8>, String>;

/// Every function by its name.
const FUNCTIONS: &[&[(&str, Function)]] =
    &[explore::FUNCTIONS, emulated::FUNCTIONS, wire::FUNCTIONS];

/// Calls the function `name`.
///
/// # Errors
/// There is no such function, or it says what is wrong with its argument: one line.
pub fn call(name: &str, argument: &[u8]) -> Result<Vec<u8>, String> {
    let mut all = FUNCTIONS.iter().copied().flatten();
    let (_, function) = all
        .find(|(known, _)| *known == name)
        .ok_or_else(|| format!("the module has no function '{name}'"))?;
    function(argument)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_an_unknown_one_is_an_error() {
        let mut names: Vec<_> = FUNCTIONS.iter().copied().flatten().map(|f| f.0).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        assert!(
            call("explore.nothing", b"")
                .unwrap_err()
                .contains("nothing")
        );
    }
}
