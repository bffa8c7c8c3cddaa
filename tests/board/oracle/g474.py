"""The NUCLEO-G474RE's image in Unicorn: memory, registers that keep what is written, flash, and the link. For `boot_g474.py`."""

import random
import struct
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
class Board:
    """Memory, registers that keep what is written, and the image."""

    def __init__(self, path, slots=b"\xff" * 0x1000, cut=None, torn=False):
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        self.uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M4)
        self.regs, self.trace, self.enabled, self.pended, self.high = dict(RESET), [], set(), set(), 0
        self.keys, self.half, self.erased, self.sent, self.turns, self.fed, self.reset = [], None, 0, b"", 0, 0, False
        # After so many operations of the flash the power goes, with the next of them torn or not begun.
        self.cut, self.torn, self.operations, self.left = cut, torn, 0, None
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
            self.operate(address - SLOTS, 8)
        elif good:
            _, low, before = self.half
            good = before == b"\xff" * 8 or low == value == 0
            self.half = None
        if not good:
            raise SystemExit(f"a store to flash at {address:#010x} that it does not take")

    def operate(self, at, size):
        """An operation of the flash begins, on so many bytes. If it is the one at which the power goes, `left` is what is left
        in the flash: without it, or with its bytes anyhow."""
        if self.operations == self.cut:
            left = bytearray(self.slots())
            if self.torn:
                left[at:at + size] = random.Random(self.cut).randbytes(size)
            self.left = bytes(left)
            self.uc.emu_stop()
        self.operations += 1

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
                page = 0x800 * ((new >> 3 & 127) - 126)
                self.operate(page, 0x800)
                self.uc.mem_write(SLOTS + page, b"\xff" * 0x800)
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
        if at != 0x0807F000 and not self.reset and not self.left:
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
        if self.left:
            return
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
            if self.left:
                return b""
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
