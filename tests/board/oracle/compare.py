"""Compares the model's processor with Unicorn's Cortex-M4, an instruction at a time, from random states.

    cargo xtask board --oracle [STATES]

gets Unicorn and runs this: compare.py ONE-INSTRUCTION ELF [STATES [SEED]]. The instructions are those of the ELF, each in so many
states. Unicorn is under the GPL and is not part of this project: it is asked, not linked.
"""

import random
import struct
import subprocess
import sys

from unicorn import UC_ARCH_ARM, UC_MODE_MCLASS, UC_MODE_THUMB, UC_PROT_EXEC, UC_PROT_READ, Uc, UcError
from unicorn.arm_const import *

FLASH, RAM, SIZE = 0x08000000, 0x20000000, 0x20000
AT = FLASH + 0x200
PATTERN = bytes((i * 37 + 11) & 0xFF for i in range(SIZE))
REGS = [getattr(__import__("unicorn.arm_const", fromlist=["x"]), f"UC_ARM_REG_{n}")
        for n in [f"R{i}" for i in range(13)] + ["SP", "LR"]]
# Its place in an answer: after r0 to pc, the status, and s0 to s31.
FPSCR = 49
SINGLES = [getattr(__import__("unicorn.arm_const", fromlist=["x"]), f"UC_ARM_REG_S{i}") for i in range(32)]
ODD = [0, 1, 2, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF]
ODD_SINGLES = [0, 0x80000000, 0x3F800000, 0xBF800000, 0x7F800000, 0xFF800000, 0x7FC00001, 0x7F800001, 1, 0x00800000,
               0x4F000000, 0xCF000000, 0x4F800000, 0x7F7FFFFF, 0x3F000000, 0x3FC00000]


def instructions(path):
    """The distinct instructions of the code in an ELF file."""
    data = open(path, "rb").read()
    phoff, = struct.unpack_from("<I", data, 28)
    number, = struct.unpack_from("<H", data, 44)
    found = set()
    for i in range(number):
        kind, offset, _, address, size, _, flags, _ = struct.unpack_from("<8I", data, phoff + 32 * i)
        if kind == 1 and flags & 1 and size:
            code, at = data[offset:offset + size], 0
            while at + 4 <= len(code):
                first, second = struct.unpack_from("<2H", code, at)
                wide = first >> 11 >= 0b11101
                found.add((first, second if wide else 0xBF00))
                at += 4 if wide else 2
    return sorted(found)


def skipped(first, second):
    """What differs for reasons that are known: exceptions, hints, special registers, exclusives, and IT alone."""
    if first >> 11 < 0b11101:
        return (first >> 8 in (0xBE, 0xBF, 0xDF, 0xDE) or first & 0xFFE8 == 0xB660 or first >> 8 == 0x47
                or first & 0xFD87 == 0x4487)
    if first & 0xFF80 == 0xF380 and second & 0xD000 == 0x8000:
        return True
    if first & 0xFFE0 == 0xE840 or first & 0xFFE0 == 0xE8C0 and second & 0xF0 not in (0x00, 0x10):
        return True
    return first & 0xEF00 == 0xEE00 and second & 0x0F10 == 0x0A10 and first & 0xE0 == 0xE0


def in_block(rng, first, second):
    """In one case of four an IT for this instruction, where it may stand behind one; else 0."""
    barred = (first >> 12 == 0xD or first >> 8 in (0xB1, 0xB3, 0xB9, 0xBB) or first >> 8 == 0xB6
              or first >> 11 == 0b11110 and second & 0xD000 == 0x8000)
    return 0 if barred or rng.randrange(4) else 0xBF08 | rng.randrange(14) << 4


def is_odd(address):
    """Unicorn has neither bit-band nor peripherals, and faults at a store to flash, of which the part only notes an error."""
    return (0x07F00000 <= address < 0x08100000 or 0x21F00000 <= address < 0x24100000
            or 0x3FF00000 <= address < 0x50100000 or 0xDFF00000 <= address < 0xE0200000)


def sum_of_two(first, second, regs):
    """The address of a load, a store or a table branch that adds two registers; 0 for any other. Behind an IT a table branch's is two
    more, which makes none odd that is not."""
    if first >> 12 == 5:
        return regs[first >> 3 & 7] + regs[first >> 6 & 7] & 0xFFFFFFFF
    if first >> 9 == 0x7C and second & 0xFC0 == 0 and max(first & 15, second & 15) < 15:
        return regs[first & 15] + (regs[second & 15] << (second >> 4 & 3)) & 0xFFFFFFFF
    if first >> 4 == 0xE8D and second & 0xE0 == 0 and second & 15 < 15:
        return (regs + [AT + 4])[first & 15] + (regs[second & 15] << (second >> 4 & 1)) & 0xFFFFFFFF
    return 0


def suitable(rng, first, second):
    """A state in which the instruction uses no odd address; none if a hundred draws have none: a constant between the instructions may
    read as one that adds two stack pointers."""
    for _ in range(100):
        found = state(rng)
        if not is_odd(sum_of_two(first, second, found[0])):
            return *found, in_block(rng, first, second)
    return None


