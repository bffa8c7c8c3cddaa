"""Boots the NUCLEO-G474RE's image in Unicorn, and says what it wrote to which register, in order.

    python -m venv VENV; VENV/bin/pip install unicorn==2.1.4
    VENV/bin/python tests/board/oracle/boot_g474.py target/thumb/thumbv7em-none-eabihf/firmware/g474 [--all]

The registers are no model of the part: they keep what is written, and a few say that they are ready (`READY`). Accesses
outside the peripherals' addresses end the run. It shows that the start runs to its end, which values the registers then have
(held here against the table `EXPECTED`, written from the reference manual and not from the program), that each of the five
interrupts can be served some hundreds of times, that the link answers, that settings can be saved and are found after a
reset, that a start is refused because of Fault 18, and that PA8 stays low. Interrupts are called one by one; there
are no priorities and no time. Flash takes what the manual allows: unlocked, page erased, whole words of 8 bytes. Unicorn is under the GPL and is not part of this project: it is asked, not linked.
"""

import struct
import sys
import zlib

from unicorn import UC_ARCH_ARM, UC_HOOK_MEM_INVALID, UC_HOOK_MEM_WRITE, UC_MODE_MCLASS, UC_MODE_THUMB, Uc
from unicorn.arm_const import UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_SP, UC_ARM_REG_XPSR, UC_CPU_ARM_CORTEX_M4

RCC, PWR, FLASH, PORT_A, PORT_B, PORT_C = 0x40021000, 0x40007000, 0x40022000, 0x48000000, 0x48000400, 0x48000800
ADC, ADC_COMMON, DAC, DMA, MUX = 0x50000000, 0x50000300, 0x50000800, 0x40020000, 0x40020800
TIM2, TIM3, TIM6, TIM7, USART, EXTI, SYSCFG, WATCHDOG = (
    0x40000000, 0x40000400, 0x40001000, 0x40001400, 0x40004400, 0x40010400, 0x40010000, 0x40003000)
SCS, SLOTS = 0xE000E000, 0x0807F000

# Control, link, guard, chain, supply.
INTERRUPTS = {11, 54, 55, 23, 1}
# Values after a reset that are not 0 and matter here.
RESET = {PORT_A: 0xABFFFFFF, PORT_B: 0xFFFFFEBF, PORT_C: 0xFFFFFFFF, RCC: 0x00000500, RCC + 8: 5, RCC + 0xC: 0x1000,
         FLASH: 0x00040601, FLASH + 0x14: 0xC0000000, FLASH + 0x20: 0xFFEFF8AA, PWR: 0x200, PWR + 0x80: 0x100,
         ADC + 8: 0x20000000, ADC + 0xC: 0x80000000, RCC + 0x94: 0x0C000000}
