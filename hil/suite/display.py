"""The projector: which pattern it showed at each exposure, pixel for pixel, and when it flipped."""
from pathlib import Path
from typing import NamedTuple

from suite.report import Measure, Result
from witness import compare, display, kernel_trace, led_chain, patterns, plan
from witness.edges import START_LEVELS, changes

SWAPPED = ("FRINGE 1", "FRINGE 2")
LATE_COMMIT = 3           # of the burst, by more than its lead before the vblank
RECORD_LIMIT_US = 20
FOUND_LIMIT_US = 4000     # after its vblank: before the next pattern can have been asked for
RIG_FILE = Path(__file__).resolve().parents[2] / "firmware/board/vm.rig"


class Watched(NamedTuple):
    """One burst on a display. vblanks: {number: us}; images: {framebuffer: rows}; recorded_us: when
    the player says that its flips came."""
    shown: list
    vblanks: dict
    images: dict
    edges: list
    recorded_us: list


class Exposure(NamedTuple):
    """A step lit by the projector: what it asks for and what the display showed all through it."""
    step: int
    wanted: str
    framebuffers: list


def _recorded_us(text):
    """Times on the rig's clock of the vblanks in hil-play's output."""
    rows = [line.split() for line in text.splitlines()]
    zero_us = sum(float(row[1]) for row in rows if row[0] == "zero")
    return [zero_us + float(row[5]) for row in rows if row[:2] == ["edge", "VBLANK"]]


def read(folder, machine):
    """What the guest left of one watched burst, or a word why it cannot be judged."""
    exits = {name: (folder / name).read_text().strip() for name in ("exit", "watch-exit")}
    if exits != {"exit": "0", "watch-exit": "0"}:
        errors = [(folder / name).read_text().strip() for name in ("errors", "watch-errors")]
        return None, f"the player ended with {exits['exit']}, the watcher with " \
                     f"{exits['watch-exit']}: {'; '.join(filter(None, errors))}"
    pages = (folder / "trace").read_bytes()
    gpio_format = kernel_trace.read_format((machine / "gpio_value.format").read_text())
    line_names = kernel_trace.read_line_names((machine / "gpio").read_text())
    images = {int(file.name[3:]): display.read_framebuffer(file.read_bytes())
              for file in folder.glob("fb-*")}
    format_text = (folder / "drm_vblank_event.format").read_text()
    return Watched(display.read_shown((folder / "shown").read_text()),
                   display.vblanks(pages, format_text), images,
                   led_chain.split(kernel_trace.edges(pages, gpio_format, line_names))[1],
                   _recorded_us((folder / "record").read_text())), ""


def _shown_at(watched, t_us):
    """The framebuffer that the last flip up to then brought."""
    before = [shown for shown in watched.shown if shown.vblank_us <= t_us]
    return before[-1].framebuffer if before else 0


def exposures(burst_plan, watched, numbers):
    """Every exposure of the plan that the projector lights (retakes come after it): a flip reaches the subject `latency` later and has
    settled `settle` after that."""
    rises = [e.t_ns / 1e3 for e in watched.edges if e.line == "TRIGGER" and e.value]
    falls = [e.t_ns / 1e3 for e in watched.edges if e.line == "TRIGGER" and not e.value]
    found = []
    for step, rise_us, fall_us in zip(range(len(burst_plan.roles)), rises, falls):
        wanted = patterns.of_step(burst_plan.roles[step], burst_plan.indices[step])
        if wanted is None:
            continue
        delay_us = numbers["camera.start_delay_us"] - numbers["projector.latency_us"]
        first_us = rise_us + delay_us - numbers["projector.settle_us"]
        last_us = fall_us + delay_us
        during = [s.framebuffer for s in watched.shown if first_us < s.vblank_us < last_us]
        found.append(Exposure(step, wanted, [_shown_at(watched, first_us)] + during))
    return found


def wrong_exposures(burst_plan, watched, numbers):
    """([(step, wanted, what was shown)], pixels compared). A framebuffer is the pattern that it has
    every pixel of; of one that is none is told how many pixels differ from what was wanted."""
    drawn = {name: patterns.draw(numbers, name) for name in patterns.every_pattern()}

    def name_of(framebuffer, wanted):
        image = watched.images.get(framebuffer)
        if image is None:
            return "nothing"
        differ = display.differing_pixels(image, drawn[wanted])
        if differ == 0:
            return wanted
        others = [name for name in drawn if display.differing_pixels(image, drawn[name]) == 0]
        return others[0] if others else f"no pattern ({differ} pixels are not {wanted}'s)"

    wrong, pixels = [], 0
    for exposure in exposures(burst_plan, watched, numbers):
        pixels += len(drawn[exposure.wanted]) * len(drawn[exposure.wanted][0]) // 4
        names = {name_of(f, exposure.wanted) for f in exposure.framebuffers}
        if names != {exposure.wanted}:
            wrong.append((exposure.step, exposure.wanted, " then ".join(sorted(names))))
    return wrong, pixels


def flips(burst_plan, watched, goes_on=False):
    """[(planned edge, us from the plan)] of the vblank at which each planned flip really came, and
    faults where it did not: a step's framebuffer must first be shown at the vblank nearest to plan.
    Last, the burst's zero."""
    seen = [edge for edge in watched.edges if edge.line in compare.LINES]
    planned = [edge for edge in changes(burst_plan.edges, START_LEVELS)
               if edge.line in compare.LINES]
    result = compare.compare(burst_plan, seen[:len(planned)])  # what comes after it is retakes
    if result.order_fault:
        return [], [result.order_fault], 0
    zero_us = result.zero_ns / 1e3
    found, faults, before = [], [], None
    for edge in [edge for edge in burst_plan.edges if edge.line == "VBLANK"]:
        wanted = patterns.of_step(burst_plan.roles[edge.step], burst_plan.indices[edge.step])
        due_us = zero_us + edge.t_us
        number = min(watched.vblanks, key=lambda n: abs(watched.vblanks[n] - due_us))
        found.append((edge, watched.vblanks[number] - due_us))
        if wanted != before and number not in {shown.sequence for shown in watched.shown}:
            faults.append(f"step {edge.step}: {wanted} was not flipped to at vblank {number}")
        before = wanted
    return found, faults, zero_us


