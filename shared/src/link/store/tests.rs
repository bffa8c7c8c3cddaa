//! A flash that loses power at every step, and worse.

mod earlier;

use std::vec::Vec;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind};

use super::*;
use crate::model::contact::LAWS;
use crate::model::params::{PRESETS, RigParams, WIRES};

const SLOT: usize = 1024;
const SLOTS: [Range<u32>; 2] = [0..SLOT as u32, SLOT as u32..2 * SLOT as u32];

/// Erasing takes several steps; power can go at each.
const ERASE_STEPS: usize = 4;

/// A flash of two sectors that writes `W` bytes at a time and only ever clears bits, in which power goes at
/// a chosen step, in the middle of it.
struct Flash<const W: usize> {
    bytes: Vec<u8>,
    /// Steps until power goes.
    left: Option<u32>,
    steps: u32,
    random: u32,
}

impl<const W: usize> Flash<W> {
    fn new() -> Self {
        Self {
            bytes: std::vec![0xff; 2 * SLOT],
            left: None,
            steps: 0,
            random: 1,
        }
    }

    fn byte(&mut self) -> u8 {
        self.random = self
            .random
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        (self.random >> 24) as u8
    }

    /// Whether power goes in this step; after it, nothing works.
    fn cut(&mut self) -> Result<bool, NorFlashErrorKind> {
        self.steps += 1;
        match &mut self.left {
            None => Ok(false),
            Some(0) => Err(NorFlashErrorKind::Other),
            Some(left) => {
                *left -= 1;
                Ok(*left == 0)
            }
        }
    }
}

impl<const W: usize> ErrorType for Flash<W> {
    type Error = NorFlashErrorKind;
}

