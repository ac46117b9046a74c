"""States of the light as the cameras' feeder recorded them, and what the twin is told of each."""
import math
import re
from typing import NamedTuple

from witness import led_chain, patterns

STATE = re.compile(r"state (\w+) camera (\d) exposure (\d+) leds (\d+) lamp (\d+) pattern (\w+) "
                   r"analyser (\d) codes ([0-9a-f]+)")


class State(NamedTuple):
    """camera: 0 left, 1 right. *_us: how long TRIGGER, and the light meanwhile, were on. pattern: a digest
    of what the display showed. bits: of the LED drivers, in the order in which they were clocked."""
    key: str
    camera: int
    exposure_us: int
    leds_us: int
    lamp_us: int
    pattern: str
    crossed: bool
    bits: tuple
    line: str


def _state(line):
    key, camera, exposure_us, leds_us, lamp_us, pattern, analyser, codes = STATE.fullmatch(line).groups()
    bits = tuple(int(code, 16) >> bit & 1 for code in codes for bit in (3, 2, 1, 0))
    return State(key, int(camera), int(exposure_us), int(leds_us), int(lamp_us), pattern,
                 camera == "1" or analyser == "1", bits, line)


def read_states(text):
    """{key: state} of a feeder's file."""
    return {state.key: state for state in map(_state, text.splitlines())}


def digest(values):
    """FNV-1a: what the feeder calls a frame of LED codes, or a pattern."""
    value = 0xcbf29ce484222325
    for byte in values:
        value = (value ^ byte) * 0x100000001b3 & (1 << 64) - 1
    return f"{value:016x}"


def pattern_names(numbers):
    """{digest: name} of all patterns of a burst, as we draw them and the feeder looks at them: two rows
    of each 64."""
    def looked_at(name):
        image = patterns.draw(numbers, name)
        return b"".join(row for v, row in enumerate(image) if v % 64 < 2)
    return {digest(looked_at(name)): name for name in patterns.every_pattern()}


def _codes(state, leds):
    """Two bytes an LED, little endian, as text of protobuf."""
    codes = led_chain.decode(state.bits)
    return "".join(f"\\{code & 255:03o}\\{code >> 8:03o}" for code in
                   (codes[chip, output] for chip, output, _ in leds))


def report(state, leds, names, numbers):
    """A lamella.v1.ExposureReport in protobuf's text. names: pattern_names(); numbers: of the rig file."""
    periods_us = numbers["projector.light_periods"] * 1e6 / numbers["projector.refresh_hz"]
    text = (f"camera: {state.camera} open_us: 0 close_us: {state.exposure_us}\n"
            f"led_reference_us: {numbers['leds.light_us']} projector_reference_us: {periods_us}\n")
    if state.leds_us:
        text += f'leds {{ on_us: 0 off_us: {state.leds_us} codes: "{_codes(state, leds)}" }}\n'
    if state.lamp_us:
        if state.pattern not in names:
            raise ValueError(f"the display showed what is no pattern of a burst: {state.pattern}")
        kind, _, index = names[state.pattern].partition(" ")
        text += f"patterns {{ on_us: 0 off_us: {state.lamp_us} kind: {kind} index: {index or 0} }}\n"
    if state.camera == 0:
        angle_rad = math.pi / 2 if state.crossed else 0
        text += (f"analyser {{ from_us: 0 to_us: {state.exposure_us} from_rad: {angle_rad} "
                 f"to_rad: {angle_rad} }}\n")
    return text
