//! The board in a closed loop with the emulator's plant, and the link's wire between board and desktop.
//!
//! At each sampling tick the plant goes on by one tick with what the pins said since the last one (the code at PA4,
//! the enable at PA8, the duty cycle at PC7), and the ADC's channels get what its sensors read.

use std::cell::RefCell;
use std::io::{self, ErrorKind, Read, Write};
use std::iter::Peekable;
use std::rc::Rc;

use emulator::scenario::Scenario;
use emulator::schedule::{Doing, Due, schedule};
use emulator::world::World;
use shared::io::{DacCode, Frame, Output};
use shared::link::BAUD;

use crate::fingerprint::Fingerprint;
use crate::image::Image;
use crate::machine::{Around, Change, Machine, Patch};
use crate::memory::VREFINT_CODE;
use crate::parts::UNITS_PER_US;
use crate::parts::gpio::Outside;
use crate::parts::rcc::External;
use crate::stop::Stop;

/// How long the power stage's enable outlives the last rising edge of PA8 (docs/wiring.md, U1): 2.1 ms.
pub const PULSE_HOLD: u64 = 2_100 * UNITS_PER_US;

/// Option bytes with the brown-out reset at level 3: BOR_LEV 00 (RM0390, 3.8.7).
pub const LEVEL_3: u32 = 0x0fff_aae1;
/// As the part is delivered: BOR_LEV 11, off.
pub const DELIVERED: u32 = 0x0fff_aaed;

/// Numbers of the ports, by their letters.
pub mod port {
    #![allow(missing_docs)]
    pub const A: usize = 0;
    pub const B: usize = 1;
    pub const C: usize = 2;
}

/// ADC channels of PA0, PA1, PB0, and of the reference.
const FORCE: usize = 0;
const HAMMER: usize = 1;
const CART: usize = 8;
const VREFINT: usize = 17;

/// A rig's frequency at a duty cycle of 1, Hz (docs/wiring.md).
const FULL_SCALE_HZ: f64 = 50.0;

/// A wired board on a healthy supply: chain closed, button up, sensors connected, the debugger's clock there.
pub fn wired() -> Around {
    let mut pins = [[Outside::Open; 16]; 8];
    pins[port::B][5] = Outside::Low;
    pins[port::C][13] = Outside::High;
    for (port, pin) in [(port::A, 0), (port::A, 1), (port::B, 0)] {
        pins[port][pin] = Outside::High;
    }
    // The wire's idle level.
    pins[port::A][3] = Outside::High;
    Around {
        hse: External::RUNNING,
        pins,
        supply_v: 3.3,
        lsi_hz: 32_000,
        slow_flash: false,
        options: LEVEL_3,
        baud: u64::from(BAUD),
        patch: Patch::NONE,
    }
}

/// What disturbs the link's wire: of the bytes towards the desktop one in so many is lost, and one in so many garbled.
#[derive(Clone, Copy, Debug)]
pub struct Disturbance {
    /// One in so many is lost.
    pub lost: usize,
    /// One in so many is garbled.
    pub garbled: usize,
}

/// What is done to the rig as soon as something holds, once.
#[derive(Clone, Copy)]
pub struct Trap {
    /// What must hold of the board.
    pub when: fn(&Machine) -> bool,
    /// What is done to the rig then.
    pub then: fn(&mut Rig),
}

/// The board and the plant.
#[derive(Clone)]
pub struct Rig {
    /// The board, on which the firmware runs.
    pub machine: Machine,
    /// The emulator's plant, with its sensors and drive.
    pub world: World,
    due: Peekable<std::vec::IntoIter<Due>>,
    /// When PA8 last rose, and how many changes have been looked at.
    rose: Option<u64>,
    seen: usize,
    output: Output,
    /// Ticks of the plant.
    pub tick: u64,
    /// Codes at PA4, tick by tick.
    pub played: Vec<u16>,
    /// Frequencies that the duty cycle at PC7 stands for, tick by tick, Hz.
    pub frequencies: Vec<f32>,
    /// What the ADC was given, tick by tick.
    pub sampled: Vec<Frame>,
    /// Whether `played`, `frequencies` and `sampled` are kept.
    pub keeps: bool,
    /// Codes that force, hammer and cart read whatever the plant does.
    pub forced: [Option<u16>; 3],
    /// What disturbs the wire.
    pub disturbed: Option<Disturbance>,
    bytes: usize,
    /// Of pins and wire.
    fingerprint: Fingerprint,
    /// What is to be done as soon as something holds.
    pub trap: Option<Trap>,
    /// What ended the run, if something did.
    pub stopped: Option<Stop>,
}

impl Rig {
    /// Power comes on.
    ///
    /// # Errors
    /// The scenario's rig is invalid.
    pub fn power_up(image: Rc<Image>, scenario: &Scenario, around: Around) -> Result<Self, String> {
        let mut machine = Machine::power_up(image, around, scenario.seed);
        machine.codes[VREFINT] = VREFINT_CODE;
        Ok(Self {
            machine,
            world: World::new(scenario).map_err(|e| e.to_string())?,
            due: schedule(scenario).into_iter().peekable(),
            rose: None,
            seen: 0,
            output: Output::SAFE,
            tick: 0,
            played: Vec::new(),
            frequencies: Vec::new(),
            sampled: Vec::new(),
            keeps: true,
            forced: [None; 3],
            disturbed: None,
            bytes: 0,
            fingerprint: Fingerprint::default(),
            trap: None,
            stopped: None,
        })
    }