# name: register, value after the start, mask.
EXPECTED = {
    "PA8 is an output": (PORT_A, 1 << 16, 3 << 16),
    "PA0, PA1, PA4 are analogue": (PORT_A, 0x30F, 0x30F),
    "PA2, PA3 are USART2's (AF7)": (PORT_A + 0x20, 0x7700, 0xFF00),
    "PA2, PA3 are alternate": (PORT_A, 0xA0, 0xF0),
    "PA5 is an output": (PORT_A, 1 << 10, 3 << 10),
    "PA9, PA10 are inputs": (PORT_A, 0, 0xF << 18),
    "PA9, PA10 are pulled up": (PORT_A + 0xC, 5 << 18, 0xF << 18),
    "PB0 is analogue, PB5 and PB10 inputs": (PORT_B, 3, 3 | 3 << 10 | 3 << 20),
    "PB5, PB10 are pulled up, PB0 is free": (PORT_B + 0xC, 1 << 10 | 1 << 20, 3 | 3 << 10 | 3 << 20),
    "PC7 is TIM3's (AF2)": (PORT_C + 0x20, 2 << 28, 0xF << 28),
    "PC7 is alternate, PC13 an input": (PORT_C, 2 << 14, 3 << 14 | 3 << 26),
    "crystal, PLL and clock security on": (RCC, 1 << 16 | 1 << 24 | 1 << 19, 1 << 16 | 1 << 24 | 1 << 19),
    "PLL: crystal / 6 * 85 / 2, output R": (RCC + 0xC, 3 | 5 << 4 | 85 << 8 | 1 << 24, 0x7F0000 | 3 | 15 << 4 | 127 << 8 | 1 << 24 | 3 << 25),
    "system clock from the PLL, no bus divided": (RCC + 8, 3, 0x3FF3),
    "boost mode": (PWR + 0x80, 0, 1 << 8),
    "4 wait states, prefetch, both caches": (FLASH, 4 | 7 << 8, 15 | 7 << 8),
    "supply's detector at level 6": (PWR + 4, 1 | 6 << 1, 15),
    "ADC on, waiting for its trigger": (ADC + 8, 1 << 28 | 1 << 2 | 1, 0xA000_0000 | 1 << 28 | 1 << 2 | 1),
    "ADC: TIM2_TRGO's rise, circular DMA, 12 bits": (ADC + 0xC, 1 << 10 | 11 << 5 | 3, 0x7FFF_FFFF),
    "ADC: three inputs, 1, 2, 15": (ADC + 0x30, 2 | 1 << 6 | 2 << 12 | 15 << 18, 0xFFFFFFFF),
    "ADC: the reference is injected": (ADC + 0x4C, 18 << 9, 0xFFFFFFFF),
    "ADC: sampling of 1 and 2": (ADC + 0x14, 5 << 3 | 5 << 6, 0xFFFFFFFF),
    "ADC: sampling of 15 and 18": (ADC + 0x18, 5 << 15 | 7 << 24, 0xFFFFFFFF),
    "ADC's clock is the bus's / 4, reference on": (ADC_COMMON + 8, 3 << 16 | 1 << 22, 0xFFFFFFFF),
    "DAC: above 160 MHz, buffered": (DAC + 0x3C, 2 << 14, 0xC007),
    "DAC on, untriggered": (DAC, 1, 0xFFFF),
    "DAC in the middle": (DAC + 8, 2048, 0xFFF),
    "request of channel 1: ADC1": (MUX, 5, 0x7F), "of 2: TIM2_UP": (MUX + 4, 60, 0x7F),
    "of 3: USART2_RX": (MUX + 8, 26, 0x7F), "of 4: USART2_TX": (MUX + 12, 27, 0x7F),
    "channel 1: from the ADC, ring of half words": (DMA + 8, 0x35AF, 0xFFFF),
    "channel 1: 60 samples from the ADC's data": (DMA + 0x10, ADC + 0x40, 0xFFFFFFFF),
    "channel 2: to the DAC, half words widened": (DMA + 0x1C, 0x36B1, 0xFFFF),
    "channel 2: to the DAC's register": (DMA + 0x24, DAC + 8, 0xFFFFFFFF),
    "channel 3: from the wire, ring of bytes": (DMA + 0x30, 0x10A1, 0xFFFF),
    "channel 3: from USART2's data": (DMA + 0x38, USART + 0x24, 0xFFFFFFFF),
    "channel 4: to USART2's data": (DMA + 0x4C, USART + 0x28, 0xFFFFFFFF),
    "TIM2: 20 kHz": (TIM2 + 0x2C, 8499, 0xFFFFFFFF), "TIM2's update is its output": (TIM2 + 4, 0x20, 0x70),
    "TIM2's update asks for DMA, and no interrupt": (TIM2 + 0xC, 0x100, 0xFFFF), "TIM2 counts": (TIM2, 1, 1),
    "TIM3: 5 kHz": (TIM3 + 0x2C, 33999, 0xFFFFFFFF), "TIM3's output is 0": (TIM3 + 0x38, 0, 0xFFFFFFFF),
    "TIM3: PWM mode 1 on channel 2, preloaded": (TIM3 + 0x18, 0x6800, 0xFFFF), "TIM3 counts": (TIM3, 0x81, 0x81),
    "TIM6: 1 kHz": (TIM6 + 0x28, 169, 0xFFFF), "TIM6 reload": (TIM6 + 0x2C, 999, 0xFFFFFFFF), "TIM6 counts": (TIM6, 1, 1),
    "TIM7: 1 kHz": (TIM7 + 0x28, 169, 0xFFFF), "TIM7 reload": (TIM7 + 0x2C, 999, 0xFFFFFFFF), "TIM7 counts": (TIM7, 1, 1),
    "USART2: 2.25 Mbaud": (USART + 0xC, 76, 0xFFFF), "USART2 on, both ways": (USART, 0xD, 0xFFFFFFFF),
    "USART2's DMA, both ways": (USART + 8, 0xC0, 0xFFFFFFFF),
    "EXTI5 is port B": (SYSCFG + 0xC, 1 << 4, 15 << 4),
    "EXTI: 5 and 16 rise": (EXTI + 8, 1 << 5 | 1 << 16, 0xFFFFFFFF), "16 falls": (EXTI + 0xC, 1 << 16, 0xFFFFFFFF),
    "watchdog: 32 kHz / 32": (WATCHDOG + 4, 3, 7), "watchdog: 2 s": (WATCHDOG + 8, 1999, 0xFFF),
}


