"""Target HOST: a real rig, asked over its link and judged by a logic analyser on its lines and a
photodiode at its subject. What the rig says of itself is told apart, and passes nothing alone."""

import time
from pathlib import Path
from typing import NamedTuple, Optional

from suite import scenes
from suite.evidence import Burst, Evidence
from suite.photodiode import light
from suite.report import Measure, Result
from suite.rig_link import Rig, Told, read_timing
from witness import analyser, clocks, compare, led_chain, plan, vcd
from witness.edges import START_LEVELS

BUS = ("SPI_SCK", "SPI_MOSI")
NEEDED = ("BLANK", "LATCH", "TRIGGER", "ANALYSER")
SAME_TIME_US = 0.5  # of a rig's plan and its rig file's: both are the firmware's arithmetic
DRIFT_LIMIT_PPM = 300  # of two quartzes, each at its worst
SAMPLES_OF_A_BIT = 4
MARGIN_S = 5  # of a recording, for the link to be opened and the burst to begin
FILE_WAIT_S = 120


class Wanted(NamedTuple):
    """What the command line asks for. witness: a file, else driver and samplerate, or none."""

    address: str
    rig_file: Path
    channels: Optional[dict]
    witness: Optional[Path]
    driver: Optional[str]
    samplerate_hz: float
    session: Optional[Path]  # taken already: no burst is asked for
    selftest: list  # parts; none: all of them


class Gathered(NamedTuple):
    """What a burst left: the rig's word and, where there was a witness, its recording."""

    told: Told
    plans: list  # of the rig file, from either rest of the analyser
    recording: Optional[vcd.Recording]
    sample_ns: Optional[float]


# --- The rig's own word ---


def selftest(rig, parts):
    """What the rig finds when it tests itself."""
    only = [word for part in parts for word in ("--only", part)]
    _, told = rig.ask("rig", "selftest", *only)
    faults = [
        f"{r['part']}: {r['what']}: {r.get('value', '')} {r.get('unit', '')} "
        f"{r.get('note', '')}".strip()
        for r in told["readings"]
        if r["verdict"] == "BAD"
    ]
    faults += [] if told["readings"] else ["it tested nothing"]
    return Result(
        "self-reported: the rig's self-test",
        [
            Measure("readings", len(told["readings"]), ""),
            Measure("readings that are bad", told["bad"], "", 0),
        ],
        faults,
    )


def planned_as_filed(gathered):
    """The burst is the one that the rig file asks for: the witness is held against no other."""
    name = "the rig planned what its rig file asks for"
    told = gathered.told.planned
    for filed in gathered.plans:
        pairs = list(zip(filed.edges, told))
        apart_us = max((abs(a.t_us - b.t_us) for a, b in pairs), default=0)
        if (
            len(told) >= len(filed.edges)
            and all(a[2:4] == b[2:4] for a, b in pairs)
            and apart_us < SAME_TIME_US
        ):
            return Result(
                name,
                [
                    Measure("edges", len(filed.edges), ""),
                    Measure("largest difference", apart_us, "us"),
                ],
                [],
            )
    return Result(
        name, [], [f"its {len(told)} planned edges are not those of the file: is it the rig's own?"]
    )


# --- The witness ---


def _lines(recording):
    return tuple(line for line in compare.LINES if line in recording.levels)


def place(gathered):
    """(the burst's edges on the rig's clock, that Clock, fault)."""
    recording = gathered.recording
    record = gathered.told.record
    found = clocks.find_burst(recording, record.edges, record.zero_us * 1e3)
    if found is None:
        return [], None, "the witness saw no TRIGGER"
    levels, edges = found
    wrong = [
        f"{line} is {levels[line]}"
        for line, level in START_LEVELS.items()
        if levels.get(line, level) != level
    ]
    if wrong:
        return [], None, f"before the burst {', '.join(wrong)}: is a channel inverted (D0=!LINE)?"
    recorded = [e for e in gathered.told.record.edges if e.line in _lines(recording)]
    seen = [e for e in edges if e.line in _lines(recording)]
    clock = clocks.fit(seen, recorded) if seen and recorded else None
    if clock is None:
        return [], None, "the witness saw no edge of the burst"
    return [clock.edge(e) for e in edges], clock, None


def clock_scene(clock, sample_ns):
    """A record that runs at another speed than its witness is not of the same burst."""
    notes = [f"one sample of the witness is {sample_ns:.1f} ns"] if sample_ns else []
    return Result(
        "the witness's clock and the rig's go together",
        [Measure("drift fitted", abs(clock.drift_ppm), "ppm", DRIFT_LIMIT_PPM)],
        [],
        notes,
    )


def record_is_true(evidence):
    """The player's own record of each edge, held against what the analyser saw."""
    burst = evidence.bursts["burst"]
    name = "the rig's own record of its edges is true"
    recorded = [e for e in burst.record.edges if e.line in burst.lines]
    seen = [e for e in burst.edges if e.line in burst.lines]
    if [e[1:] for e in recorded] != [e[1:] for e in seen]:
        return Result(
            name,
            [],
            [f"{len(recorded)} edges are recorded, {len(seen)} were seen, or in another order"],
        )
    apart = [
        (abs(a.t_ns - b.t_ns) / 1e3, a.line, i) for i, (a, b) in enumerate(zip(recorded, seen))
    ]
    worst_us, line, number = max(apart)
    return Result(
        name,
        [
            Measure("edges", len(apart), ""),
            Measure(
                f"largest difference, {line}, edge {number}", worst_us, "us", scenes.RECORD_LIMIT_US
            ),
        ],
        [],
    )


