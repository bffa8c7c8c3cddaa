"""Compares the exceptions of the model's processor with those of QEMU's Cortex-M4, in random programs.

    cargo xtask board --oracle [STATES]

gets QEMU and runs this: exceptions.py ONE-PROGRAM QEMU [STATES [SEED]]. A program sets priorities, stacks and registers, and then
calls, pends, masks and faults, also from one handler within another. Each handler writes down what it finds: its number, the
value to return by, both stack pointers, masks, what is pending, and the frame; the program, what it has at its end.
"""

import random
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

FLASH, RAM = 0x08000000, 0x20000000
# Where the log goes on; how often handlers may still act; registers at the end; a word that is reserved; the tops of the stacks.
NEXT, BUDGET, ENDED, WORD, MAIN, PROCESS = RAM, RAM + 4, RAM + 0x10, RAM + 0x80, RAM + 0x2000, RAM + 0x3000
LOG, LOG_END = RAM + 0x4000, RAM + 0x1F000
# Programs in an image, and images for each of STATES.
SCENARIOS, IMAGES = 40, 5
ISER, ICER, ISPR, ICPR, IPR = 0xE000E100, 0xE000E180, 0xE000E200, 0xE000E280, 0xE000E400
ICSR, VTOR, AIRCR, SHPR, SHCSR = 0xE000ED04, 0xE000ED08, 0xE000ED0C, 0xE000ED18, 0xE000ED24
CFSR, HFSR, CPACR, FPCCR = 0xE000ED28, 0xE000ED2C, 0xE000ED88, 0xE000EF34
APSR, IPSR, MSP, PSP, PRIMASK, BASEPRI, FAULTMASK, CONTROL = 0, 5, 8, 9, 16, 17, 19, 20
FAULTS, SVC, PENDSV, SYSTICK, FIRST, INTERRUPTS = [3, 5, 6], 11, 14, 15, 16, 4
PENDED = [PENDSV, SYSTICK, *range(FIRST, FIRST + INTERRUPTS)]
LR = 14
CALL, UNDEFINED, ISB, CLREX = [0xDF00], [0xDE00], [0xF3BF, 0x8F6F], [0xF3BF, 0x8F2F]
MASK, UNMASK, MASK_FAULTS, UNMASK_FAULTS = [0xB672], [0xB662], [0xB671], [0xB661]


def word(register, value):
    """movw, movt."""
    def half(code, v):
        return [code | (v >> 11 & 1) << 10 | v >> 12, (v >> 8 & 7) << 12 | register << 8 | v & 0xFF]
    return half(0xF240, value & 0xFFFF) + half(0xF2C0, value >> 16)


def load(register, base, offset=0):
    return [0xF8D0 | base, register << 12 | offset]


def save(register, base, offset=0):
    return [0xF8C0 | base, register << 12 | offset]


def special(register, number):
    return [0xF3EF, 0x8000 | register << 8 | number]


def set_special(number, value):
    return word(0, value) + [0xF380, (0x8C00 if number == APSR else 0x8800) | number]


def put(address, value):
    return word(0, address) + word(1, value) + save(1, 0)


def single(number, value):
    return word(0, value) + [0xEE00 | number >> 1, (number & 1) << 7 | 0x0A10]


def set_fpscr(value):
    return word(0, value) + [0xEEE1, 0x0A10]


def notes(*parts):
    """Code that leaves words in r0, each of which goes to the log."""
    return word(3, NEXT) + load(2, 3) + sum((part + [0xF842, 0x0B04] for part in parts), []) + save(2, 3)


def masks_and_stacks():
    return [special(0, number) for number in [MSP, PSP, CONTROL, PRIMASK, BASEPRI, FAULTMASK]]


def look(fault):
    """What a handler finds. Of ICSR: active, alone, the next, PendSV and SysTick; of FPCCR: still to be stacked."""
    # tst lr, #4; ite eq; mrseq r1, msp; mrsne r1, psp
    frame = [0xF01E, 0x0F04, 0xBF0C] + special(1, MSP) + special(1, PSP)
    found = [special(0, IPSR), [0x4670], *masks_and_stacks()]
    found += [word(1, ICSR) + load(0, 1) + word(12, 0x141FF9FF) + [0xEA00, 0x000C]]
    found += [word(1, FPCCR) + load(0, 1) + [0xF000, 0x0001]]
    found += [frame + load(0, 1, 4 * i) for i in range(26)]
    if fault:
        # Cleared, and with a status the instruction is left out: cmp r0, #0; beq; ldr; adds r0, #2; str; then the status again
        left_out = [0x2800, 0xD004] + load(0, 1, 24) + [0x3002] + save(0, 1, 24) + load(0, 12)
        found += [word(12, status) + load(0, 12) for status in [HFSR, CFSR]]
        found += [word(12, HFSR) + load(0, 12) + save(0, 12), word(12, CFSR) + load(0, 12) + save(0, 12) + frame + left_out]
    return notes(*found)