class Board:
    """Memory, registers that keep what is written, and the image."""

    def __init__(self, path, slots=b"\xff" * 0x1000):
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M4)
        self.regs, self.trace, self.enabled, self.pended, self.high = dict(RESET), [], set(), set(), 0
        self.keys, self.half, self.erased, self.sent, self.turns, self.fed, self.reset = [], None, 0, b"", 0, 0, False
        for base, size in ((0x08000000, 0x80000), (0x20000000, 0x18000), (0x1FFF7000, 0x1000)):
            self.uc.mem_map(base, size)
        self.uc.mem_write(0x08000000, b"\xff" * 0x80000)
        self.uc.mem_write(SLOTS, slots)
        self.uc.mem_write(0x1FFF75AA, struct.pack("<H", 1654))  # 1.212 V of 3.0 V
        data = open(path, "rb").read()
        (header,), (number,) = struct.unpack_from("<I", data, 28), struct.unpack_from("<H", data, 44)
        for i in range(number):
            kind, offset, _, address, size = struct.unpack_from("<5I", data, header + 32 * i)
            if kind == 1 and size:
                self.uc.mem_write(address, data[offset:offset + size])
        for base, size in ((0x40000000, 0x30000), (0x48000000, 0x2000), (0x50000000, 0x2000), (0xE0000000, 0x100000)):
            self.uc.mmio_map(base, size, self.read, base, self.write, base)
        self.uc.hook_add(UC_HOOK_MEM_INVALID, self.invalid)
        self.uc.hook_add(UC_HOOK_MEM_WRITE, self.program, begin=0x08000000, end=0x0807FFFF)

    def invalid(self, uc, access, address, size, value, _):
        raise SystemExit(f"an access to {address:#010x} at {uc.reg_read(UC_ARM_REG_PC):#010x}")

    def program(self, uc, access, address, size, value, _):
        """A store to the flash: the first or second half of a word of 8 bytes."""
        control, before = self.regs[FLASH + 0x14], uc.mem_read(address & ~7, 8)
        first = address % 8 == 0
        good = size == 4 and address >= SLOTS and not control >> 31 and control & 1
        good &= self.half is None if first else self.half is not None and self.half[0] == address - 4
        if first:
            self.half = (address, value, bytes(before))
        elif good:
            _, low, before = self.half
            good = before == b"\xff" * 8 or low == value == 0
            self.half = None
        if not good:
            raise SystemExit(f"a store to flash at {address:#010x} that it does not take")

    def word(self, address):
        kept = self.regs.get(address, 0)
        if address == RCC:  # HSE and PLL are ready when they are on.
            return kept | (kept >> 16 & 1) << 17 | (kept >> 24 & 1) << 25
        if address == RCC + 8:
            return kept & ~0xC | (kept & 3) << 2
        if address == ADC:  # Ready when on; an injected conversion has always ended.
            return kept & ~0x21 | (self.regs[ADC + 8] & 1) | 0x20
        if address == ADC + 0x80:
            return 1504
        if address in (PORT_A + 0x10, PORT_B + 0x10, PORT_C + 0x10):  # Nothing wired: pins follow their pulls.
            pulls = self.regs.get(address - 4, 0)
            return sum((pulls >> 2 * pin & 3 == 1) << pin for pin in range(16))
        return kept

    def read(self, uc, offset, size, base):
        address = base + offset
        return self.word(address & ~3) >> 8 * (address & 3) & ((1 << 8 * size) - 1)

    def write(self, uc, offset, size, value, base):
        address, word = base + offset, (base + offset) & ~3
        shift = 8 * (address & 3)
        mask = (1 << 8 * size) - 1 << shift
        new = self.regs.get(word, 0) & ~mask | value << shift & mask
        self.trace.append((address, value, size))
        if word in (PORT_A + 0x18, PORT_B + 0x18, PORT_C + 0x18):
            self.high |= (new >> 8 & 1) if word == PORT_A + 0x18 else 0
            return
        if word == PORT_A + 0x14:
            self.high |= new >> 8 & 1
        if SCS + 0x100 <= word < SCS + 0x120:
            self.enabled |= {32 * (word - SCS - 0x100 >> 2) + bit for bit in range(32) if new >> bit & 1}
            return
        if SCS + 0x200 <= word < SCS + 0x220:
            self.pended |= {32 * (word - SCS - 0x200 >> 2) + bit for bit in range(32) if new >> bit & 1}
            return
        if word == SCS + 0xD0C and new & 4:
            self.reset = True
            uc.emu_stop()
        if word == FLASH + 8:
            self.keys = (self.keys + [new])[-2:]
            if self.keys == [0x45670123, 0xCDEF89AB]:
                self.regs[FLASH + 0x14] &= ~(1 << 31)
            return
        if word == FLASH + 0x14:
            if self.regs[word] >> 31:
                return
            if new >> 16 & 1 and new & 2:
                if not new >> 11 & 1 or new >> 3 & 127 not in (126, 127):
                    raise SystemExit(f"a page is erased that is not the settings': {new:#x}")
                self.uc.mem_write(SLOTS + 0x800 * ((new >> 3 & 127) - 126), b"\xff" * 0x800)
                self.erased += 1
                new &= ~(1 << 16)
        if word == DMA + 0x44 and new & 1:
            self.sent += bytes(self.uc.mem_read(self.regs[DMA + 0x50], self.regs[DMA + 0x48]))
        if word == ADC + 8:  # Bits that start something are set by ones and cleared by the hardware alone.
            new = new & 0xF0000000 & ~(1 << 31) | (self.regs[word] | new) & 5
        if word in (ADC, DMA + 4, EXTI + 0x14, USART + 0x20, FLASH + 0x10):  # Ones clear.
            return
        if word == WATCHDOG and new == 0xAAAA:
            self.fed += 1
        self.regs[word] = new

    def start(self, instructions=3_000_000):
        stack, entry = struct.unpack("<2I", self.uc.mem_read(0x08000000, 8))
        self.uc.reg_write(UC_ARM_REG_SP, stack)
        # In one go, well into the idle loop: a run that was cut within an IT block would go on wrongly.
        self.uc.emu_start(entry | 1, 0, count=instructions)
        if not (self.regs.get(TIM7, 0) & 1 and self.enabled >= INTERRUPTS):
            raise SystemExit(f"the start does not end; it is at {self.uc.reg_read(UC_ARM_REG_PC):#010x}")

    def serve(self, interrupt, flags=0):
        """Calls an interrupt's function as one calls a function, and what it asks for after it."""
        self.regs[DMA] = flags | 1 << 13  # What was sent is always out.
        vector, = struct.unpack("<I", self.uc.mem_read(0x08000000 + 4 * (16 + interrupt), 4))
        kept = self.uc.context_save()
        self.uc.reg_write(UC_ARM_REG_XPSR, 1 << 24)  # Outside any IT block, as after an exception's entry.
        self.uc.reg_write(UC_ARM_REG_LR, 0x08000001 + 0x7F000)
        self.uc.emu_start(vector | 1, 0x08000000 + 0x7F000, count=5_000_000)
        at = self.uc.reg_read(UC_ARM_REG_PC)
        if at != 0x0807F000 and not self.reset:
            raise SystemExit(f"interrupt {interrupt} does not end; it is at {at:#010x}")
        self.uc.context_restore(kept)

    def block(self):
        left = 30 if self.turns % 2 == 0 else 60
        self.uc.mem_write(self.regs[DMA + 0x14], struct.pack("<3H", 600, 2048, 2048) * 20)
        self.regs[DMA + 0xC], self.regs[DMA + 0x20] = left, left // 3
        self.serve(11, 4 if self.turns % 2 == 0 else 2)
        self.turns += 1

    def millisecond(self):
        self.block()
        self.block()
        self.serve(55)
        self.serve(54)
        for line in sorted(self.pended & {52, 53}):
            self.pended.discard(line)
            self.serve(line)

    def ask(self, number, message):
        """Sends a request over the wire, and returns the answer's bytes after its sequence numbers."""
        packet = varint(number) + message
        packet += struct.pack("<I", zlib.crc32(packet))
        for byte in cobs(packet):
            at = (1024 - self.regs[DMA + 0x34]) % 1024
            self.uc.mem_write(self.regs[DMA + 0x3C] + at, bytes([byte]))
            self.regs[DMA + 0x34] = (1024 - (at + 1) % 1024) % 1024 or 1024
        self.sent = b""
        for _ in range(20):
            self.millisecond()
            if b"\0" in self.sent:
                frame = uncobs(self.sent[:self.sent.index(0)])
                body, check = frame[:-4], struct.unpack("<I", frame[-4:])[0]
                if check != zlib.crc32(body):
                    raise SystemExit("a frame whose check is wrong")
                _, rest = unvarint(body)
                request, answer = unvarint(rest[1:])
                if rest[0] != 0 or request != number:
                    raise SystemExit("an answer to something else")
                return answer
        raise SystemExit("no answer")

    def slots(self):
        return bytes(self.uc.mem_read(SLOTS, 0x1000))


