//! Settings in flash: two slots, so that a power cut at any moment leaves the old settings or the new.
//!
//! A slot is one or more erase sectors of its own. Its image:
//!
//! | bytes | what |
//! |---|---|
//! | 0..4 | "VIHS" |
//! | 4..6 | layout version of the payload |
//! | 6..8 | length of the payload |
//! | 8..12 | sequence number (wraps) |
//! | 12..16 | CRC-32 (ISO-HDLC) of bytes 0..12 and the payload |
//! | 32..40 | "complete": written last; zeros before the slot is erased |
//! | 40..48 | erased; zeros: in doubt |
//! | 64.. | the settings in postcard's encoding |
//!
//! Numbers are little-endian, everything between is erased (0xff), and every part begins at a multiple of 32
//! bytes, so any write size up to that will do.
//!
//! [`SlotStore::save`] never erases the slot that holds the newest settings. It takes the mark off the other, erases it, writes
//! payload, header and mark, in that order, and reads all of it back. A slot counts as whole when its CRC is right. The
//! mark is for the other case: a slot whose CRC is wrong was either never finished (no mark; the power went
//! while it was written or erased, and the other slot stands) or finished once and damaged since (mark).
//! Cells that a cut left halfway may read either way at the next start; then so does the CRC, and either
//! way one of the two slots is whole.
//!
//! ## An older copy
//!
//! A damaged slot beside a whole one may have held the newer settings. The whole one is then [`Loaded::OlderCopy`]: it
//! is not taken until somebody confirms it (by storing the same again) or sends others. Before the
//! damaged slot is erased, the whole one is marked as in doubt. So after a power cut in the midst of that it is
//! still an older copy, and not what was stored last.
//!
//! ## Settings that cannot be read
//!
//! [`Loaded::Corrupt`] means that settings were stored and cannot be read: no slot is whole and one is
//! damaged or both hold something; or the newest is of a layout this program does not know, or is out of
//! range. The last two are not passed over in favour of the older slot: after a change of firmware it may be
//! years old. The controller reports [`crate::fault::Fault::CorruptSettings`] and does not start until
//! settings are sent.
//!
//! ## Settings of an earlier program
//!
//! Settings of layouts 1 (version 0.2.0) and 2 are taken over (`layouts.rs`): what they do not have gets the value
//! that their program worked with. They are checked like all others, and are corrupt if today's check refuses them. The slot
//! stays as it is until settings are sent, the same ones included. An earlier program does not know a later layout: to
//! it they are corrupt.
//!
//! Writing and erasing stalls a microcontroller with a single flash bank (up to 2 s for 128 KiB on an
//! STM32F446): the caller sees to it that the controller is in Idle with the drive off.

mod layouts;

use core::ops::Range;

use embedded_storage::nor_flash::{MultiwriteNorFlash, ReadNorFlash};

use crate::crc_32::CRC_32;
use crate::settings::Settings;

/// Layout of the payload: changes whenever [`Settings`] does. `layouts.rs` then keeps the layout before.
pub const LAYOUT: u16 = 3;

/// Bytes of a slot that are used.
pub const IMAGE_BYTES: usize = 512;

/// Every part of an image begins at a multiple of this, bytes.
const ALIGN: usize = 32;

const NAME: [u8; 4] = *b"VIHS";
const MARK: [u8; 8] = *b"complete";
/// Bits of the mark that may be wrong: half-erased bits fall that close to it by chance once in 10⁷.
const MARK_ERRORS: u32 = 12;

/// As many bits must be zero for a doubt.
const DOUBT_ERRORS: u32 = 32;

const HEADER: Range<usize> = 0..16;
const MARK_AT: Range<usize> = ALIGN..ALIGN + MARK.len();
const DOUBT_AT: Range<usize> = MARK_AT.end..MARK_AT.end + 8;
const PAYLOAD_AT: usize = 2 * ALIGN;

type Image = [u8; IMAGE_BYTES];

/// The result of loading.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and one lives at a time"
)]
pub enum Loaded {
    /// The settings stored last. They passed [`Settings::check`].
    Settings(Settings),
    /// Settings that passed their check, but those stored last may be others, that were damaged since.
    OlderCopy(Settings),
    /// None were ever stored (or the power failed during the first save).
    Default,
    /// Settings were stored and cannot be read.
    Corrupt,
}

/// The result of a save.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saved {
    /// Written and read back.
    Written,
    /// These very settings are stored already; nothing was written.
    Unchanged,
}

/// Why settings were not stored; those stored before are still there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveError<E> {
    /// The flash returned an error.
    Flash(E),
    /// The bytes read back differ from those written.
    NotAsWritten,
    /// A slot is too small or the flash writes in larger pieces than an image has.
    NotSuited,
}

impl<E> From<E> for SaveError<E> {
    fn from(error: E) -> Self {
        Self::Flash(error)
    }
}

