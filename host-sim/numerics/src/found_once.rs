//! What several searches ask for, sought once.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// What was found at places that several searches ask for, or that there is nothing. What is found must not hang on who asks
/// first.
#[derive(Clone, Debug)]
pub struct FoundOnce<T>(Arc<Mutex<HashMap<u64, Option<T>>>>);

impl<T> Default for FoundOnce<T> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<T: Clone> FoundOnce<T> {
    /// What there is at `x`: as it was found before, or by `find`.
    pub fn at(&self, x: f64, find: impl FnOnce() -> Option<T>) -> Option<T> {
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = known().get(&x.to_bits()) {
            return known.clone();
        }
        let found = find();
        known().insert(x.to_bits(), found.clone());
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_found_is_not_sought_again() {
        let (found, tries) = (FoundOnce::default(), std::cell::Cell::new(0));
        let at = |x: f64| {
            found.at(x, || {
                tries.set(tries.get() + 1);
                (x > 0.0).then_some(x)
            })
        };
        for _ in 0..3 {
            assert_eq!((at(1.0), at(-1.0)), (Some(1.0), None));
        }
        assert_eq!(tries.get(), 2);
    }
}
