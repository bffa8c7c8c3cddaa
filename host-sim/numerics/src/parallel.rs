//! Work shared out over the threads. Each pipeline of rayon compiles to some four thousand lines of its own; here all work goes
//! through one.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::Error;

fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}

/// `f` of every item, in their order.
pub fn map<I: Sync, T: Send>(items: &[I], f: impl Fn(&I) -> T + Sync) -> Vec<T> {
    let places: Vec<Mutex<Option<T>>> = items.iter().map(|_| Mutex::default()).collect();
    each(items.len(), &|i| {
        let value = f(&items[i]);
        if let Ok(mut place) = places[i].lock() {
            *place = Some(value);
        }
    });
    let values = places.into_iter().map(|place| place.into_inner());
    values.filter_map(|value| value.ok().flatten()).collect()
}

/// [`map`] of an `f` that may fail: once it has, no further item is begun.
///
/// # Errors
/// Of the errors met, that of the first item.
pub fn try_map<I: Sync, T: Send>(
    items: &[I],
    f: impl Fn(&I) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    until_one_fails(items, f)
}

/// [`map`] of an `f` that may give nothing: `None` if it gives nothing for any item.
pub fn map_all<I: Sync, T: Send>(
    items: &[I],
    f: impl Fn(&I) -> Option<T> + Sync,
) -> Option<Vec<T>> {
    until_one_fails(items, |item| f(item).ok_or(())).ok()
}

fn until_one_fails<I: Sync, T: Send, E: Send>(
    items: &[I],
    f: impl Fn(&I) -> Result<T, E> + Sync,
) -> Result<Vec<T>, E> {
    let failed = AtomicBool::new(false);
    let results = map(items, |item| {
        if failed.load(Ordering::Relaxed) {
            return None;
        }
        let result = f(item);
        if result.is_err() {
            failed.store(true, Ordering::Relaxed);
        }
        Some(result)
    });
    results.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_in_the_order_of_the_items_on_any_number_of_threads() {
        let items: Vec<u64> = (0..1000).collect();
        let doubled: Vec<u64> = items.iter().map(|i| 2 * i).collect();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let found = pool.build().unwrap().install(|| map(&items, |i| 2 * i));
            assert_eq!(found, doubled, "{threads}");
        }
        assert_eq!(map(&items[..0], |i| *i), vec![]);
    }

    #[test]
    fn a_failure_ends_the_work_and_is_told() {
        let items: Vec<usize> = (0..1000).collect();
        let begun = Mutex::new(0);
        let one = |i: &usize| {
            *begun.lock().unwrap() += 1;
            if *i == 3 { Err(*i) } else { Ok(*i) }
        };
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1);
        let found = alone
            .build()
            .unwrap()
            .install(|| until_one_fails(&items, one));
        assert_eq!(found, Err(3));
        assert_eq!(*begun.lock().unwrap(), 4);
        let positive = |i: &usize| (*i > 0).then_some(*i);
        assert_eq!(map_all(&items, positive), None);
        assert_eq!(map_all(&items[1..], positive), Some(items[1..].to_vec()));
    }
}
