"""Edges to and from a Value Change Dump: for any viewer of one, and from any logic analyser."""
import re
from typing import NamedTuple

from witness.edges import Edge

FIRST_CODE = 33  # printable identifiers begin at '!'
LEAD_NS = 1000  # before the first edge: who samples the file must see the level that it leaves
UNIT_NS = {"s": 1e9, "ms": 1e6, "us": 1e3, "ns": 1.0, "ps": 1e-3, "fs": 1e-6}


class VcdError(ValueError):
    """The file is no dump of single lines."""


class Recording(NamedTuple):
    """What an analyser saw: each line's level at the beginning, every edge, and its last moment."""
    levels: dict
    edges: list
    end_ns: int


def write(path, edges, lines):
    """Writes every edge; each line starts from the level that its first edge leaves."""
    codes = {line: chr(FIRST_CODE + i) for i, line in enumerate(lines)}
    shown = [edge for edge in edges if edge.line in codes]
    start_ns = shown[0].t_ns if shown else 0
    first = {}
    for edge in shown:
        first.setdefault(edge.line, 1 - edge.value)
    with open(path, "w", encoding="ascii") as out:
        out.write("$timescale 1 ns $end\n$scope module rig $end\n")
        for line, code in codes.items():
            out.write(f"$var wire 1 {code} {line} $end\n")
        out.write("$upscope $end\n$enddefinitions $end\n#0\n")
        for line, code in codes.items():
            out.write(f"{first.get(line, 0)}{code}\n")
        for edge in shown:
            out.write(f"#{edge.t_ns - start_ns + LEAD_NS}\n{edge.value}{codes[edge.line]}\n")


def _head(text, path):
    """(nanoseconds of a tick, {identifier: name}) of the part before $enddefinitions."""
    scale = re.search(r"\$timescale\s+(\d+)\s*(s|ms|us|ns|ps|fs)\s+\$end", text)
    names = dict(re.findall(r"\$var\s+\S+\s+1\s+(\S+)\s+(\S+)", text))
    if not scale or not names:
        raise VcdError(f"{path}: no Value Change Dump of lines: it has no $timescale or no $var")
    return int(scale[1]) * UNIT_NS[scale[2]], names


def _changes(lines, tick_ns, path):
    """Yields (t_ns, identifier, level); (t_ns, None, None) for each moment that the file names."""
    t_ns = 0
    for number, line in enumerate(lines, 1):
        for word in line.split():
            if word[0] == "#" and word[1:].isdecimal():
                t_ns = round(int(word[1:]) * tick_ns)
                yield t_ns, None, None
            elif word[0] in "01":
                yield t_ns, word[1:], int(word[0])
            elif word[0] not in "xXzZ$":
                raise VcdError(f"{path}: \"{word[:20]}\", {number} lines after its head: no level")


def read(path, names=None):
    """A dump that anybody wrote. names: {its name of a channel: (our name of the line, whether it
    is inverted)}; None takes every channel by its own name."""
    with open(path, encoding="ascii", errors="replace") as source:
        head = ""
        for line in source:
            head += line
            if "$enddefinitions" in line:
                break
        tick_ns, channels = _head(head, path)
        if names is None:
            names = {name: (name, False) for name in channels.values()}
        missing = sorted(set(names) - set(channels.values()))
        if missing:
            raise VcdError(f"{path}: has no channel {', '.join(missing)}; it has "
                           + ", ".join(sorted(channels.values())))
        wanted = {code: names[name] for code, name in channels.items() if name in names}
        levels, now, edges, end_ns = {}, {}, [], 0
        for t_ns, code, level in _changes(source, tick_ns, path):
            end_ns = max(end_ns, t_ns)
            if code not in wanted:
                continue
            line, inverted = wanted[code]
            level ^= inverted
            if line not in now:
                levels[line] = level
            elif now[line] != level:
                edges.append(Edge(t_ns, line, level))
            now[line] = level
    return Recording(levels, edges, end_ns)