/// The contents of a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and one lives at a time"
)]
enum Slot {
    /// Every byte erased (0xff).
    Blank,
    /// Neither whole nor ever finished.
    Unfinished,
    /// Finished once, and no longer whole.
    Damaged,
    /// Its CRC is right.
    Whole {
        sequence: u32,
        /// None: a layout that is not known, or out of range.
        settings: Option<Settings>,
        /// Written by an earlier program.
        earlier: bool,
        /// There were newer ones that are lost.
        in_doubt: bool,
    },
}

impl Slot {
    fn of(image: &Image) -> Self {
        if let Some((sequence, layout, payload)) = whole(image) {
            let settings = layouts::decode(layout, payload);
            let settings = settings.filter(|settings| settings.check().is_ok());
            let doubt = image.get(DOUBT_AT).unwrap_or(&[]).iter();
            let zeros = doubt.map(|byte| byte.count_zeros()).sum::<u32>();
            return Self::Whole {
                sequence,
                settings,
                earlier: layout < LAYOUT,
                in_doubt: zeros > DOUBT_ERRORS,
            };
        }
        let mark = image.get(MARK_AT).unwrap_or(&[]);
        let wrong = mark.iter().zip(MARK).map(|(a, b)| (a ^ b).count_ones());
        if wrong.sum::<u32>() <= MARK_ERRORS {
            Self::Damaged
        } else if image.iter().all(|byte| *byte == 0xff) {
            Self::Blank
        } else {
            Self::Unfinished
        }
    }

    fn sequence(&self) -> Option<u32> {
        match self {
            Self::Whole { sequence, .. } => Some(*sequence),
            _ => None,
        }
    }
}

/// Sequence number, layout version and payload of an image whose CRC is right.
fn whole(image: &Image) -> Option<(u32, u16, &[u8])> {
    let (checked, check) = image.get(HEADER)?.split_last_chunk::<4>()?;
    let (name, rest) = checked.split_first_chunk::<4>()?;
    let (layout, rest) = rest.split_first_chunk::<2>()?;
    let (length, rest) = rest.split_first_chunk::<2>()?;
    let (sequence, _) = rest.split_first_chunk::<4>()?;
    let length = usize::from(u16::from_le_bytes(*length));
    let payload = image.get(PAYLOAD_AT..PAYLOAD_AT.checked_add(length)?)?;
    let right = *name == NAME && check_of(checked, payload) == u32::from_le_bytes(*check);
    let sequence = u32::from_le_bytes(*sequence);
    right.then_some((sequence, u16::from_le_bytes(*layout), payload))
}

fn check_of(header: &[u8], payload: &[u8]) -> u32 {
    let mut digest = CRC_32.digest();
    digest.update(header);
    digest.update(payload);
    digest.finalize()
}

/// The image of `settings`, and where its payload ends. `None` if they do not fit (no settings are that long).
fn image_of(settings: &Settings, sequence: u32) -> Option<(Image, usize)> {
    let mut image = [0xff; IMAGE_BYTES];
    let length = {
        let place = image.get_mut(PAYLOAD_AT..)?;
        postcard::to_slice(settings, place).ok()?.len()
    };
    let end = PAYLOAD_AT.checked_add(length)?;
    let mut header = heapless::Vec::<u8, 16>::new();
    header.extend_from_slice(&NAME).ok()?;
    header.extend_from_slice(&LAYOUT.to_le_bytes()).ok()?;
    let short = u16::try_from(length).ok()?;
    header.extend_from_slice(&short.to_le_bytes()).ok()?;
    header.extend_from_slice(&sequence.to_le_bytes()).ok()?;
    let check = check_of(&header, image.get(PAYLOAD_AT..end)?);
    header.extend_from_slice(&check.to_le_bytes()).ok()?;
    put(&mut image, HEADER, &header);
    put(&mut image, MARK_AT, &MARK);
    Some((image, end))
}

/// A sum of settings, which others hardly have. `None` if they do not fit (no settings are that long).
pub fn sum(settings: &Settings) -> Option<u32> {
    let (image, end) = image_of(settings, 0)?;
    Some(CRC_32.checksum(image.get(..end)?))
}

fn put(image: &mut Image, at: Range<usize>, bytes: &[u8]) {
    for (place, byte) in image.iter_mut().skip(at.start).zip(bytes) {
        *place = *byte;
    }
}

/// Settings in two slots of a flash.
#[derive(Debug)]
pub struct SlotStore<F> {
    flash: F,
    slots: [Range<u32>; 2],
}

impl<F: MultiwriteNorFlash> SlotStore<F> {
    /// Settings in two slots of `flash`, each a range of offsets that can be erased by itself and has at
    /// least [`IMAGE_BYTES`] bytes.
    pub fn new(flash: F, slots: [Range<u32>; 2]) -> Self {
        Self { flash, slots }
    }

    /// The flash, given back.
    pub fn release(self) -> F {
        self.flash
    }