def acts(rng, floats, most, fault=False):
    """Something to do, from a handler or not."""
    def pend():
        code = []
        for number in rng.sample(PENDED, rng.choice([1, 1, 2, 3])):
            code += put(ISPR, 1 << number - FIRST) if number >= FIRST else put(ICSR, 1 << (28 if number == PENDSV else 26))
        return code

    def clobber():
        return sum((word(r, rng.getrandbits(32)) for r in [1, 2, 3, 12]), []) + set_special(APSR, rng.getrandbits(32) & 0xF80F0000)

    def masked():
        return MASK + pend() + UNMASK + ISB

    def faults_masked():
        return MASK_FAULTS + pend() + UNMASK_FAULTS + ISB

    def from_a_level():
        level = set_special(BASEPRI, rng.choice([0x40, 0x80, 0xC0]))
        return MASK + level + pend() + UNMASK + ISB + set_special(BASEPRI, 0) + ISB

    def call():
        return CALL

    def call_if():
        # cmp r0, #0; itt eq, itt ne or ite eq; svc; adds r0, #1; it ne; svc
        return word(0, rng.getrandbits(1)) + [0x2800, rng.choice([0xBF04, 0xBF1C, 0xBF0C])] + CALL + [0x3001, 0xBF18] + CALL

    def undefined():
        return UNDEFINED

    def nowhere():
        return word(0, 0x60000000) + [0x6801]

    def exclusive():
        take, give = rng.choice([
            ([0xE851, 0x0F00], [0xE841, 0x4500]), ([0xE8D1, 0x0F4F], [0xE8C1, 0x4F45]), ([0xE8D1, 0x0F5F], [0xE8C1, 0x4F55])])
        at = word(1, WORD)
        between = rng.choice([[], CLREX, [] if fault else CALL, masked(), at + give])
        return at + word(4, rng.getrandbits(32)) + take + between + at + give + notes([0x4628], word(1, WORD) + load(0, 1))

    def floating():
        return sum((single(rng.randrange(32), rng.getrandbits(32)) for _ in range(3)), []) + set_fpscr(rng.getrandbits(4) << 28)

    choices = [clobber, masked, masked, from_a_level, exclusive, exclusive] + ([floating] * 3 if floats else [])
    # A fault or a call within a HardFault locks the processor up.
    choices += [] if fault else [faults_masked, call, call, call_if, undefined, nowhere]
    return sum((rng.choice(choices)() for _ in range(rng.randrange(most))), [])


def handler(rng, number, floats):
    """Looks; with some budget left, acts; returns."""
    code = look(number in FAULTS)
    if rng.random() < 0.4:
        return code + [0x4770]
    # push {r4, lr}; …; pop {r4, pc}
    acting = acts(rng, floats, 3, number == 3)
    code += [0xB510] + word(0, BUDGET) + [0x6801, 0x2900]
    acting = [0x3901, 0x6001] + acting
    return code + [0xF000, 0x8000 | len(acting)] + acting + [0xBD10]


