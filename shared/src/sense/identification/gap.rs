//! Surface, rest position and the gap between them.
//!
//! The observer's displacement at the onset, averaged, less the rest position: that of the self test, until the flights' Δ₀
//! lies further from it than a fifth of A0. A rig that tilts moves the rest position, and not the surface; a sensor's zero that
//! drifts moves both, and no gap. So Δ₀ is that of the last few windows, averaged over the last contacts as
//! the onsets are.

use super::statistics::{Average, FadingLine};
use super::{FEWEST_CONTACTS, OnlineEstimate};

/// Largest number of contacts in the gap: few, so that it follows a surface that recedes,
pub const GAP_MEMORY: u32 = 24;
/// and fewer once so many contacts in a row were on the same side of the mean (at 100 µm/s on the wires it is 0.15 mm late).
const MOVING_MEMORY: u32 = 6;
const MOVING_CONTACTS: i8 = 5;

/// Windows that tell where the hammer would rest now, and windows in a row off their line after which it rests elsewhere.
const REST_MEMORY: u32 = 6;
const REST_JUMPED: u8 = 4;
/// Windows without a contact after which the rest position is that of the flights alone.
const LONG_FLIGHT: u8 = 6;

/// A gap further from the mean than this many spreads is another gap,
const GAP_JUMP: f32 = 5.0;
/// if so many contacts in a row agree.
const MOVED_CONTACTS: u8 = 4;

/// A rest position less far from that of the self test than this is the same, in units of A0.
const REST_MOVED: f32 = 0.2;
/// Of windows with contacts too weak to be seen, only a rest position beyond the surface by so many scatters tells anything.
const REST_SURE: f32 = 3.0;

/// Surface and rest position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    amplitude_m: f32,
    /// Where the contacts found the surface, from where the hammer rested in the self test, m.
    surface: Average<GAP_MEMORY>,
    /// Contacts in a row far from the mean gap.
    moved: u8,
    /// Contacts in a row beyond the mean gap; negative: nearer.
    side: i8,
    /// Square of a gap's least spread, m²: 1 % of A0.
    grain_m2: f32,
    /// The points of the last few windows: where the hammer would rest now.
    rest: FadingLine<REST_MEMORY>,
    /// Points in a row that lie off it, and windows since the last contact.
    off_rest: u8,
    flown: u8,
    /// Where the hammer would have rested at the contacts of `surface`, from where it rested in the self test, m.
    rest_m: Average<GAP_MEMORY>,
}

impl Gap {
    pub fn new(amplitude_m: f32) -> Self {
        Self {
            amplitude_m,
            surface: Average::default(),
            moved: 0,
            side: 0,
            grain_m2: 1e-4 * amplitude_m * amplitude_m,
            rest: FadingLine::default(),
            off_rest: 0,
            flown: 0,
            rest_m: Average::default(),
        }
    }

    /// Flights before this told little: a hammer that the surface presses on does not fly.
    pub fn at_amplitude(&mut self) {
        self.rest = FadingLine::default();
    }

    /// The point of a window moves the place at which the hammer would rest; one that lies off does not, several in a row do at
    /// once.
    pub fn window(&mut self, (x, y): (f32, f32), grain: f32) {
        let off = self.rest.is_off(x, y, grain);
        self.off_rest = if off { self.off_rest + 1 } else { 0 };
        if self.off_rest >= REST_JUMPED {
            self.off_rest = 0;
            self.rest.move_to(x, y);
            self.rest_m.count = 0;
        } else if !off {
            self.rest.push(x, y);
        }
        self.flown = self.flown.saturating_add(1);
        if self.flown > LONG_FLIGHT
            && let Some(rest_m) = self.rest_now_m()
        {
            self.rest_m.mean = rest_m;
        }
    }

    /// Where the last contacts found the surface, from the rest position of the self test, m; none before there are enough.
    pub fn surface_m(&self) -> Option<f32> {
        (self.surface.count >= FEWEST_CONTACTS).then_some(self.surface.mean)
    }

    /// The gap, m: the surface from where the hammer would rest now.
    pub fn gap_m(&self) -> Option<f32> {
        Some(self.surface_m()? - self.rest_m())
    }

    /// Where the hammer would rest, from where it rested in the self test, m.
    fn rest_m(&self) -> f32 {
        let rest_m = self.rest_m.mean;
        let moved = libm::fabsf(rest_m) > REST_MOVED * self.amplitude_m;
        if moved { rest_m } else { 0.0 }
    }

    /// Where the hammer would rest by the last few windows alone, m; none if they do not tell it.
    #[inline(never)]
    fn rest_now_m(&self) -> Option<f32> {
        let (slope, square) = self.rest.fit()?;
        let rest_m = self.rest.x - self.rest.y / slope;
        let far = slope * rest_m > REST_SURE * libm::sqrtf(square);
        (far || self.rest.straight().is_some()).then_some(rest_m)
    }

    /// Takes in the gap of a contact. Contacts that agree on another gap than those before begin the mean anew: the
    /// surface has moved.
    pub fn contact(&mut self, gap_m: f32) {
        self.flown = 0;
        let off = gap_m - self.surface.mean;
        let far = self.surface.count >= FEWEST_CONTACTS
            && off * off > GAP_JUMP * GAP_JUMP * (self.surface.variance + self.grain_m2);
        self.moved = if far { self.moved + 1 } else { 0 };
        if self.moved >= MOVED_CONTACTS {
            self.surface = Average::default();
            self.rest_m.count = 0;
            self.moved = 0;
        }
        if far {
            return;
        }
        let beyond = off > 0.0;
        let turned = beyond != (self.side > 0);
        let side = if turned { 0 } else { self.side };
        self.side = if beyond {
            side.saturating_add(1)
        } else {
            side.saturating_sub(1)
        };
        let moves = self.side.unsigned_abs() >= MOVING_CONTACTS.unsigned_abs();
        let memory = if moves { MOVING_MEMORY } else { GAP_MEMORY };
        self.surface.push_within(gap_m, memory);
        let rest_m = self.rest_now_m().unwrap_or(self.rest_m.mean);
        self.rest_m.push_within(rest_m, MOVING_MEMORY);
    }

    /// The gap, with its spread.
    pub fn estimate(&self) -> Option<OnlineEstimate> {
        let value = self.gap_m()?;
        Some(OnlineEstimate {
            value,
            sigma: self.surface.sigma(),
            samples: self.surface.count,
        })
    }
}