def varint(value):
    out = b""
    while value > 127:
        out, value = out + bytes([value & 127 | 128]), value >> 7
    return out + bytes([value])


def unvarint(data):
    value = shift = at = 0
    while True:
        value, at, more = value | (data[at] & 127) << shift, at + 1, data[at] >> 7
        shift += 7
        if not more:
            return value, data[at:]


def cobs(data):
    out = b""
    for part in data.split(b"\0"):
        while len(part) >= 254:
            out, part = out + b"\xff" + part[:254], part[254:]
        out += bytes([len(part) + 1]) + part
    return out + b"\0"


def uncobs(data):
    out, at = b"", 0
    while at < len(data):
        code = data[at]
        out, at = out + data[at + 1:at + code], at + code
        if code < 255 and at < len(data):
            out += b"\0"
    return out


# Requests, acts and answers by their number (shared/src/link/message.rs).
HELLO, SETTINGS, FAULT, BOARD, OPEN, STEER = (bytes([n]) for n in (0, 3, 7, 9, 10, 11))
COMMAND, SET, START, CLEAR = b"\0", b"\1", b"\0\0", b"\2"
DONE, REFUSED = 1, 2


def session(board, number):
    """Opens a session: its number."""
    answer = board.ask(number, BOARD)
    boot, rest = unvarint(answer[1:])
    granted, _ = unvarint(rest)
    answer = board.ask(number + 1, OPEN + varint(boot) + varint(granted) + b"\0")
    return unvarint(answer[1:])[0]


