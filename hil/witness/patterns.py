"""The projector's patterns as PROTOCOL.md defines them, drawn from the rig file's numbers alone.

An image is a list of rows, a row bytes of 4 a pixel: blue, green, red, 0. Rows that are alike are
one object.
"""
import math

FRINGES = STRIPES = 4
SAMPLES = (-0.375, -0.125, 0.125, 0.375)


def every_pattern():
    """Names of all the patterns of a burst."""
    return (["BLACK", "WHITE", "DOTS"] + [f"FRINGE {k}" for k in range(FRINGES)]
            + [f"STRIPES {k}" for k in range(STRIPES)])


def of_step(role, index):
    """The pattern that a step of the burst asks for, None where it asks for LEDs."""
    if role in ("FRINGE", "STRIPES"):
        return f"{role} {index}"
    return {"BLACK": "BLACK", "DOTS": "DOTS", "FRONT": "WHITE"}.get(role)


def draw(numbers, name):
    """The image of a pattern."""
    kind, _, index = name.partition(" ")
    height = int(numbers["projector.height_px"])
    if kind == "DOTS":
        return _dots(numbers)
    if kind == "FRINGE":
        row = _row(numbers, _fringe(numbers, numbers[f"pattern.fringe_{index}_periods"]))
    elif kind == "STRIPES":
        row = _row(numbers, _stripes(numbers, int(index) * numbers["pattern.stripe_shift_px"]))
    else:
        row = _row(numbers, lambda u: (float(kind == "WHITE"),) * 3)
    return [row] * height


def _code(numbers, value):
    return math.floor(255 * value ** (1 / numbers["projector.gamma"]) + 0.5)


def _row(numbers, value_at):
    """value_at(u) is the light of red, green and blue."""
    row = bytearray()
    for u in range(int(numbers["projector.width_px"])):
        red, green, blue = (_code(numbers, min(max(value, 0.0), 1.0)) for value in value_at(u))
        row += bytes((blue, green, red, 0))
    return bytes(row)


def _fringe(numbers, periods):
    width = numbers["projector.width_px"]
    return lambda u: [0.5 + 0.5 * math.cos(2 * math.pi * periods * u / width
                                           + (c - 1) * 2 * math.pi / 3) for c in range(3)]


def _stripes(numbers, shift_px):
    period_px = numbers["pattern.stripe_period_px"]
    whole = math.floor(shift_px)
    part = shift_px - whole

    def white(at_px):
        return float(math.floor(at_px % period_px) < period_px / 2)

    return lambda u: ((1 - part) * white(u - whole) + part * white(u - whole - 1),) * 3


def _to_centre(at_px, pitch_px, offset_px):
    """From the nearest disc's centre, along one side of the grid."""
    away = at_px - offset_px
    return away - pitch_px * math.floor(away / pitch_px + 0.5)


def _dots(numbers):
    pitch_px, radius_px = numbers["pattern.dot_pitch_px"], numbers["pattern.dot_diameter_px"] / 2
    greys = [bytes((_code(numbers, k / 16),) * 3 + (0,)) for k in range(17)]
    along_u = [_to_centre(u, pitch_px, numbers["pattern.dot_offset_u_px"])
               for u in range(int(numbers["projector.width_px"]))]
    white = greys[16] * len(along_u)

    def grey(du, dv):
        if math.hypot(du, dv) > radius_px + 1:
            return greys[16]
        return greys[sum((du + x) ** 2 + (dv + y) ** 2 >= radius_px ** 2
                         for x in SAMPLES for y in SAMPLES)]

    image = []
    for v in range(int(numbers["projector.height_px"])):
        dv = _to_centre(v, pitch_px, numbers["pattern.dot_offset_v_px"])
        image.append(white if abs(dv) > radius_px + 1 else b"".join(grey(du, dv) for du in along_u))
    return image
