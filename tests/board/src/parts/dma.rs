//! A DMA controller of eight streams (RM0390, chapter 9): direct mode between a peripheral and memory, normal and
//! circular, half and full flags, which request goes to which stream. Not modelled: FIFO mode, bursts, double
//! buffers, memory to memory, the bus's arbitration (a transfer takes no time; of two at once the stream of higher
//! priority goes first).

use super::{Access, Write};

/// What asks for a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Request {
    Adc1,
    Tim2Update,
    Usart2Receive,
    Usart2Send,
}

impl Request {
    /// Who serves it: controller, stream, channel (RM0390, tables 28 and 29).
    pub const ROUTES: [(Self, usize, usize, u32); 6] = [
        (Self::Adc1, 2, 0, 0),
        (Self::Adc1, 2, 4, 0),
        (Self::Tim2Update, 1, 1, 3),
        (Self::Tim2Update, 1, 7, 3),
        (Self::Usart2Receive, 1, 5, 4),
        (Self::Usart2Send, 1, 6, 4),
    ];
}

/// Bits of a stream's control register.
mod bit {
    pub const EN: u32 = 1;
    pub const TEIE: u32 = 1 << 2;
    pub const HTIE: u32 = 1 << 3;
    pub const TCIE: u32 = 1 << 4;
    pub const CIRC: u32 = 1 << 8;
    pub const PINC: u32 = 1 << 9;
    pub const MINC: u32 = 1 << 10;
}

const TRANSFER_ERROR: u32 = 1 << 3;
const HALF: u32 = 1 << 4;
const FULL: u32 = 1 << 5;

/// One of the eight streams of a controller, with its registers.
#[derive(Clone, Debug, Default)]
pub struct Stream {
    control: u32,
    left: u32,
    reload: u32,
    peripheral: u32,
    memory: [u32; 2],
    fifo: u32,
    /// Flags as in the status registers: FIFO, direct mode, transfer error, half, full.
    flags: u32,
    /// What was read ahead from memory.
    ahead: Option<u32>,
}

/// One transfer to be done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transfer {
    /// The peripheral's address.
    pub peripheral: u32,
    /// The memory's address.
    pub memory: u32,
    /// How many bytes are moved: 1, 2 or 4.
    pub width: u32,
    /// From memory to the peripheral.
    pub out: bool,
}

impl Stream {
    /// Whether the stream is enabled.
    pub fn is_on(&self) -> bool {
        self.control & bit::EN != 0
    }

    /// The channel from which its requests come, 0 to 7.
    pub fn channel(&self) -> u32 {
        self.control >> 25 & 7
    }

    fn width(&self) -> u32 {
        1 << (self.control >> 11 & 3)
    }

    /// The transfer that is next in turn.
    pub fn transfer(&self) -> Transfer {
        let step = if self.control & bit::MINC == 0 {
            0
        } else {
            (self.reload - self.left) * self.width()
        };
        Transfer {
            peripheral: self.peripheral,
            memory: self.memory[0] + step,
            width: self.width(),
            out: self.control >> 6 & 3 == 1,
        }
    }

    /// The memory it works on: first byte and size.
    pub fn buffer(&self) -> (u32, u32) {
        (self.memory[0], self.left * self.width())
    }

    /// All memory that it may work on until it is set up anew.
    pub fn whole_buffer(&self) -> (u32, u32) {
        (self.memory[0], self.reload.max(self.left) * self.width())
    }

    /// What was read ahead.
    pub fn take_ahead(&mut self) -> Option<u32> {
        self.ahead.take()
    }

    /// Holds what is read ahead.
    pub fn set_ahead(&mut self, value: u32) {
        self.ahead = Some(value);
    }

    /// The address that is read ahead next; `None` when the stream has ended.
    pub fn next_ahead(&self) -> Option<Transfer> {
        (self.is_on() && self.control >> 6 & 3 == 1).then(|| self.transfer())
    }

    /// Counts a transfer; true if it was the last, of a round where it is circular.
    pub fn count(&mut self) -> bool {
        self.left -= 1;
        // Half of an odd number is rounded down.
        if self.reload - self.left == self.reload / 2 {
            self.flags |= HALF;
        }
        if self.left == 0 {
            self.flags |= FULL;
            if self.control & bit::CIRC == 0 {
                self.control &= !bit::EN;
            } else {
                self.left = self.reload;
            }
            return true;
        }
        false
    }

    /// An access on the bus failed: the stream notes an error and stops.
    pub fn fail(&mut self) {
        self.flags |= TRANSFER_ERROR;
        self.control &= !bit::EN;
    }

    /// Whether the interrupt's line is high.
    pub fn interrupts(&self) -> bool {
        [
            (bit::TCIE, FULL),
            (bit::HTIE, HALF),
            (bit::TEIE, TRANSFER_ERROR),
        ]
        .iter()
        .any(|(enable, flag)| self.control & enable != 0 && self.flags & flag != 0)
    }

    /// Priority: 0 low to 3 very high.
    pub fn priority(&self) -> u32 {
        self.control >> 16 & 3
    }
}

