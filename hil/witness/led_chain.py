"""The LED driver chain: bits on the bus to frames, a rig's LED levels to the bits that are right.

Written from the drivers' wiring, not from the firmware: last chip first, output 23 first, most
significant bit first, 12 bits an output; a bit is taken on the clock's rising edge (mode 0).
"""
from typing import NamedTuple

CHIPS, OUTPUTS, CODE_BITS = 7, 24, 12
FULL_CODE = 4095
BITS = CHIPS * OUTPUTS * CODE_BITS
# A TLC5951's functions (TI SBVS127E, 9.4.5.3), from the first bit that goes into a chip: nobody's;
# counters of 12 bits, not restarted by a LATCH; auto repeat; the upper range of dot correction for each
# colour; brightness 255 for each; dot correction 127 for each output.
FUNCTIONS = CHIPS * ((0,) * 89 + (0, 0, 0, 1, 1, 1, 1) + (1,) * 24 + (1,) * 7 * OUTPUTS)


class Frame(NamedTuple):
    """What was clocked in before one rising edge of LATCH."""
    first_ns: int
    last_ns: int
    latch_ns: int
    bits: tuple
    dark: bool  # BLANK was high from the first clock to the latch
    functions: bool = False  # LATCH was high at the last clock: these are no levels


def frames(edges):
    """Frames from edges of SPI_SCK, SPI_MOSI, LATCH and BLANK, which starts high."""
    mosi, blank, dark, latch, functions = 0, 1, True, 0, False
    bits, times_ns, found = [], [], []
    for edge in edges:
        if edge.line == "SPI_MOSI":
            mosi = edge.value
        elif edge.line == "BLANK":
            blank = edge.value
            dark = dark and (blank == 1 or not bits)
        elif edge.line == "SPI_SCK" and edge.value:
            dark = blank == 1 if not bits else dark
            bits.append(mosi)
            times_ns.append(edge.t_ns)
            functions = latch == 1
        elif edge.line == "LATCH":
            latch = edge.value
            if not latch:
                continue
            first_ns, last_ns = (times_ns[0], times_ns[-1]) if bits else (edge.t_ns, edge.t_ns)
            found.append(Frame(first_ns, last_ns, edge.t_ns, tuple(bits), dark and blank == 1,
                               functions))
            bits, times_ns, dark = [], [], True
    return found


def split(edges):
    """(what came before the burst, the burst): before it, frames of zeros and of functions alone."""
    frames_before = []
    for frame in frames(edges):
        if not frame.functions and any(frame.bits):
            break
        frames_before.append(frame)
    falls_ns = [edge.t_ns for edge in edges if edge.line == "LATCH" and not edge.value
                and frames_before and edge.t_ns > frames_before[-1].latch_ns]
    end_ns = min(falls_ns, default=0)
    return ([edge for edge in edges if edge.t_ns <= end_ns],
            [edge for edge in edges if edge.t_ns > end_ns])


def encode(codes):
    """{(chip, output): code} to the bits in the order in which they are clocked."""
    bits = []
    for chip in reversed(range(CHIPS)):
        for output in reversed(range(OUTPUTS)):
            code = codes.get((chip, output), 0)
            bits += [code >> bit & 1 for bit in reversed(range(CODE_BITS))]
    return tuple(bits)


def decode(bits):
    """The bits of a whole frame to {(chip, output): code}."""
    codes = {}
    for at in range(0, BITS, CODE_BITS):
        place = at // CODE_BITS
        chip, output = CHIPS - 1 - place // OUTPUTS, OUTPUTS - 1 - place % OUTPUTS
        codes[chip, output] = int("".join(map(str, bits[at:at + CODE_BITS])), 2)
    return codes


def codes_for(leds, role):
    """Levels of a gradient step: (1 + w.a) / 2 of full along an axis, full for GRADIENT_FULL.

    leds is [(chip, output, (x, y, z))] with unit directions; role a name of Frame.Role.
    """
    axis = {"GRADIENT_X": 0, "GRADIENT_Y": 1, "GRADIENT_Z": 2}.get(role)
    codes = {}
    for chip, output, direction in leds:
        level = 1.0 if axis is None else (1 + direction[axis]) / 2
        codes[chip, output] = int(min(max(level, 0), 1) * FULL_CODE + 0.5)
    return codes


def to_bytes(bits):
    """Whole bytes, most significant bit first."""
    return bytes(int("".join(map(str, bits[at:at + 8])), 2) for at in range(0, len(bits) - 7, 8))
