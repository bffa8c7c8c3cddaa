//! The hammer on the microcontroller (being written).
#![no_std]
