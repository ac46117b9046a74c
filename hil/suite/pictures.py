"""What the cameras of the virtual machine are fed: a picture for each recorded state of the light."""
import functools
import sys
from array import array

from suite import light
from suite.twin import Twin, packed

KEY_BITS, BRIGHT_DN, DARK_DN, CARD_DN, BLACK_DN = 64, 3000, 200, 1600, 64
CARD, BLACK = "test card", "black"
CLIPPED_DN = 4095


def to_mosaic(photograph):
    """Steps of a sensor with one gain, radiance 1 its full scale, under red, green / green, blue. The twin
    exposes each kind of light by a gain of its own; what is clipped there is clipped here."""
    black_dn = photograph.black_dn
    steps = [max(0, round(black_dn + (dn - black_dn) * photograph.scale))
             for dn in range(CLIPPED_DN)] + [CLIPPED_DN]
    row_samples, mosaic = 3 * photograph.width, []
    for y in range(photograph.height):
        row = [0] * photograph.width
        at = y * row_samples
        first, second = (0, 1) if y % 2 == 0 else (1, 2)
        row[0::2] = photograph.dn[at + first:at + row_samples:6]
        row[1::2] = photograph.dn[at + 3 + second:at + row_samples:6]
        mosaic += [steps[dn] for dn in row]
    return mosaic


def draw_key(key, width, height):
    """A picture that carries a key in its first columns, then texture."""
    number = int(key, 16)
    bits = [BRIGHT_DN if number >> x & 1 else DARK_DN for x in range(KEY_BITS)]
    return [dn for y in range(height) for dn in
            bits + [(x * 37 + y * 61 + (number & 1023)) & 4095 for x in range(KEY_BITS, width)]]


def write(folder, states, picture_of):
    """The folder that a playing feeder reads: each state, and its picture of 12-bit steps."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "states").write_text("".join(state.line + "\n" for state in states), encoding="utf-8")
    for state in states:
        words = array("H", (dn << 4 for dn in picture_of(state)))
        if sys.byteorder == "big":
            words.byteswap()
        (folder / f"{state.key}.raw").write_bytes(words.tobytes())


@functools.cache
def read(folder):
    """{a photograph's packed bytes: key} of such a folder, test card and black among them."""
    found = {}
    for file in sorted(folder.glob("*.raw")):
        words = array("H", file.read_bytes())
        if sys.byteorder == "big":
            words.byteswap()
        found[packed([word >> 4 for word in words])] = file.stem
        for dn, key in ((CARD_DN, CARD), (BLACK_DN, BLACK)):
            found[packed([dn] * len(words))] = key
    return found


def render(folder, states, rig, twin):
    """The twin's photograph of each state. rig: (LEDs, numbers) of the rig file."""
    leds, numbers = rig
    names = light.pattern_names(numbers)
    sizes = []

    def picture_of(state):
        photograph = twin.photograph(light.report(state, leds, names, numbers))
        sizes.append((photograph.width, photograph.height))
        return to_mosaic(photograph)

    write(folder, states, picture_of)
    width, height = sizes[0]
    (folder / "sensor").write_text(f"columns={width}\nrows={height}\n", encoding="utf-8")
