//! USART2 (RM0390, chapter 25): asynchronous, 8 bits, no parity, one stop bit, by DMA or the data register. Not
//! modelled: everything else, noise, and the idle frame that TE sends first. At another rate than the other end's a byte
//! arrives as the bits at the receiver's own times, with a framing error where its stop bit is none; each byte by itself.

use std::collections::VecDeque;

use super::{Access, NEVER, Write};

const RXNE: u32 = 1 << 5;
const FE: u32 = 1 << 1;
const ORE: u32 = 1 << 3;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;

/// USART2 with its registers, and the bytes on their way.
#[derive(Clone, Debug)]
pub struct Usart {
    /// Whether its clock is on: without it nothing is sent or received.
    pub clocked: bool,
    status: u32,
    /// Errors that were read in the status, and not yet followed by the data.
    seen: u32,
    rate: u32,
    control: [u32; 3],
    received: u32,
    waiting: Option<u8>,
    shifting: Option<(u8, u64)>,
    /// Bytes on their way in, and when the next one is complete.
    incoming: VecDeque<u8>,
    incoming_at: u64,
    /// Bytes that went out.
    pub sent: Vec<u8>,
    /// Bytes that came in and were not read in time.
    pub lost: u32,
    /// Bits per second at the other end.
    pub far_baud: u64,
}

impl Usart {
    /// USART2 after a reset; the other end sends `far_baud` bits per second.
    pub fn new(far_baud: u64) -> Self {
        Self {
            clocked: false,
            status: TC | TXE,
            seen: 0,
            rate: 0,
            control: [0; 3],
            received: 0,
            waiting: None,
            shifting: None,
            incoming: VecDeque::new(),
            incoming_at: NEVER,
            sent: Vec::new(),
            lost: 0,
            far_baud,
        }
    }

    /// Units of time of a byte with start and stop bit.
    fn byte_time(&self, cycle: u32) -> u64 {
        let oversampled = if self.control[0] & 1 << 15 != 0 { 2 } else { 1 };
        10 * u64::from(self.rate) * u64::from(cycle) / oversampled
    }

    fn is_on(&self, bit: u32) -> bool {
        self.clocked && self.control[0] >> 13 & 1 == 1 && self.control[0] >> bit & 1 == 1
    }

    /// Whether it sends, and whether it receives.
    pub fn uses_pins(&self) -> (bool, bool) {
        (self.is_on(3), self.is_on(2))
    }

    /// The other end sends bytes from `now` on.
    pub fn arrive(&mut self, bytes: &[u8], now: u64) {
        let time = 10 * super::UNITS_PER_S / self.far_baud;
        if self.incoming.is_empty() && !bytes.is_empty() {
            self.incoming_at = now + time;
        }
        self.incoming.extend(bytes);
    }

    /// Whether it asks the DMA to take a byte, and to give one.
    pub fn requests(&self) -> (bool, bool) {
        let receive = self.status & RXNE != 0 && self.control[2] & 1 << 6 != 0;
        let send = self.status & TXE != 0 && self.control[2] & 1 << 7 != 0 && self.is_on(3);
        (receive, send)
    }

    /// When something changes by itself.
    pub fn next(&self) -> u64 {
        let shifting = self.shifting.filter(|_| self.clocked);
        self.incoming_at.min(shifting.map_or(NEVER, |(_, at)| at))
    }

    /// Goes on to `now`.
    pub fn run(&mut self, now: u64, cycle: u32) {
        if let Some((byte, at)) = self.shifting.filter(|(_, at)| self.clocked && *at <= now) {
            let far = 10 * super::UNITS_PER_S / self.far_baud;
            self.sent.push(heard(byte, self.byte_time(cycle), far).0);
            self.shifting = None;
            self.begin(at, cycle);
            if self.shifting.is_none() {
                self.status |= TC;
            }
        }
        if self.incoming_at <= now {
            let byte = self.incoming.pop_front().unwrap_or(0);
            let time = 10 * super::UNITS_PER_S / self.far_baud;
            self.incoming_at = if self.incoming.is_empty() {
                NEVER
            } else {
                self.incoming_at + time
            };
            if self.is_on(2) {
                self.receive(byte, cycle, time);
            }
        }
    }

    fn receive(&mut self, byte: u8, cycle: u32, time: u64) {
        if self.status & RXNE != 0 {
            self.lost += 1;
            self.status |= ORE;
            return;
        }
        let (byte, whole) = heard(byte, time, self.byte_time(cycle));
        self.received = u32::from(byte);
        self.status |= RXNE | if whole { 0 } else { FE };
    }

    fn begin(&mut self, now: u64, cycle: u32) {
        if self.shifting.is_none()
            && self.is_on(3)
            && let Some(byte) = self.waiting.take()
        {
            self.shifting = Some((byte, now + self.byte_time(cycle)));
            self.status |= TXE;
        }
    }

