//! tangent (in work).