def led_bits(evidence, bit_ns, sample_ns):
    """The LED frames, where the analyser is on the chain's bus and quick enough for it."""
    names = (
        "every LED frame's bits are right, loaded in the dark",
        "sigrok-cli decodes the same bytes from the VCD",
    )
    why = ""
    if evidence.bursts["burst"].frames is None:
        why = "no channel is on SPI_SCK and SPI_MOSI"
    elif sample_ns and bit_ns < SAMPLES_OF_A_BIT * sample_ns:
        why = (
            f"a bit of {bit_ns:.0f} ns needs {SAMPLES_OF_A_BIT} samples; "
            f"one is {sample_ns:.0f} ns: "
            "raise --samplerate or lower leds.spi_hz"
        )
    if why:
        return [Result(name, [], [], skipped=why) for name in names]
    return [scenes.led_frames(evidence), scenes.second_decoder(evidence)]


# --- All together ---


def _evidence(gathered, edges, wanted, out):
    lines = _lines(gathered.recording)
    has_bus = all(line in gathered.recording.levels for line in BUS)
    dump = out / "witness-lines.vcd"
    vcd.write(dump, edges, BUS + lines)
    burst = Burst(
        edges,
        lines,
        gathered.told.record,
        frames=led_chain.frames(edges) if has_bus else None,
        vcd_file=str(dump) if has_bus else None,
    )
    return Evidence(
        wanted.address,
        plan.Plan(gathered.told.planned, gathered.plans[0].roles),
        plan.read_leds(wanted.rig_file),
        {"burst": burst},
        {},
        {},
    )


def judge(gathered, wanted, out):
    """Every scene that a witness can judge."""
    if gathered.recording is None:
        return [
            Result(
                "order and time of every edge",
                [],
                ["self-reported: no witness was given (--witness FILE, or --driver)"],
            )
        ]
    missing = [line for line in NEEDED if line not in gathered.recording.levels]
    if missing:
        return [
            Result(
                "the witness's channels",
                [],
                [f"no channel is on {', '.join(missing)}: see --channels"],
            )
        ]
    edges, clock, fault = place(gathered)
    if fault:
        return [Result("the burst in the witness's recording", [], [fault])]
    evidence = _evidence(gathered, edges, wanted, out)
    bit_ns = 1e9 / plan.read_numbers(wanted.rig_file)["leds.spi_hz"]
    return [
        clock_scene(clock, gathered.sample_ns),
        scenes.edges(evidence, ", as the analyser saw them"),
        record_is_true(evidence),
        *led_bits(evidence, bit_ns, gathered.sample_ns),
        light(edges, "LIGHT" in gathered.recording.levels),
    ]


# --- The burst ---


def _plans(rigd, rig_file, proto, out):
    return [
        plan.read(rigd, rest, proto)
        for rest in (rig_file, plan.other_rest(rig_file, out / "other-rest"))
    ]


def _await_file(path, since_unix_s, say):
    """A recording that somebody else saves; one that is older than the burst is of another."""
    say(f"waiting for {path}: save the recording there")
    deadline_s = time.monotonic() + FILE_WAIT_S
    while not (path.exists() and path.stat().st_mtime >= since_unix_s):
        if time.monotonic() > deadline_s:
            raise analyser.AnalyserError(
                f"{path}: nobody saved a recording of this burst there in {FILE_WAIT_S} s"
            )
        time.sleep(0.2)


def _burst(rig, session):
    """A burst into a new session; what the rig says of it."""
    status, told = rig.ask("capture", "--out", session, "--flashing-confirmed", "--replace")
    faults = (
        [] if status == 0 else [f"{told['verdict']}; to be retaken: {', '.join(told['marked'])}"]
    )
    return Result(
        "self-reported: the burst",
        [Measure("photographs", told["frames"], ""), Measure("late edges", told["late_edges"], "")],
        faults,
        [told["verdict"]],
    )


def _witnessed_burst(rig, wanted, session, longest_s, say):
    """(the burst's Result, Recording or None, nanoseconds of a sample or None)."""
    if wanted.driver:
        record = analyser.Analyser(
            wanted.driver,
            wanted.samplerate_hz,
            wanted.channels,
            longest_s,
            session.parent / "witness.vcd",
        )
        with record:
            say(f"burst, {wanted.driver} records for {longest_s:.0f} s")
            result = _burst(rig, session)
            record.finish()
        return result, analyser.read(record.path, wanted.channels), 1e9 / wanted.samplerate_hz
    began_unix_s = time.time()
    say("burst")
    result = _burst(rig, session)
    if wanted.witness:
        _await_file(wanted.witness, began_unix_s, say)
    return result, wanted.witness and analyser.read(wanted.witness, wanted.channels), None


def run(wanted, programs, proto, out, say):
    """Asks the rig for a burst (or takes one that was taken) and judges it; every Result."""
    rigd = programs / "lamella-rigd"
    plans = _plans(rigd, wanted.rig_file, proto, out)
    if wanted.session:
        session, results = wanted.session, []
        recording, sample_ns = (
            wanted.witness and analyser.read(wanted.witness, wanted.channels),
            None,
        )
    else:
        rig = Rig(programs / "lamella", wanted.address)
        say("self-test")
        results = [selftest(rig, wanted.selftest)]
        session = out / "session"
        longest_s = plans[0].edges[-1].t_us * 1e-6 + MARGIN_S
        result, recording, sample_ns = _witnessed_burst(rig, wanted, session, longest_s, say)
        results.append(result)
    say("witness")
    gathered = Gathered(read_timing(session), plans, recording, sample_ns)
    return results + [planned_as_filed(gathered)] + judge(gathered, wanted, out)