/// A DMA controller: DMA1 or DMA2.
#[derive(Clone, Debug)]
pub struct Dma {
    /// Whether its clock is on: without it no request is served.
    pub clocked: bool,
    number: usize,
    /// The streams by number.
    pub streams: [Stream; 8],
}

impl Dma {
    /// DMA1 or DMA2 after a reset.
    pub fn new(number: usize) -> Self {
        let stream = Stream {
            fifo: 0x21,
            ..Stream::default()
        };
        Self {
            clocked: false,
            number,
            streams: std::array::from_fn(|_| stream.clone()),
        }
    }

    /// The stream that serves a request now.
    pub fn serves(&self, request: Request) -> Option<usize> {
        if !self.clocked {
            return None;
        }
        let routes = Request::ROUTES
            .iter()
            .filter(|r| r.0 == request && r.1 == self.number);
        let on = routes.filter(|r| self.streams[r.2].is_on() && self.streams[r.2].channel() == r.3);
        on.map(|r| r.2).next()
    }

    fn flags(&self, first: usize) -> u32 {
        [0, 6, 16, 22]
            .iter()
            .zip(first..)
            .fold(0, |all, (shift, i)| all | self.streams[i].flags << shift)
    }

    /// Reads the register at `offset`: of the flags, or of a stream.
    pub fn read(&self, offset: u32) -> Access<u32> {
        match offset {
            0 => return Ok(self.flags(0)),
            4 => return Ok(self.flags(4)),
            8 | 12 => return Ok(0),
            _ => {}
        }
        let stream = self.streams.get((offset as usize - 0x10) / 0x18);
        let stream = stream.ok_or("is not modelled")?;
        Ok(match (offset - 0x10) % 0x18 {
            0x00 => stream.control,
            0x04 => stream.left,
            0x08 => stream.peripheral,
            0x0c => stream.memory[0],
            0x10 => stream.memory[1],
            _ => stream.fifo,
        })
    }

    /// Writes; the number of a stream that begins is given back.
    pub fn write(&mut self, w: Write) -> Access<Option<usize>> {
        match w.offset {
            8 | 12 => {
                let first = if w.offset == 8 { 0 } else { 4 };
                let ones = w.over(0, 0x0f7d_0f7d)?;
                for (shift, i) in [0, 6, 16, 22].into_iter().zip(first..) {
                    self.streams[i].flags &= !(ones >> shift & 0x3d);
                }
                return Ok(None);
            }
            0 | 4 => return Err("is read-only".into()),
            _ => {}
        }
        let index = (w.offset as usize - 0x10) / 0x18;
        let number = self.number;
        let stream = self.streams.get_mut(index).ok_or("is not modelled")?;
        let register = (w.offset - 0x10) % 0x18;
        if stream.is_on() && register != 0 {
            return Err(format!(
                "a register of stream {index} is written while it runs (9.3.18)"
            ));
        }
        match register {
            0x00 => return begin(stream, number, index, w),
            0x04 => {
                stream.left = w.over(stream.left, 0xffff)?;
                stream.reload = stream.left;
            }
            0x08 => stream.peripheral = w.over(stream.peripheral, u32::MAX)?,
            0x0c => stream.memory[0] = w.over(stream.memory[0], u32::MAX)?,
            0x10 => stream.memory[1] = w.over(stream.memory[1], u32::MAX)?,
            _ => {
                stream.fifo = w.over(stream.fifo, 0xbf)?;
                if stream.fifo & 0x84 != 0 {
                    return Err("FIFO mode is not modelled".into());
                }
            }
        }
        Ok(None)
    }
}

fn begin(stream: &mut Stream, number: usize, index: usize, w: Write) -> Access<Option<usize>> {
    let new = w.over(stream.control, 0x0fef_ffff)?;
    if stream.is_on() && new & bit::EN != 0 && (new ^ stream.control) & !0x1e != 0 {
        return Err(format!("stream {index} is changed while it runs (9.5.5)"));
    }
    let begins = new & bit::EN != 0 && !stream.is_on();
    if stream.is_on() && new & bit::EN == 0 {
        // Switched off by the program: what was transferred is complete.
        stream.flags |= FULL;
    }
    stream.control = new;
    if !begins {
        return Ok(None);
    }
    if new & (bit::PINC | 0x01e4_8020) != 0 || new >> 6 & 3 > 1 {
        return Err(format!(
            "stream {index}: {new:#010x} asks for what is not modelled"
        ));
    }
    if new >> 11 & 3 != new >> 13 & 3 {
        return Err(format!(
            "stream {index}: widths differ, which direct mode has not (9.3.10)"
        ));
    }
    if stream.left == 0 {
        return Err(format!("stream {index} begins with nothing to transfer"));
    }
    if stream.flags != 0 {
        return Err(format!(
            "stream {index} begins with flags {:#x} set (9.3.18)",
            stream.flags
        ));
    }
    let channel = stream.channel();
    let served = Request::ROUTES
        .iter()
        .any(|r| (r.1, r.2, r.3) == (number, index, channel));
    if !served {
        return Err(format!(
            "DMA{number} stream {index} channel {channel}: no request comes there"
        ));
    }
    stream.reload = stream.left;
    stream.ahead = None;
    Ok(Some(index))
}