def scenario(rng, at):
    """Vectors, a program and its handlers, for this address. The next one's vectors come where it ends, and go before its code."""
    floats = rng.random() < 0.6
    code = put(VTOR, at) + put(BUDGET, 5) + put(ICER, 0xF) + put(ICPR, 0xF) + put(ICSR, 1 << 27 | 1 << 25) + set_special(MSP, MAIN)
    code += put(AIRCR, 0x05FA0000 | rng.choice([0, 3, 4, 5, 6, 7]) << 8)
    levels = [0x00, 0x10, 0x40, 0x50, 0x80, 0xC0]
    for register in [SHPR, SHPR + 4, SHPR + 8, IPR]:
        code += put(register, sum(rng.choice(levels) << 8 * i for i in range(4)))
    code += put(ISER, rng.choice([0xF, 0xF, rng.getrandbits(4)])) + put(SHCSR, rng.getrandbits(3) << 16)
    lazy = rng.getrandbits(1)
    code += put(FPCCR, (2 | lazy) << 30) + set_fpscr(0)
    code += sum((single(number, rng.getrandbits(32)) for number in range(32)), [])
    code += set_special(PSP, PROCESS - 4 * rng.getrandbits(1)) + set_special(APSR, rng.getrandbits(32) & 0xF80F0000)
    in_use = 4 if floats and rng.getrandbits(1) else 0
    code += set_special(CONTROL, rng.getrandbits(1) << 1 | in_use) + ISB + rng.choice([[], [0xB081]])
    code += sum((word(r, rng.getrandbits(32)) for r in [*range(13), LR]), []) + acts(rng, floats, 9)
    # mov r11, lr
    code += [0x46F3] + word(12, ENDED) + sum((save(r, 12, 4 * r) for r in range(12)), [])
    code += notes(*[word(1, ENDED) + load(0, 1, 4 * r) for r in range(12)], special(0, APSR), *masks_and_stacks())
    code += notes([0xEEF1, 0x0A10], *[[0xEE10 | n >> 1, (n & 1) << 7 | 0x0A10] for n in range(32)])
    code += set_special(CONTROL, 0) + ISB
    # The way to the next: b.w over the handlers, whose length is not known yet.
    way, place = len(code), {}
    code += [0, 0]
    for number in [*FAULTS, SVC, *PENDED]:
        place[number] = at + 0x200 + 2 * len(code)
        # Stacked at once, floating point is not known in a handler.
        code += handler(rng, number, floats and lazy)
    code += [0xBF00] * (-len(code) % 256)
    ahead = len(code) - way - 2 + 256
    code[way:way + 2] = [0xF000 | ahead >> 11, 0xB800 | ahead & 0x7FF]
    table = [place.get(number, 0) | 1 for number in range(128)]
    return struct.pack("<128I", *table) + struct.pack(f"<{len(code)}H", *code)


def image(rng, path):
    """Scenarios, and an end for each of the two: the model's is a loop, in QEMU the log goes to a file by semihosting."""
    start = word(0, CPACR) + word(1, 0xF << 20) + save(1, 0) + ISB + put(NEXT, LOG) + word(0, FLASH + 0x601) + [0x4700]
    start += [0xBF00] * (256 - len(start))
    code = struct.pack("<128I", MAIN, *[FLASH + 0x201] * 127) + struct.pack("<256H", *start)
    for _ in range(SCENARIOS):
        code += scenario(rng, FLASH + len(code))
    code += bytes(512)
    end = FLASH + len(code)
    host, file = [0xBEAB], RAM + 0x100
    opened = put(file, end + 0x100) + put(file + 4, 5) + put(file + 8, len(path)) + word(0, 1) + word(1, file) + host
    written = word(1, file) + save(0, 1) + word(2, LOG) + save(2, 1, 4) + word(3, NEXT) + load(3, 3) + [0xEBA3, 0x0302]
    written += save(3, 1, 8) + word(0, 5) + host + word(0, 0x18) + word(1, 0x20026) + host
    by_qemu = struct.pack(f"<{len(opened + written)}H", *opened + written).ljust(0x100, b"\0") + path.encode() + b"\0"
    return code + struct.pack("<H", 0xE7FE), code + by_qemu, end


def logs(program, qemu, rng, folder):
    """What the model and QEMU write down for one image."""
    log, model, other = folder / "log", folder / "model.bin", folder / "qemu.bin"
    ours, theirs, end = image(rng, str(log))
    model.write_bytes(ours)
    other.write_bytes(theirs)
    machine = [qemu, "-M", "netduinoplus2", "-display", "none", "-monitor", "none", "-serial", "none", "-semihosting", "-kernel", other]
    subprocess.run(machine, check=True, timeout=60, capture_output=True)
    said = subprocess.run([program, model, f"{end:x}"], check=True, capture_output=True).stdout
    return [struct.unpack(f"<{len(data) // 4}I", data) for data in (said, log.read_bytes())]


def main():
    program, qemu = sys.argv[1:3]
    images = IMAGES * int(sys.argv[3] if len(sys.argv) > 3 else 1)
    rng = random.Random(int(sys.argv[4]) if len(sys.argv) > 4 else 1)
    words = different = 0
    for i in range(images):
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs = logs(program, qemu, rng, Path(folder))
        words += len(theirs)
        if 4 * len(theirs) > LOG_END - LOG:
            sys.exit("error: a log is longer than its room")
        if ours != theirs:
            different += 1
            at = next((k for k, pair in enumerate(zip(ours, theirs)) if pair[0] != pair[1]), min(len(ours), len(theirs)))
            print(f"image {i}: {len(ours)} words for {len(theirs)}; from word {at}:")
            for said in (ours, theirs):
                print(" ".join(f"{w:x}" for w in said[max(0, at - 40):at + 40]))
    print(f"{images} images with {SCENARIOS} programs each, {words} words written down; {different} image(s) differ")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
