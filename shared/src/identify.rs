//! identify (in work).
