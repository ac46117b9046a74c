"""The cameras: each photograph that the rig keeps is the picture of the light that there was."""
import re
import subprocess
from pathlib import Path
from typing import NamedTuple

from suite.report import Measure, Result
from witness import kernel_trace, led_chain, plan

PROTO = Path(__file__).resolve().parents[2] / "proto"
KEY_BITS = 64
STEPS = 20
DARKEST_OF_BRIGHT, BRIGHTEST_OF_DARK = 2300, 900  # 12-bit steps; the test card is between
CARD = "test card"
DROPPED_EXPOSURE = 7  # counted by the feeder
SWAPPED = ("GRADIENT_X", "GRADIENT_Y")
UNKNOWN = ("FRINGE", 3)


class Photograph(NamedTuple):
    """One that the rig keeps: what it says of it, and the key in its pixels."""
    camera: str
    role: str
    index: int
    analyser: str
    trigger_us: float
    key: str

    @property
    def subject(self):
        """What it is of, whichever place in the burst it has."""
        return self.camera, self.role, self.index, self.analyser


class Fed(NamedTuple):
    """What the feeder decoded of one exposure. keys: of the left and the right camera."""
    keys: tuple
    leds: str


def samples(raw, count):
    """The first samples of a 12-bit packed photograph."""
    values = []
    for i in range(0, count, 2):
        a, b, c = raw[i // 2 * 3:i // 2 * 3 + 3]
        values += [a | (b & 15) << 8, b >> 4 | c << 4]
    return values[:count]


def key_in(raw):
    """The key that a picture carries in its first row, CARD, or None for neither."""
    values = samples(raw, KEY_BITS)
    if all(BRIGHTEST_OF_DARK < value < DARKEST_OF_BRIGHT for value in values):
        return CARD
    if any(BRIGHTEST_OF_DARK < value < DARKEST_OF_BRIGHT for value in values):
        return None
    return f"{sum((value > DARKEST_OF_BRIGHT) << bit for bit, value in enumerate(values)):016x}"


def _photograph(record):
    message = subprocess.run(
        ["protoc", "--decode=lamella.v1.FrameOffer", f"-I{PROTO}", "link.proto"],
        input=record.read_bytes()[8:-4], check=True, capture_output=True).stdout.decode()
    frame = plan.parse_text(message)["frame"][0]
    return Photograph(frame["camera"][0], frame["role"][0], int(frame.get("index", ["0"])[0]),
                      frame["analyser"][0], float(frame.get("trigger_us", ["0"])[0]),
                      key_in(record.with_suffix(".raw").read_bytes()))


def photographs(folder):
    """Every photograph of a burst's store."""
    return [_photograph(record) for record in sorted(folder.glob("frame-*.record"))]


def fed(text):
    """The feeder's account, an exposure each."""
    return [Fed((row[2], row[3]), row[5]) for row in map(str.split, text.splitlines())
            if row[0] == "frame"]


def _refusal(folder):
    exits = {name: (folder / name).read_text().strip() for name in ("exit", "feeder-exit")}
    if exits == {"exit": "0", "feeder-exit": "0"}:
        return ""
    told = [(folder / name).read_text().strip() for name in ("errors", "feeder-errors", "rigd.log")]
    return "; ".join(filter(None, told)) or f"ended with {exits}"


def recorded(folder):
    """{subject: key} of the burst that recorded the states, the feeder's account of it, and how many
    exposures came before, from the daemon's self-test. Its pictures were test cards: a subject is
    told from the order of the triggers."""
    every = fed((folder / "feeder").read_text())
    account, expected = every[-STEPS:], {}
    for place, camera in enumerate(("left", "right")):
        taken = sorted((p for p in photographs(folder) if p.camera == camera),
                       key=lambda p: p.trigger_us)
        if len(taken) != len(account):
            raise ValueError(f"{len(account)} exposures, {len(taken)} photographs of {camera}")
        expected.update({p.subject: exposure.keys[place] for p, exposure in zip(taken, account)})
    return expected, account, len(every) - len(account)


def digest(bits):
    """FNV-1a of one byte a bit: what the feeder calls a frame of LED codes."""
    value = 0xcbf29ce484222325
    for bit in bits:
        value = (value ^ bit) * 0x100000001b3 & (1 << 64) - 1
    return f"{value:016x}"


def _led_digests(folder, machine):
    """Of each frame that the bus brought, by the suite's own decoder."""
    edges = kernel_trace.edges((folder / "trace").read_bytes(),
                               kernel_trace.read_format((machine / "gpio_value.format").read_text()),
                               kernel_trace.read_line_names((machine / "gpio").read_text()))
    return [digest(frame.bits) for frame in led_chain.frames(edges)]


def wrong(taken, expected):
    """[(subject, expected key, its key)] of the photographs that are of another light."""
    return [(p.subject, expected.get(p.subject), p.key) for p in taken
            if p.key != expected.get(p.subject)]


def _words(faults):
    return [f"{' '.join(map(str, subject))} shows {key}, not {right}"
            for subject, right, key in faults[:4]]


def _judge(evidence, name, key, judge):
    if evidence.folder is None:
        return Result(name, [], [], skipped="the simulated rig's photographs come from the twin")
    folders = evidence.folder / "camera-record", evidence.folder / key
    refusals = list(filter(None, map(_refusal, folders)))
    if refusals:
        return Result(name, [], refusals)
    try:
        return judge(*folders)
    except ValueError as why:
        return Result(name, [], [str(why)])


def right_pictures(evidence):
    """40 photographs, each of its own light, and the feeder's decoding held against the suite's."""
    name = "40 photographs, each of the light that its step asks for"

    def judge(first, folder):
        expected, account, _ = recorded(first)
        taken = photographs(folder)
        faults = _words(wrong(taken, expected))
        left = {key for subject, key in expected.items() if subject[0] == "left"}
        decoded = [exposure.leds for exposure in account if int(exposure.leds, 16)]
        witnessed = _led_digests(first, evidence.folder / "machine")
        if decoded != witnessed:
            faults.append("the feeder decodes other LED codes than the witness of the bus")
        if len(taken) != 2 * STEPS or {p.subject for p in taken} != set(expected):
            faults.append(f"{len(taken)} photographs, not one of each of {len(expected)} subjects")
        return Result(name, [
            Measure("photographs", len(taken), ""),
            Measure("of another light", len(wrong(taken, expected)), "", 0),
            Measure("states of the left camera told apart", len(left), ""),
            Measure("LED frames decoded as the witness does", len(witnessed), "")], faults + (
                [] if len(left) == STEPS else [f"{len(left)} states of {STEPS} steps"]))

    return _judge(evidence, name, "camera-play", judge)


def swapped_light(evidence):
    """Two gradients with each other's light: their pictures are exchanged, no other is touched."""
    name = f"control: {SWAPPED[0]} and {SWAPPED[1]} exchange their light, and so their pictures"
    other = {SWAPPED[0]: SWAPPED[1], SWAPPED[1]: SWAPPED[0]}

    def judge(first, folder):
        expected = recorded(first)[0]
        taken = photographs(folder)
        swapped = {(c, role, i, a): expected[c, other.get(role, role), i, a]
                   for c, role, i, a in expected}
        faults = _words(wrong(taken, swapped))
        touched = wrong(taken, expected)
        if len(touched) != 8:
            faults.append(f"{len(touched)} photographs changed, not the 8 of these steps")
        return Result(name, [Measure("photographs exchanged", len(touched), "")], faults)

    return _judge(evidence, name, "camera-swapped", judge)


def unknown_light(evidence):
    """A pattern that was never recorded is the test card, in both cameras, and nothing else is."""
    name = f"control: {UNKNOWN[0]} {UNKNOWN[1]} with another period is an unknown state: test card"

    def judge(first, folder):
        expected = recorded(first)[0]
        cards = {subject: CARD for subject in expected if subject[1:3] == UNKNOWN}
        taken = photographs(folder)
        seen = sum(p.key == CARD for p in taken)
        return Result(name, [Measure("test cards", seen, "")],
                      _words(wrong(taken, {**expected, **cards})) +
                      ([] if seen == 2 else [f"{seen} test cards, not 2"]))

    return _judge(evidence, name, "camera-unknown", judge)


def dropped_frame(evidence):
    """A frame that never comes: the rig says which, takes it again, and mixes up no other."""
    name = "one frame never reaches the left camera: told, and taken again"

    def judge(first, folder):
        expected, _, before = recorded(first)
        taken = photographs(folder)
        log = (folder / "rigd.log").read_text()
        told = re.findall(r"shot (\d+), camera (\d): dropped", log)
        faults = _words(wrong(taken, expected))
        if told != [(str(DROPPED_EXPOSURE - before), "0")]:
            faults.append(f"the rig says that shots {told} were dropped")
        missing = set(expected) - {p.subject for p in taken}
        faults += [f"there is no {' '.join(map(str, subject))}" for subject in sorted(missing)]
        exposures = len(fed((folder / "feeder").read_text()))
        return Result(name, [Measure("exposures of the burst", exposures - before, ""),
                             Measure("photographs", len(taken), "")], faults)

    return _judge(evidence, name, "camera-dropped", judge)
