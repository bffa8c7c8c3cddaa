//! The fuzzer's bodies over its corpus and a fixed number of mutations of it: what a fuzzer found once stays
//! found, and the bodies stay true, without a fuzzer. `fuzz/README.md` says how to run the fuzzer itself.

use std::fs;
use std::path::PathBuf;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// With `LONG_CHECKS`; else a quarter of them.
const MUTATIONS: usize = 100_000;

fn corpus(target: &str) -> Vec<Vec<u8>> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    let folder = root.join(target);
    let listed = fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<_> = listed.map(|entry| entry.unwrap().path()).collect();
    // The order of a folder is the system's; mutations must be the same everywhere.
    paths.sort();
    assert!(!paths.is_empty());
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

/// Flips, overwrites, cuts, repeats and joins, a few at a time.
fn mutated(corpus: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let pick = |random: &mut ChaCha8Rng| corpus[random.random_range(0..corpus.len())].clone();
    let mut bytes = pick(random);
    for _ in 0..random.random_range(1..=4) {
        let at = random.random_range(0..=bytes.len());
        match random.random_range(0..6) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
            1 if at < bytes.len() => bytes[at] = random.random(),
            2 => bytes.truncate(at),
            3 => bytes.insert(at, random.random()),
            4 => bytes.extend_from_within(at..),
            _ => {
                bytes.truncate(at);
                let other = pick(random);
                let from = random.random_range(0..=other.len());
                bytes.extend(&other[from..]);
            }
        }
        bytes.truncate(2000);
    }
    bytes
}

fn run(target: &str, body: impl Fn(&[u8])) {
    run_times(MUTATIONS, target, body);
}

fn run_times(mutations: usize, target: &str, body: impl Fn(&[u8])) {
    let corpus = corpus(target);
    corpus.iter().for_each(|bytes| body(bytes));
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let long = std::env::var_os("LONG_CHECKS").is_some();
    for _ in 0..if long { mutations } else { mutations / 4 } {
        body(&mutated(&corpus, &mut random));
    }
}

#[test]
fn any_bytes_on_the_wire_do_no_harm() {
    run("link", tests::fuzz::link);
}

#[test]
fn any_bytes_in_flash_do_no_harm() {
    run("settings", tests::fuzz::settings);
}

#[test]
fn any_rig_file_does_no_harm() {
    run_times(MUTATIONS / 5, "rig", tests::fuzz::rig);
}

#[test]
fn any_scenario_does_no_harm() {
    run_times(MUTATIONS / 10, "scenario", tests::fuzz::scenario);
}

#[test]
fn any_table_does_no_harm() {
    run_times(MUTATIONS / 2, "table", tests::fuzz::table);
}

#[test]
fn any_record_does_no_harm() {
    run_times(MUTATIONS / 2, "signal", tests::fuzz::signal);
}

/// Fewer: each is a file on the disk.
#[test]
fn any_log_does_no_harm() {
    run_times(MUTATIONS / 20, "log", tests::fuzz::log);
}

#[test]
fn the_corpus_reaches_what_lies_behind_the_checks() {
    use shared::link::{Counters, Decoder, ToBoard};
    let mut good = 0;
    for bytes in corpus("link") {
        let mut decoder = Decoder::new();
        for byte in bytes.iter().skip(1).filter(|_| bytes[0] < 128) {
            decoder.push::<ToBoard>(*byte);
        }
        let Counters { good: found, .. } = decoder.counters();
        good += found;
    }
    assert!(good >= 10, "{good} requests in the corpus");
}
