"""What a target hands to the scenes: bursts as witnessed, and how long lights stayed on."""
from pathlib import Path
from typing import NamedTuple, Optional

from witness.edges import START_LEVELS, Edge, changes


class Record(NamedTuple):
    """What the player wrote of its own burst, on the rig's clock."""
    zero_us: float
    edges: list       # those that move a line
    seen: list        # simulated rig: the hardware's own memory of its edges
    codes: list       # simulated rig: [codes of each LED], a light pulse each
    verdict: str      # the rig's own word on its burst
    replaced: list    # (step, shot) of each shot that a later one took again


class Burst(NamedTuple):
    """One burst. frames: bits from the bus; codes: levels by LED; a target has one of the two."""
    edges: list
    lines: tuple
    record: Record
    frames: Optional[list] = None
    codes: Optional[list] = None
    vcd_file: Optional[str] = None
    frames_before: list = []  # what the drivers were told before it: zeros, functions


class Light(NamedTuple):
    """off_us after the signal, or None where a light stayed on; told is the watcher's word."""
    off_us: Optional[float]
    told: str


class Evidence(NamedTuple):
    """Everything that one run on one target left behind."""
    target: str
    plan: object
    leds: list
    bursts: dict
    lights: dict
    machine: dict
    bursts_in_turn: tuple = ()     # one daemon's bursts, in order
    plan_crossed: object = None    # of a burst that begins with the analyser crossed
    folder: Optional[Path] = None  # what the guest left, a folder for each scene
    frames_at_start: list = []     # what the drivers were told as the daemon started


def _edge(t_us, line, value):
    return Edge(round(float(t_us) * 1e3), line, int(value))


def read_record(text):
    """hil-play's output. Levels that a line already had are no edges."""
    zero_us, verdict, recorded, seen, codes, replaced = None, "", [], [], [], set()
    for line in text.splitlines():
        kind, *rest = line.split()
        if kind == "zero":
            zero_us = float(rest[0])
        elif kind == "edge":
            name, value, _, _, actual_us = rest[:5]
            if rest[6:] == ["1"]:
                replaced.add((int(rest[2]), int(rest[5])))
            recorded.append(_edge(zero_us + float(actual_us), name, value))
        elif kind == "verdict":
            verdict = line[len("verdict "):]
        elif kind == "seen" and rest[2] != "inf":
            seen.append(_edge(rest[2], rest[0], rest[1]))
        elif kind == "codes":
            codes.append([int(code) for code in rest[1:]])
    seen.sort(key=lambda edge: edge.t_ns)
    return Record(zero_us, changes(recorded, START_LEVELS), changes(seen, START_LEVELS), codes,
                  verdict, sorted(replaced))