    /// Goes on for `us` microseconds.
    ///
    /// # Errors
    /// A rule of the machine was broken.
    pub fn advance(&mut self, us: u64) -> Result<(), Stop> {
        let end = self.machine.now + us * UNITS_PER_US;
        while self.machine.now < end {
            if let Err(stop) = self.machine.run_until(end) {
                self.stopped = Some(stop.clone());
                return Err(stop);
            }
            if self.machine.take_pause() {
                self.sample();
            }
            if let Some(trap) = self.trap.filter(|trap| (trap.when)(&self.machine)) {
                self.trap = None;
                (trap.then)(self);
            }
        }
        Ok(())
    }

    /// The emergency-stop chain opens.
    pub fn open_chain(&mut self) {
        let tick_s = 50e-6;
        let now_s = self.world.plant().time_s();
        self.world
            .happen(Doing::Emergency(true, now_s + tick_s / 2.0));
        self.machine.set_pin(port::B, 5, Outside::High);
    }

    /// The emergency-stop chain closes.
    pub fn close_chain(&mut self) {
        let now_s = self.world.plant().time_s();
        self.world.happen(Doing::Emergency(false, now_s));
        self.machine.set_pin(port::B, 5, Outside::Low);
    }

    /// What changed at the edge is no longer wanted, but for the pulses.
    pub fn forget_changes(&mut self) {
        self.is_driven();
        self.machine.changes.clear();
        self.seen = 0;
    }

    /// A sampling tick begins: the plant is where the pins have brought it.
    fn sample(&mut self) {
        while let Some(due) = self.due.next_if(|due| due.tick <= self.tick) {
            self.world.happen(due.what);
        }
        self.world.drift();
        let frame = self.world.tick(&self.output);
        self.tick += 1;
        if self.keeps {
            self.sampled.push(frame);
        }
        let measured = [frame.force.0, frame.hammer.0, frame.cart.0];
        for (i, channel) in [FORCE, HAMMER, CART].into_iter().enumerate() {
            self.machine.codes[channel] = self.forced[i].unwrap_or(measured[i]);
        }
        let chain = if frame.emergency {
            Outside::High
        } else {
            Outside::Low
        };
        if self.machine.around.pins[port::B][5] != chain {
            self.machine.set_pin(port::B, 5, chain);
        }
        // The bias holds a pin that is not driven in the middle (docs/wiring.md).
        let coming = self.machine.parts.dac.coming_code();
        let code = coming.unwrap_or(DacCode::MIDDLE.0);
        let frequency_hz = (self.machine.duty().unwrap_or(0.0) * FULL_SCALE_HZ) as f32;
        if self.keeps {
            self.played.push(code);
            self.frequencies.push(frequency_hz);
        }
        self.output = Output {
            dac: DacCode(code),
            frequency_hz,
            enable: self.is_driven(),
        };
    }

    /// Whether the pulses at PA8 hold the power stage's enable.
    pub fn is_driven(&mut self) -> bool {
        for (at, change) in &self.machine.changes[self.seen..] {
            self.fingerprint.add_change(*at, change);
            if *change == Change::Enable(Some(true)) {
                self.rose = Some(*at);
            }
        }
        self.seen = self.machine.changes.len();
        self.rose
            .is_some_and(|at| self.machine.now < at + PULSE_HOLD)
    }

    /// One number for all that was seen at pins and wire, and what the board holds now.
    pub fn fingerprint(&self) -> u64 {
        let mut fingerprint = self.fingerprint;
        fingerprint.add_machine(&self.machine);
        fingerprint.number()
    }

    /// What of these bytes arrives.
    fn disturb(&mut self, sent: Vec<u8>) -> Vec<u8> {
        let Some(Disturbance { lost, garbled }) = self.disturbed else {
            return sent;
        };
        let mut arrived = Vec::with_capacity(sent.len());
        for byte in sent {
            self.bytes += 1;
            if !self.bytes.is_multiple_of(lost) {
                let flip = self.bytes.is_multiple_of(garbled);
                arrived.push(if flip { byte ^ 0x10 } else { byte });
            }
        }
        arrived
    }
}

/// The desktop's end of the wire: to read is to let a millisecond of the rig pass.
#[derive(Clone)]
pub struct Wire(pub Rc<RefCell<Rig>>);

impl Read for Wire {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut rig = self.0.borrow_mut();
        rig.advance(1000)
            .map_err(|stop| io::Error::other(stop.to_string()))?;
        let sent = std::mem::take(&mut rig.machine.parts.usart.sent);
        rig.fingerprint.add_bytes(&sent);
        let mut arrived = rig.disturb(sent);
        if arrived.is_empty() {
            return Err(ErrorKind::WouldBlock.into());
        }
        let count = arrived.len().min(buffer.len());
        buffer[..count].copy_from_slice(&arrived[..count]);
        rig.machine.parts.usart.sent = arrived.split_off(count);
        Ok(count)
    }
}

impl Write for Wire {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().machine.send(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
