"""What the witnesses saw against what the plan says."""
import statistics
from typing import NamedTuple, Optional

from witness.edges import START_LEVELS, changes

CRITICAL = ("BLANK", "TRIGGER")
LINES = ("BLANK", "LATCH", "TRIGGER", "LAMP", "ANALYSER")


class Deviation(NamedTuple):
    """How far one edge was from its planned time; positive is late."""
    planned: object
    us: float

    def is_beyond_tolerance(self):
        """Early is as wrong as late."""
        return abs(self.us) > self.planned.tolerance_us


class Comparison(NamedTuple):
    """zero_ns is the burst's zero that fits the critical edges best; None where nothing fits."""
    order_fault: Optional[str]
    zero_ns: Optional[float]
    deviations: list


def _describe(edge):
    return f"{edge.line} to {edge.value}"


def order_fault(planned, seen, goes_on=False):
    """The first place where the sequences of edges part, in words, or None. A burst that goes on, to
    retake what went wrong, may have edges after the plan's last one."""
    for i, (want, got) in enumerate(zip(planned, seen)):
        if (want.line, want.value) != (got.line, got.value):
            return (f"edge {i}: {_describe(want)} of step {want.step} was planned, "
                    f"{_describe(got)} happened")
    if len(planned) > len(seen):
        missing = planned[len(seen)]
        return f"{_describe(missing)} of step {missing.step} never happened"
    if len(planned) < len(seen) and not goes_on:
        return f"{_describe(seen[len(planned)])} happened after the plan's last edge"
    return None


def compare(plan, edges, lines=LINES, goes_on=False):
    """Order of the lines' edges, and each one's deviation from the plan.

    No witness sees the burst's zero: it is put where the critical edges' deviations have the median
    0, so that a single edge that strays shows whole and moves no other.
    """
    planned = [edge for edge in changes(plan.edges, START_LEVELS) if edge.line in lines]
    seen = [edge for edge in edges if edge.line in lines]
    fault = order_fault(planned, seen, goes_on)
    if fault:
        return Comparison(fault, None, [])
    pairs = list(zip(planned, seen))
    zero_ns = statistics.median(got.t_ns - want.t_us * 1e3 for want, got in pairs
                                if want.line in CRITICAL)
    return Comparison(None, zero_ns, [
        Deviation(want, (got.t_ns - zero_ns) / 1e3 - want.t_us) for want, got in pairs])


def largest(deviations, line=None):
    """The deviation of largest size, of one line or of all; None where there is none."""
    return max((d for d in deviations if line in (None, d.planned.line)),
               key=lambda d: abs(d.us), default=None)
