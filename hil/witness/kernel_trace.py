"""Kernel events: gpio:gpio_value to edges of named lines."""
import re
import struct
from typing import NamedTuple

from witness import ring_buffer
from witness.edges import START_LEVELS, Edge, changes


class EventFormat(NamedTuple):
    """Where the kernel that was traced keeps the fields of one event."""
    id: int
    offsets: dict


def read_format(text):
    """An event's `format` file."""
    number = int(re.search(r"^ID: (\d+)$", text, re.M)[1])
    fields = re.findall(r"field:[^;]*?(\w+);\s*offset:(\d+);\s*size:4;", text)
    return EventFormat(number, {name: int(offset) for name, offset in fields})


def read_line_names(text):
    """The kernel's list of GPIO lines (debugfs `gpio`) to {number: name}."""
    return {int(number): name for number, name in re.findall(r"gpio-(\d+)\s+\((\w+)", text)}


def settings(pages, event_format, names):
    """Yields an Edge whenever a named line was set, whether or not that moved it."""
    for t_ns, payload in ring_buffer.events(pages):
        if struct.unpack_from("<H", payload)[0] != event_format.id:
            continue
        number, get, value = (struct.unpack_from("<i", payload, event_format.offsets[field])[0]
                              for field in ("gpio", "get", "value"))
        if not get and number in names:
            yield Edge(t_ns, names[number], int(value != 0))


def edges(pages, event_format, names):
    """Every change of a named line of a rig that was at rest."""
    return changes(settings(pages, event_format, names), START_LEVELS)
