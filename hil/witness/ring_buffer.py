"""Pages of a kernel trace (trace_pipe_raw) to events with times in nanoseconds.

The kernel's text says microseconds, in which edges of a fast bus coincide. The layout is that of
include/linux/ring_buffer.h: each event begins with 5 bits of type or length and 27 bits of time.
"""
import struct

PAGE_BYTES = 4096
HEADER_BYTES = 16  # time stamp, then the bytes that are used
USED_MASK = 0xFFFFF
MISSED = 1 << 31

PADDING, TIME_EXTEND, TIME_STAMP = 29, 30, 31


class TraceError(Exception):
    """The trace cannot be believed."""


def events(pages):
    """Yields (t_ns, payload) for every event of whole pages, oldest first."""
    if len(pages) % PAGE_BYTES:
        raise TraceError(f"{len(pages)} bytes are not whole pages")
    for at in range(0, len(pages), PAGE_BYTES):
        yield from _page_events(pages[at:at + PAGE_BYTES])


def _page_events(page):
    t_ns, commit = struct.unpack_from("<QQ", page)
    if commit & MISSED:
        raise TraceError("the kernel overwrote events before they were read")
    at, end = HEADER_BYTES, HEADER_BYTES + (commit & USED_MASK)
    if end > PAGE_BYTES:
        raise TraceError("a page says that more of it is used than there is")
    while at + 4 <= end:
        (head,) = struct.unpack_from("<I", page, at)
        kind, delta_ns = head & 31, head >> 5
        if kind == PADDING and delta_ns == 0:
            return
        extra = struct.unpack_from("<I", page, at + 4)[0] if kind == 0 or kind >= PADDING else 0
        if kind == TIME_EXTEND:
            t_ns += (extra << 27) + delta_ns
            at += 8
        elif kind == TIME_STAMP:
            t_ns = (extra << 27) + delta_ns
            at += 8
        elif kind == PADDING:
            at += 4 + extra
        else:
            t_ns += delta_ns
            start = at + (8 if kind == 0 else 4)
            at += 4 + (extra if kind == 0 else 4 * kind)
            yield t_ns, page[start:at]
