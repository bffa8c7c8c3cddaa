"""Boots the NUCLEO-G474RE's image in Unicorn, and says what it wrote to which register, in order.

    python -m venv VENV; VENV/bin/pip install unicorn==2.1.4
    VENV/bin/python tests/board/oracle/boot_g474.py target/thumb/thumbv7em-none-eabihf/firmware/g474 [--all]

The registers are no model of the part: they keep what is written, and a few say that they are ready. Accesses
outside the peripherals' addresses end the run. It shows that the start runs to its end, which values the registers then have
(held against the table `EXPECTED`, which the program's author wrote from memory of the reference manual), that each of the
five interrupts can be served some hundreds of times, that the link answers, that settings can be saved and are found after a
reset and after a power cut at any operation of the flash, that a start is refused because of Fault 18, and that PA8 stays
low. Interrupts are called one by one; there are no priorities and no time. Flash takes what the manual allows: unlocked,
page erased, whole words of 8 bytes. Unicorn is under the GPL and is not part of this project: it is asked, not linked.
"""

import struct
import sys

from g474 import *

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


def cuts(path):
    """The power goes at each operation of a save; then the settings in use are the old or the new, and known to be good."""
    def save(board, figure, number):
        steer, settings = session(board, 1), bytearray(board.ask(3, SETTINGS)[1:])
        settings[1] = figure
        board.ask(4, STEER + varint(steer) + varint(number) + SET + bytes(settings))

    def started(*arguments):
        board = Board(path, *arguments)
        board.start()
        return board

    slots = b"\xff" * 0x1000
    for figure in (1, 2):
        board = started(slots)
        save(board, figure, 1)
        slots = board.slots()
    found, number = {1: 0, 2: 0, 3: 0}, 0
    for torn in (False, True):
        for cut in range(200):
            board = started(slots, cut, torn)
            save(board, 3, 1)
            if board.left is None:
                break
            number, again = number + 1, started(board.left)
            known_good = again.ask(1, BOARD)[4] == 0
            found[again.ask(2, SETTINGS)[2] if known_good else 1] += 1
    return {f"power cut at {number} operations of a save: {found[2]} times the old settings, {found[3]} the new":
            number > 40 and found[1] == 0 and found[2] > 0 and found[3] > 0}


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
    checks.update(cuts(sys.argv[1]))
    for name, good in checks.items():
        wrong += not good
        print("ok     " if good else "WRONG  ", name)
    print(f"{len(EXPECTED) + len(checks) - wrong} of {len(EXPECTED) + len(checks)} right; {driven} writes at the start")
    sys.exit(wrong > 0)


main()