def fault(board, number):
    """The fault's place in the list, and its value."""
    answer = board.ask(number, FAULT)
    at, rest = unvarint(answer[2:])
    _, rest = unvarint(rest)
    _, rest = unvarint(rest)
    return at, struct.unpack_from("<f", rest)[0]


def link(board, path):
    """Over the wire: who it is, why it does not drive, settings saved and found again."""
    checks = {"the link answers with the board's name": b"NUCLEO-G474RE" in board.ask(1, HELLO)}
    steer, settings, acts = session(board, 2), bytearray(board.ask(4, SETTINGS)[1:]), 0
    images = []
    for turn in range(3):
        settings[1] ^= turn  # The mass's last digit.
        acts += 1
        answer = board.ask(10 + turn, STEER + varint(steer) + varint(acts) + SET + bytes(settings))
        images.append((answer[0], board.slots()))
    checks["settings are saved three times, the third over the first"] = (
        [answer for answer, _ in images] == [DONE] * 3 and board.erased >= 1
        and images[0][1][:4] == images[1][1][0x800:0x804] == b"VIHS" and images[1][1][:0x800] != images[2][1][:0x800])
    again = Board(path, board.slots())
    again.start()
    for _ in range(20):
        again.millisecond()
    checks["after a reset they are those in use"] = bytes(settings) == again.ask(1, SETTINGS)[1:]
    checks["then it is in Fault 18, and the only reason is 16"] = fault(again, 2) == (17, 16.0)
    steer = session(again, 3)
    refused = [again.ask(5 + i, STEER + varint(steer) + varint(i + 1) + COMMAND + act)[0] for i, act in enumerate((CLEAR, START))]
    checks["clearing it and starting are refused"] = refused == [REFUSED] * 2
    checks["PA8 was not raised by that"] = not again.high and not board.high
    return checks


