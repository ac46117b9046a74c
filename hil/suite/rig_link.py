"""A rig at an address, as its host's program lamella sees it: what it says of itself."""

import json
import subprocess
from typing import NamedTuple

from suite.evidence import Record
from witness.edges import START_LEVELS, Edge, changes
from witness.plan import PlannedEdge

LONGEST_S = 300  # of a burst, its transfer and its development


class RigError(Exception):
    """The rig does not answer, or has no burst."""


class Told(NamedTuple):
    """A session's timing.json: what was planned, and the player's own record of it."""

    planned: list  # PlannedEdge; what was retaken has no tolerance
    record: Record


class Rig:
    """One rig and the program that talks to it."""

    def __init__(self, lamella, address):
        self.address = address
        self._lamella = lamella

    def ask(self, *arguments):
        """(exit status, its JSON); exit 2 and 3 are no answers."""
        command = [self._lamella, *map(str, arguments), "--rig", self.address, "--json"]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            raise RigError(
                f"{self.address}: {' '.join(map(str, arguments[:2]))}: nothing in {LONGEST_S} s"
            ) from None
        if done.returncode not in (0, 1) or not done.stdout:
            raise RigError(done.stderr.strip() or f"{self.address}: exit {done.returncode}")
        return done.returncode, json.loads(done.stdout)


def read_timing(session):
    """What the rig says of a session's edges. A shot that was taken again is bad and said to be."""
    timing = json.loads((session / "timing.json").read_text(encoding="utf-8"))
    planned, recorded, replaced = [], [], set()
    zero_us = timing.get("zero_us", 0)
    for edge in timing["edges"]:
        step = edge.get("step", 0)
        again = edge.get("replaced", False)
        if again:
            replaced.add((step, edge.get("shot", 0)))
        planned.append(
            PlannedEdge(
                edge.get("planned_us", 0.0),
                float("inf") if again else edge.get("tolerance_us", 0.0),
                edge["line"],
                edge.get("value", 0),
                step,
            )
        )
        recorded.append(
            Edge(
                round((zero_us + edge.get("actual_us", 0.0)) * 1e3),
                edge["line"],
                edge.get("value", 0),
            )
        )
    return Told(
        planned, Record(zero_us, changes(recorded, START_LEVELS), [], [], "", sorted(replaced))
    )
