"""What the display showed and when: hil-watch-display's output, the kernel's drm_vblank_event."""
import re
import struct
from typing import NamedTuple

from witness import ring_buffer


class Shown(NamedTuple):
    """From the vblank of this number on the display scans out this framebuffer (0: none)."""
    sequence: int
    vblank_us: float
    found_us: float
    framebuffer: int


def read_shown(text):
    """hil-watch-display's output."""
    rows = [line.split()[1:] for line in text.splitlines() if line.startswith("shown ")]
    return [Shown(int(row[0]), float(row[1]), float(row[2]), int(row[3])) for row in rows]


def read_framebuffer(data):
    """A file of hil-watch-display to a list of rows, as witness.patterns has them."""
    head, _, rest = data.partition(b"\n")
    width, height, different = (int(number) for number in head.split())
    like = struct.unpack_from(f"<{height}I", rest)
    rows = [rest[4 * (height + i * width):4 * (height + (i + 1) * width)] for i in range(different)]
    if len(rest) != 4 * (height + different * width):
        raise ring_buffer.TraceError("a framebuffer's file is cut short")
    return [rows[i] for i in like]


def vblanks(pages, format_text):
    """{sequence: time in microseconds} of every vblank that the kernel's trace tells of."""
    number = int(re.search(r"^ID: (\d+)$", format_text, re.M)[1])
    offsets = {name: int(offset) for name, offset in
               re.findall(r"field:[^;]*?(\w+);\s*offset:(\d+);", format_text)}
    found = {}
    for _, payload in ring_buffer.events(pages):
        if struct.unpack_from("<H", payload)[0] == number:
            (sequence,) = struct.unpack_from("<I", payload, offsets["seq"])
            (time_ns,) = struct.unpack_from("<q", payload, offsets["time"])
            found[sequence] = time_ns / 1e3
    return found


def differing_pixels(image, other):
    """How many pixels of two images are not the same; all of them where their sizes differ."""
    if len(image) != len(other) or len(image[0]) != len(other[0]):
        return len(image) * len(image[0]) // 4
    counts = {}
    for pair in zip(image, other):
        if pair not in counts:
            a, b = pair
            counts[pair] = 0 if a == b else sum(a[i:i + 3] != b[i:i + 3]
                                                for i in range(0, len(a), 4))
    return sum(counts[pair] for pair in zip(image, other))