    /// Whether the interrupt's line is high.
    pub fn interrupts(&self) -> bool {
        self.status & self.control[0] & 0xe0 != 0
    }

    /// Reads the register at `offset`; that of the data clears RXNE, and those of the receiver's errors that were read in the
    /// status before (25.6.1): the DMA, which reads nothing but data, clears none.
    pub fn read(&mut self, offset: u32) -> Access<u32> {
        Ok(match offset {
            0x00 => {
                self.seen = self.status & (ORE | FE);
                self.status
            }
            0x04 => {
                self.status &= !(RXNE | self.seen);
                self.seen = 0;
                self.received
            }
            0x08 => self.rate,
            0x0c..=0x14 => self.control[offset as usize / 4 - 3],
            _ => return Err("is not modelled".into()),
        })
    }

    /// Writes; `cycle` is APB1's.
    pub fn write(&mut self, w: Write, cycle: u32) -> Access {
        match w.offset {
            0x00 => self.status &= w.value | !w.mask | !(RXNE | TC),
            0x04 => {
                if !self.is_on(3) {
                    return Err("USART2 is given a byte before it is switched on to send".into());
                }
                if self.waiting.is_some() {
                    return Err("USART2 is given a byte before the last one has left (TXE)".into());
                }
                self.waiting = Some(w.ones() as u8);
                self.status &= !(TXE | TC);
                self.begin(w.now, cycle);
            }
            0x08 => {
                self.rate = w.over(self.rate, 0xffff)?;
                if self.rate < 16 {
                    return Err(format!(
                        "USART2's divider {} is below 16 (25.4.4)",
                        self.rate
                    ));
                }
            }
            0x0c => {
                self.control[0] = w.over(self.control[0], 0xbfff)?;
                if self.control[0] & 0x1703 != 0 {
                    return Err("USART2: 9 bits, parity, break or mute are not modelled".into());
                }
            }
            0x10 => {
                self.control[1] = w.over(self.control[1], 0x7f6f)?;
                if self.control[1] != 0 {
                    return Err("USART2_CR2: not modelled".into());
                }
            }
            0x14 => {
                self.control[2] = w.over(self.control[2], 0xfff)?;
                if self.control[2] & !0xc1 != 0 {
                    return Err("USART2_CR3: only DMA is modelled".into());
                }
            }
            _ => return Err("is not modelled".into()),
        }
        Ok(())
    }
}

/// What is heard of a byte whose ten bits take `sent`, by one whose ten bits take `own`: the bits in the middle of its
/// own times, an eighth too late or too early at worst, and whether the last is a stop bit.
fn heard(byte: u8, sent: u64, own: u64) -> (u8, bool) {
    // Start bit, data from the lowest, stop bit, and the idle level after it.
    let wire = |i: u64| i > 8 || u64::from(byte) << 1 >> i & 1 == 1;
    let eighths = match own.cmp(&sent) {
        std::cmp::Ordering::Less => 3,
        std::cmp::Ordering::Equal => 4,
        std::cmp::Ordering::Greater => 5,
    };
    let at = |i: u64| wire((8 * i + eighths) * own / (8 * sent));
    let byte = (0..8).fold(0, |all, i| all | u8::from(at(i + 1)) << i);
    (byte, at(9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_takes_ten_bits_and_two_in_a_row_are_lost_unread() {
        let mut usart = Usart::new(2_250_000);
        usart.clocked = true;
        let write = |usart: &mut Usart, offset, value| {
            usart.write(
                Write {
                    offset,
                    value,
                    mask: !0,
                    now: 0,
                },
                16,
            )
        };
        write(&mut usart, 4, 1).unwrap_err();
        write(&mut usart, 8, 20).unwrap();
        write(&mut usart, 0x0c, 1 << 13 | 3 << 2).unwrap();
        write(&mut usart, 4, 0x55).unwrap();
        assert_eq!(usart.next(), 10 * 20 * 16);
        usart.run(3200, 16);
        assert_eq!(usart.sent, [0x55]);
        usart.arrive(&[1, 2], 3200);
        usart.run(6400, 16);
        usart.run(9600, 16);
        assert_eq!((usart.lost, usart.read(4)), (1, Ok(1)));
    }

    #[test]
    fn at_a_wrong_rate_other_bytes_are_heard() {
        assert_eq!(heard(0x5a, 3200, 3200), (0x5a, true));
        assert_eq!(heard(0x5a, 3200, 3300), (0x5a, true));
        assert_eq!(heard(0x5a, 3200, 3360), (0x9a, true));
        assert_eq!(heard(0, 3200, 3000), (0, false));
        // Twice as fast: each bit is heard twice, and the stop bit is a data bit.
        assert_eq!(heard(0x5a, 3200, 1600), (0b1001_1000, true));
        assert_eq!(heard(0, 3200, 1600), (0, false));
    }
}