def _trace_agrees(watched):
    """The watcher's vblanks and the kernel's trace are two accounts of one thing."""
    return [f"vblank {s.sequence} is not as the kernel's trace has it" for s in watched.shown
            if s.sequence in watched.vblanks
            and abs(watched.vblanks[s.sequence] - s.vblank_us) > 1]


def _watch(evidence, name, key):
    """(what was watched, None), or (None, the result that says why nothing can be judged)."""
    if evidence.folder is None:
        return None, Result(name, [], [], skipped="the simulated rig has no display to look at")
    watched, fault = read(evidence.folder / key, evidence.folder / "machine")
    if not fault and not (watched.shown and any(e.line == "TRIGGER" for e in watched.edges)):
        fault = "nothing was shown, or no exposure was triggered"
    return watched, Result(name, [], [fault]) if fault else None


def shown_patterns(evidence, key="display"):
    """Every exposure saw its pattern, whole, and every flip came at its vblank."""
    name = "the display shows each exposure its pattern, pixel for pixel"
    watched, unjudged = _watch(evidence, name, key)
    if unjudged:
        return unjudged
    numbers = plan.read_numbers(RIG_FILE)
    wrong, pixels = wrong_exposures(evidence.plan, watched, numbers)
    faults = [f"step {step} wants {wanted}, {shown} was shown" for step, wanted, shown in wrong]
    judged = len(exposures(evidence.plan, watched, numbers))
    if judged != sum(patterns.of_step(r, 0) is not None for r in evidence.plan.roles):
        faults.append(f"only {judged} exposures under the projector were seen")
    # Before the burst and after it the display changes hands, which its witness may see late.
    triggers_us = [e.t_ns / 1e3 for e in watched.edges if e.line == "TRIGGER"]
    found_us = max((s.found_us - s.vblank_us for s in watched.shown
                    if triggers_us[0] <= s.vblank_us <= triggers_us[-1]), default=0)
    if watched.shown[0].framebuffer != watched.shown[-1].framebuffer:
        faults.append("after the burst the display does not show what it showed before")
    return Result(name, [
        Measure("exposures", judged, ""),
        Measure("framebuffers brought", len(watched.shown[1:-1]), ""),
        Measure("pixels compared", pixels / 1e6, "million"),
        Measure("latest look after a vblank in the burst", found_us, "us", FOUND_LIMIT_US)], faults)


def flip_times(evidence, key="display"):
    """Each flip within its refresh, and the player's record of it right."""
    name = "the display flips at the planned vblanks, and the player's record says so"
    watched, unjudged = _watch(evidence, name, key)
    if unjudged:
        return unjudged
    found, faults, zero_us = flips(evidence.plan, watched)
    faults += _trace_agrees(watched)
    off_us = [abs(t_us - edge.t_us - us - zero_us) for t_us, (edge, us) in
              zip(watched.recorded_us, found)]
    if len(watched.recorded_us) != len(found):
        faults.append(f"the record has {len(watched.recorded_us)} of {len(found)} flips")
    times = sorted(watched.vblanks.values())
    spacing_us = [b - a for a, b in zip(times, times[1:])]
    refresh_us = 1e6 / plan.read_numbers(RIG_FILE)["projector.refresh_hz"]
    return Result(name, [
        Measure("flips", len(found), ""),
        Measure("largest deviation from plan", max((abs(us) for _, us in found), default=0), "us",
                min((edge.tolerance_us for edge, _ in found), default=0)),
        Measure("largest error of the record", max(off_us, default=0), "us", RECORD_LIMIT_US),
        Measure("vblanks", len(times), ""),
        Measure("largest departure of a refresh from the rig file's",
                max((abs(us - refresh_us) for us in spacing_us), default=0), "us", refresh_us / 4),
    ], faults)


def swapped_fringes(evidence):
    """Two fringes shown one for the other: these two exposures and no other are wrong."""
    name = f"control: {SWAPPED[0]} and {SWAPPED[1]} are exchanged, and found"
    watched, unjudged = _watch(evidence, name, "control-swapped-fringes")
    if unjudged:
        return unjudged
    wrong, _ = wrong_exposures(evidence.plan, watched, plan.read_numbers(RIG_FILE))
    found = sorted((wanted, shown) for _, wanted, shown in wrong)
    right = found == [SWAPPED, SWAPPED[::-1]]
    return Result(name, [], [] if right else [f"the witness says: {found[:4]}"])


def late_flip(evidence):
    """One pattern asked for too late for its vblank: that flip and no other came elsewhere."""
    name = f"control: flip {LATE_COMMIT} is asked for after its vblank, and is missed there"
    watched, unjudged = _watch(evidence, name, "control-late-flip")
    if unjudged:
        return unjudged
    _, faults, _ = flips(evidence.plan, watched, goes_on=True)  # the rig takes that step again
    step = [edge.step for edge in evidence.plan.edges if edge.line == "VBLANK"][LATE_COMMIT]
    right = len(faults) == 1 and faults[0].startswith(f"step {step}: ")
    return Result(name, [], [] if right else [f"the witness says: {faults[:4]}"],
                  [f"found: {faults[0]}"] if right else [])
