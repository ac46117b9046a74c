"""A witness and a rig have clocks of their own: where a burst is in a recording, and how the two
clocks go together."""

import bisect
import statistics
from typing import NamedTuple

from witness.compare import CRITICAL
from witness.edges import Edge

NEAR_NS = 1_000_000  # a trigger belongs to one that is recorded where it is so near to it
AFTER_NS = 50_000_000  # of the recording that are the burst's


class Clock(NamedTuple):
    """Microseconds of the rig from nanoseconds of a witness."""

    offset_us: float
    drift_ppm: float  # how much faster the witness's clock goes

    def edge(self, seen):
        """The same edge on the rig's clock."""
        t_us = seen.t_ns / 1e3 / (1 + self.drift_ppm * 1e-6) - self.offset_us
        return Edge(round(t_us * 1e3), seen.line, seen.value)


def _rises_ns(edges):
    return [e.t_ns for e in edges if e.line == "TRIGGER" and e.value]


def _agreeing(anchor_ns, recorded_ns, seen_ns):
    """How many of the record's triggers have one near them, if the first is at the anchor."""
    count = 0
    for t_ns in recorded_ns:
        wanted_ns = anchor_ns + t_ns - recorded_ns[0]
        at = bisect.bisect_left(seen_ns, wanted_ns - NEAR_NS)
        count += at < len(seen_ns) and seen_ns[at] <= wanted_ns + NEAR_NS
    return count


def find_burst(recording, recorded, begin_ns):
    """The burst's own part of a recording, from its zero on the rig's clock: (levels before it, its
    edges), or None where no trigger is in it. It is where most of the triggers are as far apart as
    the rig recorded them."""
    recorded_ns, seen_ns = _rises_ns(recorded), _rises_ns(recording.edges)
    if not recorded_ns or not seen_ns:
        return None
    anchor_ns = max(seen_ns, key=lambda t_ns: _agreeing(t_ns, recorded_ns, seen_ns))
    zero_ns = anchor_ns - recorded_ns[0]
    first_ns = zero_ns + begin_ns  # before it the LED drivers are read back
    last_ns = zero_ns + max(e.t_ns for e in recorded) + AFTER_NS
    levels, edges = dict(recording.levels), []
    for edge in recording.edges:
        if edge.t_ns < first_ns:
            levels[edge.line] = edge.value
        elif edge.t_ns <= last_ns:
            edges.append(edge)
    return levels, edges


def fit(seen, recorded):
    """The Clock that brings what was seen to what the rig recorded, by medians over the critical
    edges: one that strays moves nothing. The two lists are of the same edges, in order."""
    pairs = [(s.t_ns / 1e3, r.t_ns / 1e3) for s, r in zip(seen, recorded) if r.line in CRITICAL]
    half = len(pairs) // 2
    slopes = [(b[0] - a[0]) / (b[1] - a[1]) for a, b in zip(pairs, pairs[half:]) if b[1] > a[1]]
    rate = statistics.median(slopes) if slopes else 1.0
    offset_us = statistics.median(s_us / rate - r_us for s_us, r_us in pairs)
    return Clock(offset_us, (rate - 1) * 1e6)