    /// The settings stored last.
    ///
    /// # Errors
    /// If the flash cannot be read: its error.
    pub fn load(&mut self) -> Result<Loaded, F::Error> {
        let slots = self.read_slots()?;
        Ok(choose(&slots))
    }

    /// Stores `settings`. The caller has checked them, and the controller is in Idle with the drive off.
    ///
    /// # Errors
    /// If the flash fails or is not suited ([`SaveError`]); the settings stored before are still there then.
    pub fn save(&mut self, settings: &Settings) -> Result<Saved, SaveError<F::Error>> {
        let suited = |slot: &Range<u32>| slot.end.saturating_sub(slot.start) >= IMAGE_BYTES as u32;
        let sizes = [F::WRITE_SIZE, F::READ_SIZE];
        let divides = |size: &usize| ALIGN.checked_rem(*size) == Some(0);
        if !self.slots.iter().all(suited) || !sizes.iter().all(divides) {
            return Err(SaveError::NotSuited);
        }
        let slots = self.read_slots()?;
        let newest = newest(&slots);
        let sequence = newest.map_or(1, |(_, sequence)| sequence.wrapping_add(1));
        let held = newest.and_then(|(slot, _)| slots.get(slot));
        let earlier = matches!(held, Some(Slot::Whole { earlier: true, .. }));
        if !earlier && choose(&slots) == Loaded::Settings(*settings) {
            return Ok(Saved::Unchanged);
        }
        let (image, end) = image_of(settings, sequence).ok_or(SaveError::NotSuited)?;
        // The slot that does not hold the newest; the first while none does, so that the second stays blank.
        let [first, second] = &self.slots;
        let target = if newest.map(|(slot, _)| slot) == Some(0) {
            second.clone()
        } else {
            first.clone()
        };
        if slots.contains(&Slot::Damaged)
            && let Some(older) = newest.and_then(|(slot, _)| self.slots.get(slot))
        {
            let older = older.start;
            self.overwrite(older, &MARK)?;
        }
        self.overwrite(target.start, &[])?;
        self.flash.erase(target.start, target.end)?;
        let parts = [PAYLOAD_AT..end, HEADER, MARK_AT];
        for part in parts {
            let whole = part.start..part.end.next_multiple_of(ALIGN);
            let offset = target.start.saturating_add(part.start as u32);
            let bytes = image.get(whole).ok_or(SaveError::NotSuited)?;
            self.flash.write(offset, bytes)?;
        }
        if self.image(&target)? == image {
            Ok(Saved::Written)
        } else {
            Err(SaveError::NotAsWritten)
        }
    }

    /// Writes `mark` and then zeros where a slot's mark and doubt are. Bits only ever go to zero.
    fn overwrite(&mut self, slot: u32, mark: &[u8]) -> Result<(), F::Error> {
        let mut part = [0; ALIGN];
        for (place, byte) in part.iter_mut().zip(mark) {
            *place = *byte;
        }
        let offset = slot.saturating_add(MARK_AT.start as u32);
        self.flash.write(offset, &part)
    }

    fn read_slots(&mut self) -> Result<[Slot; 2], F::Error> {
        let [first, second] = self.slots.clone();
        let first = Slot::of(&self.image(&first)?);
        let second = Slot::of(&self.image(&second)?);
        Ok([first, second])
    }

    fn image(&mut self, slot: &Range<u32>) -> Result<Image, F::Error> {
        let mut image = [0; IMAGE_BYTES];
        ReadNorFlash::read(&mut self.flash, slot.start, &mut image)?;
        Ok(image)
    }
}

/// The newest whole slot, and its sequence number.
fn newest(slots: &[Slot; 2]) -> Option<(usize, u32)> {
    let [first, second] = slots;
    match (first.sequence(), second.sequence()) {
        (Some(a), Some(b)) => {
            // Half the circle ahead is newer: numbers wrap.
            let ahead = b.wrapping_sub(a);
            Some(if ahead != 0 && ahead < 1 << 31 {
                (1, b)
            } else {
                (0, a)
            })
        }
        (Some(a), None) => Some((0, a)),
        (None, Some(b)) => Some((1, b)),
        (None, None) => None,
    }
}

fn choose(slots: &[Slot; 2]) -> Loaded {
    let any_damaged = slots.contains(&Slot::Damaged);
    let newest = newest(slots).and_then(|(slot, _)| slots.get(slot));
    if let Some(Slot::Whole {
        settings, in_doubt, ..
    }) = newest
    {
        return match settings {
            Some(settings) if any_damaged || *in_doubt => Loaded::OlderCopy(*settings),
            Some(settings) => Loaded::Settings(*settings),
            None => Loaded::Corrupt,
        };
    }
    let both_used = slots.iter().all(|slot| *slot != Slot::Blank);
    if any_damaged || both_used {
        Loaded::Corrupt
    } else {
        Loaded::Default
    }
}

#[cfg(test)]
mod tests;
