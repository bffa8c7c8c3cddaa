//! The scenarios that come with the program.

/// Name and text of each.
pub const BUILTIN: [(&str, &str); 1] = [("field", include_str!("../../../scenarios/field.toml"))];
