//! Arguments and answers as JSON.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The argument as the type a function wants.
///
/// # Errors
/// It is something else: a fault of the page's scripts, or a broken address.
pub fn read<T: DeserializeOwned>(argument: &[u8]) -> Result<T, String> {
    serde_json::from_slice(argument).map_err(|e| format!("the page asked wrongly: {e}"))
}

/// An answer. Every f64 is written with the digits that give the same f64 back.
///
/// # Errors
/// It cannot be written: a fault of the program.
pub fn write<T: Serialize>(answer: &T) -> Result<Vec<u8>, String> {
    serde_json::to_vec(answer).map_err(|e| format!("the answer cannot be written: {e}"))
}