impl<const W: usize> ReadNorFlash for Flash<W> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        let from = offset as usize;
        bytes.copy_from_slice(&self.bytes[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const W: usize> MultiwriteNorFlash for Flash<W> {}

impl<const W: usize> NorFlash for Flash<W> {
    const WRITE_SIZE: usize = W;
    const ERASE_SIZE: usize = SLOT;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        assert!((from as usize).is_multiple_of(SLOT) && (to as usize).is_multiple_of(SLOT));
        for step in 0..ERASE_STEPS {
            let cut = self.cut()?;
            // The sector goes through all zeros or through noise, by the luck of the draw.
            let zeros = self.byte() & 1 == 0;
            for at in from as usize..to as usize {
                let noise = self.byte();
                self.bytes[at] = match step {
                    0 if zeros => 0,
                    0 => self.bytes[at] | noise,
                    _ => self.bytes[at] | noise | self.byte(),
                };
            }
            if cut {
                return Err(NorFlashErrorKind::Other);
            }
        }
        self.bytes[from as usize..to as usize].fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        assert!((offset as usize).is_multiple_of(W) && bytes.len().is_multiple_of(W));
        for (i, word) in bytes.chunks(W).enumerate() {
            let cut = self.cut()?;
            let at = offset as usize + i * W;
            for (j, byte) in word.iter().enumerate() {
                assert_eq!(byte & !self.bytes[at + j], 0, "it would need erasing");
                let missing = if cut { self.byte() } else { 0 };
                self.bytes[at + j] &= byte | missing;
            }
            if cut {
                return Err(NorFlashErrorKind::Other);
            }
        }
        Ok(())
    }
}

fn settings(mark: u16) -> Settings {
    let mut settings = Settings::for_rig(&WIRES);
    settings.trips.no_contact_s = 1.0 + f32::from(mark);
    settings
}

/// What is there at a new start, with power that stays.
fn load<const W: usize>(flash: &mut SlotStore<Flash<W>>) -> Loaded {
    flash.flash.left = None;
    flash.load().unwrap()
}

/// The settings found, if any; anything but whole settings or none at all fails.
fn found<const W: usize>(store: &mut SlotStore<Flash<W>>) -> Option<Settings> {
    match load(store) {
        Loaded::Settings(settings) => Some(settings),
        Loaded::Default => None,
        Loaded::OlderCopy(_) | Loaded::Corrupt => panic!("neither old nor new"),
    }
}

#[test]
fn what_is_saved_is_loaded_and_slots_take_turns() {
    let mut store = SlotStore::new(Flash::<4>::new(), SLOTS);
    assert_eq!(load(&mut store), Loaded::Default);
    for mark in 0..5 {
        assert_eq!(store.save(&settings(mark)), Ok(Saved::Written));
        assert_eq!(load(&mut store), Loaded::Settings(settings(mark)));
        let steps = store.flash.steps;
        assert_eq!(store.save(&settings(mark)), Ok(Saved::Unchanged));
        assert_eq!(store.flash.steps, steps);
    }
    for (_, rig) in PRESETS {
        for (_, contact) in LAWS {
            let settings = Settings::for_rig(&RigParams { contact, ..rig });
            store.save(&settings).unwrap();
            assert_eq!(found(&mut store), Some(settings));
        }
    }
}

/// Several saves; at each step of each, power goes. Twice in a row, too: what the first cut leaves is what
/// the second attempt starts from.
fn power_goes_everywhere<const W: usize>(seed: u32) {
    let mut store = SlotStore::new(Flash::<W>::new(), SLOTS);
    store.flash.random = seed;
    let mut old = None;
    for mark in 0..4 {
        let new = settings(mark);
        let bytes = store.flash.bytes.clone();
        let before = store.flash.steps;
        store.save(&new).unwrap();
        let steps = store.flash.steps - before;
        assert!(steps as usize > ERASE_STEPS + 200 / W);
        for first in 1..=steps {
            let second = 1 + first.wrapping_mul(seed) % steps;
            store.flash.bytes.clone_from(&bytes);
            for cut in [first, second] {
                store.flash.left = Some(cut);
                let saved = store.save(&new);
                let now = found(&mut store);
                assert!(now == old || now == Some(new), "cut at {cut}: {now:?}");
                assert!(saved.is_err() || now == Some(new), "cut at {cut}");
            }
            assert!(store.save(&new).is_ok());
            assert_eq!(found(&mut store), Some(new));
        }
        old = Some(new);
    }
}

#[test]
fn a_power_cut_at_every_step_leaves_the_old_settings_or_the_new() {
    for seed in 1..=20 {
        power_goes_everywhere::<4>(seed);
    }
    power_goes_everywhere::<1>(21);
    power_goes_everywhere::<32>(22);
}

#[test]
fn the_sequence_number_wraps() {
    let mut store = SlotStore::new(Flash::<4>::new(), SLOTS);
    let (image, _) = image_of(&settings(1), u32::MAX).unwrap();
    store.flash.bytes[..IMAGE_BYTES].copy_from_slice(&image);
    for mark in 2..6 {
        store.save(&settings(mark)).unwrap();
        assert_eq!(found(&mut store), Some(settings(mark)));
    }
}

#[test]
fn damage_leaves_an_older_copy_or_is_corrupt() {
    let mut once = SlotStore::new(Flash::<4>::new(), SLOTS);
    once.save(&settings(1)).unwrap();
    let mut twice = SlotStore::new(Flash::<4>::new(), SLOTS);
    twice.save(&settings(1)).unwrap();
    twice.save(&settings(2)).unwrap();
    let length = image_of(&settings(1), 1).unwrap().1 - PAYLOAD_AT;
    let used = HEADER.chain(PAYLOAD_AT..PAYLOAD_AT + length);
    for byte in used {
        for bit in 0..8 {
            let flip = 1 << bit;
            // The only slot: corrupt.
            once.flash.bytes[byte] ^= flip;
            assert_eq!(load(&mut once), Loaded::Corrupt, "byte {byte}");
            once.flash.bytes[byte] ^= flip;
            // The newer of two damaged: the other one is an older copy. Both: corrupt.
            twice.flash.bytes[SLOT + byte] ^= flip;
            let older = Loaded::OlderCopy(settings(1));
            assert_eq!(load(&mut twice), older, "byte {byte}");
            twice.flash.bytes[byte] ^= flip;
            assert_eq!(load(&mut twice), Loaded::Corrupt, "byte {byte}");
            twice.flash.bytes[byte] ^= flip;
            twice.flash.bytes[SLOT + byte] ^= flip;
        }
    }
    // New settings mend it.
    once.flash.bytes[PAYLOAD_AT] ^= 1;
    once.save(&settings(3)).unwrap();
    assert_eq!(found(&mut once), Some(settings(3)));
}

/// A store whose newest settings (2) are damaged in `byte` of their slot, beside those before them (1).
fn damaged(byte: usize) -> SlotStore<Flash<4>> {
    let mut store = SlotStore::new(Flash::<4>::new(), SLOTS);
    store.save(&settings(1)).unwrap();
    store.save(&settings(2)).unwrap();
    store.flash.bytes[SLOT + byte] ^= 1;
    store
}

#[test]
fn an_older_copy_is_taken_once_it_is_confirmed_or_others_are_sent() {
    for byte in [0, 8, 12, PAYLOAD_AT, PAYLOAD_AT + 40] {
        for sent in [1, 2, 3] {
            let mut store = damaged(byte);
            assert_eq!(load(&mut store), Loaded::OlderCopy(settings(1)));
            // Looking at it changes nothing.
            assert_eq!(load(&mut store), Loaded::OlderCopy(settings(1)));
            assert_eq!(store.save(&settings(sent)), Ok(Saved::Written));
            assert_eq!(load(&mut store), Loaded::Settings(settings(sent)));
            assert_eq!(store.save(&settings(sent)), Ok(Saved::Unchanged));
        }
    }
}

#[test]
fn a_power_cut_never_makes_an_older_copy_the_settings_stored_last() {
    for seed in 1..=20 {
        for sent in [1, 3] {
            let mut whole = damaged(PAYLOAD_AT + 7);
            whole.flash.random = seed;
            let before = whole.flash.steps;
            whole.save(&settings(sent)).unwrap();
            let steps = whole.flash.steps - before;
            for first in 1..=steps {
                let second = 1 + first.wrapping_mul(seed) % steps;
                let mut store = damaged(PAYLOAD_AT + 7);
                store.flash.random = seed.wrapping_mul(first);
                for cut in [first, second] {
                    store.flash.left = Some(cut);
                    let saved = store.save(&settings(sent));
                    match load(&mut store) {
                        Loaded::OlderCopy(older) => {
                            assert!(saved.is_err());
                            assert_eq!(older, settings(1), "cut at {cut}");
                        }
                        loaded => assert_eq!(loaded, Loaded::Settings(settings(sent)), "{cut}"),
                    }
                }
                store.save(&settings(sent)).unwrap();
                assert_eq!(load(&mut store), Loaded::Settings(settings(sent)));
            }
        }
    }
}

#[test]
fn settings_that_are_whole_but_cannot_be_used_are_corrupt_even_beside_older_ones() {
    let of_layout = |layout: u16| {
        let (mut image, end) = image_of(&settings(2), 2).unwrap();
        image[4..6].copy_from_slice(&layout.to_le_bytes());
        let check = check_of(&image[..12], &image[PAYLOAD_AT..end]);
        image[12..16].copy_from_slice(&check.to_le_bytes());
        image
    };
    let mut bad = settings(2);
    bad.trips.force_n = f32::NAN;
    let out_of_range = image_of(&bad, 2).unwrap().0;
    // The payload of one layout does not pass for that of another.
    let others = [0, 1, 2, LAYOUT + 1].map(of_layout);
    for image in others.into_iter().chain([out_of_range]) {
        let mut store = SlotStore::new(Flash::<4>::new(), SLOTS);
        store.save(&settings(1)).unwrap();
        store.flash.bytes[SLOT..SLOT + IMAGE_BYTES].copy_from_slice(&image);
        assert_eq!(load(&mut store), Loaded::Corrupt);
        // They are left alone until whole new ones are stored.
        store.save(&settings(3)).unwrap();
        assert_eq!(found(&mut store), Some(settings(3)));
        assert_eq!(store.flash.bytes[SLOT..SLOT + IMAGE_BYTES], image);
    }
}

#[test]
fn a_flash_full_of_something_else_is_corrupt_and_one_odd_sector_is_not() {
    let mut store = SlotStore::new(Flash::<4>::new(), SLOTS);
    store.flash.bytes[..SLOT].fill(0x3c);
    assert_eq!(load(&mut store), Loaded::Default);
    store.flash.bytes[SLOT..].fill(0);
    assert_eq!(load(&mut store), Loaded::Corrupt);
}

#[test]
fn a_slot_too_small_or_a_flash_too_coarse_is_refused_untouched() {
    let small = [0..256, 1024..1280];
    let mut store = SlotStore::new(Flash::<4>::new(), small);
    store.flash.bytes[0] = 7;
    assert_eq!(store.save(&settings(1)), Err(SaveError::NotSuited));
    let mut store = SlotStore::new(Flash::<64>::new(), SLOTS);
    store.flash.bytes[0] = 7;
    assert_eq!(store.save(&settings(1)), Err(SaveError::NotSuited));
    assert_eq!((store.flash.steps, store.flash.bytes[0]), (0, 7));
}

#[test]
fn flash_that_does_not_hold_what_was_written_is_noticed() {
    struct Stuck(Flash<4>);
    impl ErrorType for Stuck {
        type Error = NorFlashErrorKind;
    }
    impl ReadNorFlash for Stuck {
        const READ_SIZE: usize = 1;
        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
            self.0.read(offset, bytes)
        }
        fn capacity(&self) -> usize {
            self.0.capacity()
        }
    }
    impl MultiwriteNorFlash for Stuck {}
    impl NorFlash for Stuck {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = SLOT;
        fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
            self.0.erase(from, to)
        }
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
            self.0.write(offset, bytes)?;
            // A bit of the second slot is stuck at 0.
            self.0.bytes[SLOT + 100] &= 0xfe;
            Ok(())
        }
    }
    let mut store = SlotStore::new(Stuck(Flash::new()), SLOTS);
    let mut refused = 0;
    let mut stored = None;
    for mark in 1..=8 {
        match store.save(&settings(mark)) {
            Ok(_) => stored = Some(settings(mark)),
            Err(why) => {
                assert_eq!(why, SaveError::NotAsWritten);
                refused += 1;
                // Those before are still there; but others were sent since, and that is not forgotten.
                let older = Loaded::OlderCopy(stored.expect("the first slot holds"));
                assert_eq!(store.load(), Ok(older));
            }
        }
    }
    assert!(refused > 0);
}