def state(rng):
    def word():
        found = rng.choice([rng.choice(ODD), rng.getrandbits(32), RAM + 4 * rng.randrange(0x1000, 0x6000),
                            RAM + rng.randrange(0x4000, 0x18000)])
        return word() if is_odd(found) else found

    def single():
        return rng.choice([rng.choice(ODD_SINGLES), rng.getrandbits(32),
                           struct.unpack("<I", struct.pack("<f", rng.uniform(-1e3, 1e3)))[0]])
    regs = [word() for _ in range(13)] + [RAM + 4 * rng.randrange(0x2000, 0x4000), word() | 1]
    return regs, rng.getrandbits(32) & 0xF8000000, [single() for _ in range(32)], rng.getrandbits(4) << 28


def machine():
    uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
    uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M4)
    uc.mem_map(FLASH, 0x80000, UC_PROT_READ | UC_PROT_EXEC)
    uc.mem_map(0, 0x80000, UC_PROT_READ | UC_PROT_EXEC)
    uc.mem_map(RAM, SIZE)
    uc.mem_write(RAM, PATTERN)
    uc.reg_write(UC_ARM_REG_FPEXC, 0x40000000)
    return uc


def unicorn(uc, first, second, given):
    regs, status, singles, fpscr, block = given
    code = [block, first, second] if block else [first, second, 0xBF00]
    for place in (AT, AT - FLASH):
        uc.mem_write(place, struct.pack("<5H", *code, 0xBF00, 0xBF00))
    uc.ctl_remove_cache(AT, AT + 10)
    for register, value in zip(REGS, regs):
        uc.reg_write(register, value)
    uc.reg_write(UC_ARM_REG_XPSR, status | 1 << 24)
    for register, value in zip(SINGLES, singles):
        uc.reg_write(register, value)
    uc.reg_write(UC_ARM_REG_FPSCR, fpscr)
    try:
        if block:
            # An instruction whose condition fails is none that Unicorn counts.
            uc.emu_start(AT | 1, AT + (6 if first >> 11 >= 0b11101 else 4), count=2)
        else:
            uc.emu_start(AT | 1, FLASH + 0x70000, count=1)
    except UcError:
        uc.mem_write(RAM, PATTERN)
        return None
    out = [uc.reg_read(r) & 0xFFFFFFFF for r in REGS]
    out += [uc.reg_read(UC_ARM_REG_PC) & ~1, uc.reg_read(UC_ARM_REG_XPSR) & 0xF8000000]
    out += [uc.reg_read(r) for r in SINGLES] + [uc.reg_read(UC_ARM_REG_FPSCR) & 0xF0000000]
    memory = bytes(uc.mem_read(RAM, SIZE))
    changed = []
    if memory != PATTERN:
        changed = [f"{RAM + i:x}={b:x}" for i, b in enumerate(memory) if b != PATTERN[i]]
        uc.mem_write(RAM, PATTERN)
    return [f"{word:x}" for word in out] + changed


def main():
    program, elf = sys.argv[1:3]
    cases = int(sys.argv[3]) if len(sys.argv) > 3 else 3
    rng = random.Random(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
    code = [pair for pair in instructions(elf) if not skipped(*pair)]
    todo = [(pair, given) for pair in code for _ in range(cases) if (given := suitable(rng, *pair))]
    lines = []
    for (first, second), (regs, status, singles, fpscr, block) in todo:
        lines.append(" ".join(f"{w:x}" for w in [first, second, *regs, status, *singles, fpscr, block]))
    theirs = subprocess.run([program], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True)
    uc, different, faults, known, shown = machine(), 0, 0, 0, {}
    for (pair, given), answer in zip(todo, theirs.stdout.splitlines()):
        expected = unicorn(uc, *pair, given)
        said = answer.split(" ")
        if expected is None or said[0] != "ok":
            faults += 1
            if (expected is None) == (said[0] != "ok"):
                continue
            # Unicorn looks at the target of a branch at once, takes multiple transfers at any address, and executes some of
            # what the manual does not define, where the model stops (so it would stop a run of the image, too).
            outside = said[0] == "ok" and not FLASH <= int(said[16], 16) < FLASH + 0x80000
            if outside or said[1:] in (["Unaligned"], ["Undefined"]):
                known += 1
                continue
            expected = expected or ["fault"]
        ours = said[1:]
        if ours == expected:
            continue
        # Now and then Unicorn loses the flags of FPSCR, which a move does not touch.
        if expected[FPSCR:FPSCR + 1] == ["0"] and ours[:FPSCR] + ours[FPSCR + 1:] == expected[:FPSCR] + expected[FPSCR + 1:]:
            known += 1
        else:
            different += 1
            key = pair[0] >> 4
            if shown.setdefault(key, 0) < 2 and sum(shown.values()) < 40:
                shown[key] += 1
                names = [f"r{i}" for i in range(15)] + ["pc", "status"] + [f"s{i}" for i in range(32)] + ["fpscr"]
                parts = [f"{n}: {a} for {b}" for n, a, b in zip(names, said[1:], expected) if a != b]
                print(f"{pair[0]:04x} {pair[1]:04x}: {said[0]} {parts or (said[:3], expected[:1], said[50:], expected[49:])}")
    blocks = sum(1 for _, given in todo if given[4])
    print(f"{len(code)} instructions, {len(todo)} cases, {blocks} of them behind an IT, {faults} faults, {known} known differences, {different} differ")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
