"""Lines of an OpenEXR image as the host writes them: half floats, channels B G R, ZIP, 16 lines a chunk."""
import itertools
import struct
import zlib

MAGIC, ZIP, CHUNK_LINES = 20000630, 3, 16


def _attributes(exr):
    """({name: bytes}, where the chunks' offsets are)."""
    if struct.unpack_from("<I", exr)[0] != MAGIC:
        raise ValueError("not OpenEXR")
    at, attributes = 8, {}
    while exr[at]:
        name, kind, _ = exr[at:at + 600].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<I", exr, at)[0]
        attributes[name] = exr[at + 4:at + 4 + size]
        at += 4 + size
    if attributes[b"compression"][0] != ZIP:
        raise ValueError("not ZIP")
    return attributes, at + 1


def _unzipped(packed):
    """ZIP's bytes are differences, of all even bytes and then of all odd ones."""
    mixed = bytes(itertools.accumulate(zlib.decompress(packed), lambda a, b: (a + b - 128) & 255))
    plain = bytearray(len(mixed))
    half = (len(mixed) + 1) // 2
    plain[0::2], plain[1::2] = mixed[:half], mixed[half:]
    return bytes(plain)


def lines(exr, chunk=0):
    """[(red, green, blue)] of a chunk's lines, a tuple of values each."""
    attributes, offsets_at = _attributes(exr)
    left, top, right, bottom = struct.unpack("<4i", attributes[b"dataWindow"])
    at = struct.unpack_from("<Q", exr, offsets_at + 8 * chunk)[0]
    size = struct.unpack_from("<i", exr, at + 4)[0]
    width, count = right - left + 1, min(CHUNK_LINES, bottom - top + 1 - chunk * CHUNK_LINES)
    data = exr[at + 8:at + 8 + size]
    if size != width * count * 6:
        data = _unzipped(data)
    found = []
    for line in range(count):
        blue, green, red = (struct.unpack_from(f"<{width}e", data, (3 * line + c) * width * 2)
                            for c in range(3))
        found.append((red, green, blue))
    return found
