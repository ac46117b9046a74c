"""A plan and edges that keep it, small enough to read."""
import struct
import zlib

from witness.edges import Edge
from witness.plan import Plan, PlannedEdge

# One gradient step: loaded, latched, triggered, lit for 1000 us.
PLAN = Plan([
    PlannedEdge(0, 1000, "SHIFT", 0, 0),
    PlannedEdge(100, 1000, "LATCH", 1, 0),
    PlannedEdge(102, 1000, "LATCH", 0, 0),
    PlannedEdge(200, 50, "TRIGGER", 1, 0),
    PlannedEdge(300, 50, "BLANK", 0, 0),
    PlannedEdge(1300, 50, "BLANK", 1, 0),
    PlannedEdge(1400, 50, "TRIGGER", 0, 0),
    PlannedEdge(1500, 1000, "LAMP", 0, 0),
], ["GRADIENT_X"])


def edges_in_time(zero_ns=5_000_000):
    """What a perfect rig does: LAMP, already off, does not move."""
    return [Edge(zero_ns + int(edge.t_us * 1e3), edge.line, edge.value)
            for edge in PLAN.edges if edge.line not in ("SHIFT", "LAMP")]


def clocked(bits, start_ns=1000, period_ns=100):
    """Edges of a bus that shifts the bits in mode 0 and latches them."""
    found, mosi, t_ns = [], 0, start_ns
    for bit in bits:
        if bit != mosi:
            found.append(Edge(t_ns, "SPI_MOSI", bit))
            mosi = bit
        found.append(Edge(t_ns + period_ns // 2, "SPI_SCK", 1))
        found.append(Edge(t_ns + period_ns, "SPI_SCK", 0))
        t_ns += period_ns
    return found + [Edge(t_ns + 10, "LATCH", 1), Edge(t_ns + 20, "LATCH", 0)]


def exr_of(rows):
    """An OpenEXR file of [[(red, green, blue)]], as the host writes it."""
    width, height = len(rows[0]), len(rows)
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<II", 20000630, 2)
    for name, kind, value in ((b"compression", b"compression", b"\3"), (b"dataWindow", b"box2i", window)):
        head += name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value
    head += b"\0"
    chunks = []
    for top in range(0, height, 16):
        plain = b"".join(struct.pack(f"<{width}e", *(pixel[c] for pixel in row))
                         for row in rows[top:top + 16] for c in (2, 1, 0))
        mixed = plain[0::2] + plain[1::2]
        packed = zlib.compress(bytes([mixed[0]] + [(b - a + 128) & 255 for a, b in zip(mixed, mixed[1:])]))
        data = packed if len(packed) < len(plain) else plain
        chunks.append(struct.pack("<ii", top, len(data)) + data)
    at, offsets = len(head) + 8 * len(chunks), b""
    for chunk in chunks:
        offsets += struct.pack("<Q", at)
        at += len(chunk)
    return head + offsets + b"".join(chunks)