def nmi(path):
    """A damaged word among the settings is taken note of; anywhere else, and a dead clock, the outputs are made safe."""
    checks = {}
    for name, damage, clock, resets in (
            ("a damaged word of the settings is taken note of", 1 << 31 | 1 << 21 | 0x3F008, 0, False),
            ("a damaged word of the program ends it with a reset", 1 << 31 | 0x1008, 0, True),
            ("a dead clock ends it with a reset", 0, 1 << 8, True)):
        board = Board(path)
        board.start()
        board.regs[FLASH + 0x18], board.regs[RCC + 0x1C], board.regs[DAC + 8] = damage, clock, 1
        begun = len(board.trace)
        board.serve(-14)
        lowered = (PORT_A + 0x18, 1 << 24) == board.trace[begun][:2]
        safe = lowered and board.regs[DAC + 8] == 2048 and not board.regs[DMA + 0x1C] & 1
        checks[name] = board.reset == resets and (safe or not resets)
    return checks


def main():
    board = Board(sys.argv[1])
    board.start()
    if "--all" in sys.argv:
        for address, value, size in board.trace:
            if address < 0xE0000000:
                print(f"{address:#010x} = {value:#x} ({size})")
    wrong = 0
    for name, (register, value, mask) in EXPECTED.items():
        found = board.regs.get(register, 0)
        if (found ^ value) & mask:
            wrong += 1
            print(f"WRONG   {name}: {register:#010x} is {found:#010x}, {value:#x} under {mask:#x} wanted")
    first = next(i for i, (address, _, _) in enumerate(board.trace) if address in (PORT_A, PORT_A + 0x18))
    order = [a for a, _, _ in board.trace]
    checks = {
        "the enable is low before it is an output, and nothing but its clock before": order[first] == PORT_A + 0x18
        and all(a in (RCC + 0x4C, RCC + 0x94) or a >= 0xE0000000 for a in order[:first]),
        "the watchdog runs before the clock is touched": order.index(WATCHDOG) < min(order.index(RCC), order.index(PWR + 0x80)),
        "boost and wait states come before the PLL's clock": order.index(PWR + 0x80) < order.index(RCC + 0xC)
        and order.index(FLASH) < order.index(RCC + 0xC),
        "samples begin after all but the guard": order.index(TIM2) > max(order.index(TIM6), order.index(USART), order.index(TIM3)),
        "the interrupts of control, link, guard, chain and supply are on": board.enabled >= INTERRUPTS,
    }
    turns, driven = 400, len(board.trace)
    for _ in range(turns // 2):
        board.millisecond()
    board.serve(23)
    board.serve(1)
    writes = board.trace[driven:]
    led = sum(1 for address, _, _ in writes if address == PORT_A + 0x18)
    checks[f"{turns} blocks and {turns // 2} ms are served, the LED is set and the watchdog fed"] = led > 10 and board.fed > 3
    checks["PA8 was never raised, and is an output at the end"] = not board.high and board.regs[PORT_A] >> 16 & 3 == 1
    checks.update(link(board, sys.argv[1]))
    checks.update(nmi(sys.argv[1]))
    for name, good in checks.items():
        wrong += not good
        print("ok     " if good else "WRONG  ", name)
    print(f"{len(EXPECTED) + len(checks) - wrong} of {len(EXPECTED) + len(checks)} right; {driven} writes at the start")
    sys.exit(wrong > 0)


main()
