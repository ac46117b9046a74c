"""Light at the subject, as a photodiode behind a comparator saw it: the line LIGHT, 1 where lit."""

from suite.report import Measure, Result

LIGHT_FOLLOWS_US = 500  # a photodiode's amplifier and its comparator
CHOPPED_US = 2500  # darkness shorter than this is the drivers' own pulse width modulation


def spans(edges, line, level, longest_gap_ns=0):
    """[(from, to)] in which a line had that level; gaps of at most so much are none."""
    found, since = [], None
    for edge in edges:
        if edge.line != line:
            continue
        if edge.value == level and since is None:
            since = edge.t_ns
        elif edge.value != level and since is not None:
            found.append((since, edge.t_ns))
            since = None
    joined = []
    for span in found + ([(since, float("inf"))] if since is not None else []):
        if joined and span[0] - joined[-1][1] <= longest_gap_ns:
            joined[-1] = (joined[-1][0], span[1])
        else:
            joined.append(span)
    return joined


def _pulse_faults(number, on_ns, off_ns, lit):
    """(how late the light of one pulse came, in us, and what was wrong with it)."""
    seen = [span for span in lit if span[0] < off_ns and span[1] > on_ns]
    if not seen:
        return None, [f"light pulse {number}: BLANK was low and there was no light"]
    early_us = (off_ns - seen[-1][1]) / 1e3
    faults = (
        [f"light pulse {number}: the light ended {early_us:.0f} us before BLANK rose"]
        if early_us > CHOPPED_US
        else []
    )
    return (seen[0][0] - on_ns) / 1e3, faults


def light(edges, has_photodiode):
    """There is light while BLANK is low, and none when neither BLANK nor LAMP lets any through. The
    projector's light may be too little for a comparator: it need not be seen."""
    name = "light at the subject, by the photodiode: while BLANK is low, and no longer"
    if not has_photodiode:
        return Result(
            name,
            [],
            ["no channel is on LIGHT: without a photodiode nobody knows that light came or went"],
        )
    lit = spans(edges, "LIGHT", 1, CHOPPED_US * 1e3)
    pulses = spans(edges, "BLANK", 0)
    let_through = pulses + spans(edges, "LAMP", 1)
    faults, late_us, after_us = [], [0.0], [0.0]
    for number, (on, off) in enumerate(pulses):
        late, wrong = _pulse_faults(number, on, off, lit)
        faults += wrong
        late_us += [] if late is None else [late]
    for on, off in lit:
        ends = [span[1] for span in let_through if span[0] <= on]
        if not ends or max(ends) + LIGHT_FOLLOWS_US * 1e3 < on:
            faults.append("there was light while BLANK was high and the lamp shuttered")
        else:
            after_us.append((off - max(span[1] for span in let_through if span[0] <= off)) / 1e3)
    return Result(
        name,
        [
            Measure("light pulses of the LEDs", len(pulses), ""),
            Measure("longest wait for light", max(late_us), "us", LIGHT_FOLLOWS_US),
            Measure("longest light after it was ended", max(after_us), "us", LIGHT_FOLLOWS_US),
        ],
        faults,
    )
