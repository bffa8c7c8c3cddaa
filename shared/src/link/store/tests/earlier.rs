//! Slots that earlier programs wrote.

use super::*;
use crate::settings::DriveKind;

/// By version 0.2.0 and by the last program of layout 2.
const EARLIER: [&[u8]; 2] = [
    include_bytes!("../layout-1.bin"),
    include_bytes!("../layout-2.bin"),
];

/// What they were given to store: settings for the wires with a value of its own in every group.
fn stored_earlier(layout: usize) -> Settings {
    let mut told = Settings::for_rig(&WIRES);
    told.rig.gap_m = 1.25e-3;
    told.force.zero_code = 611.5;
    told.hammer.unit_per_code *= -1.0;
    told.cart.zero_code = 2050.25;
    told.drive.kind = DriveKind::Motor;
    told.drive.frequency_slew_hz_per_s = 0.125;
    told.limits.travel_m = 8.5e-3;
    told.trips.regime_lost_s = 45.0;
    told.trips.link_timeout_s = 1.5;
    told.detection.refractory_s = 1.75e-3;
    if layout == 1 {
        // The usual limit of version 0.2.0 was another.
        told.limits.min_frequency_hz = 0.75 * WIRES.natural_frequency_hz() as f32;
    } else {
        told.operator.heartbeat = true;
        told.operator.acknowledge = true;
        told.aim.force_n = 61.5;
        told.aim.power = true;
    }
    told
}

#[test]
fn settings_that_an_earlier_program_stored_are_taken_over() {
    for (image, layout) in EARLIER.into_iter().zip(1..) {
        let mut store = SlotStore::new(Flash::<4>::new(), SLOTS);
        store.flash.bytes[..image.len()].copy_from_slice(image);
        let old = stored_earlier(layout);
        assert_eq!(load(&mut store), Loaded::Settings(old), "layout {layout}");
        // Sent again they are stored in today's layout, in the other slot.
        assert_eq!(store.save(&old), Ok(Saved::Written));
        assert_eq!(store.flash.bytes[..image.len()], *image);
        assert_eq!(load(&mut store), Loaded::Settings(old), "layout {layout}");
        assert_eq!(store.save(&old), Ok(Saved::Unchanged));
    }
}

#[test]
fn damaged_or_absurd_settings_of_an_earlier_program_are_not_taken_over() {
    for image in EARLIER {
        for at in 0..image.len() {
            let mut store = SlotStore::new(Flash::<4>::new(), SLOTS);
            store.flash.bytes[..image.len()].copy_from_slice(image);
            store.flash.bytes[at] ^= 0x10;
            let loaded = load(&mut store);
            let used = HEADER.contains(&at) || (PAYLOAD_AT..payload_end(image)).contains(&at);
            assert_eq!(loaded == Loaded::Corrupt, used, "byte {at}: {loaded:?}");
        }
        // A CRC that is right over a mass of the hammer that no rig has.
        let mut absurd = image.to_vec();
        let mass = 0.298_f64.to_le_bytes();
        let at = absurd.windows(8).position(|bytes| bytes == mass).unwrap();
        absurd[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
        let check = check_of(&absurd[..12], &absurd[PAYLOAD_AT..payload_end(image)]);
        absurd[12..16].copy_from_slice(&check.to_le_bytes());
        let mut store = SlotStore::new(Flash::<4>::new(), SLOTS);
        store.flash.bytes[..absurd.len()].copy_from_slice(&absurd);
        assert_eq!(load(&mut store), Loaded::Corrupt);
    }
}

fn payload_end(image: &[u8]) -> usize {
    PAYLOAD_AT + usize::from(u16::from_le_bytes([image[6], image[7]]))
}
