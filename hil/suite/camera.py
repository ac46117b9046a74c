"""The cameras: each photograph that the rig keeps is the picture of the light that there was."""
import re
import subprocess
from pathlib import Path
from typing import NamedTuple

from suite import pictures
from suite.light import digest
from suite.pictures import CARD
from suite.report import Measure, Result
from witness import kernel_trace, led_chain, plan

PROTO = Path(__file__).resolve().parents[2] / "proto"
STEPS = 20
DROPPED_EXPOSURE = 7  # counted by the feeder
SWAPPED = ("GRADIENT_X", "GRADIENT_Y")
UNKNOWN, SHORT_PULSE = ("FRINGE", 3), 1


class Photograph(NamedTuple):
    """One that the rig keeps: what it says of it, and the key of the state whose picture it is, to the last
    pixel; None where it is nobody's."""
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


class Recorded(NamedTuple):
    """The burst that recorded the states. expected: {subject: key}; shots: the two subjects of each exposure,
    account: what the feeder says of it; before: how many exposures the daemon's self-test made."""
    expected: dict
    shots: list
    account: list
    before: int


class Fed(NamedTuple):
    """What the feeder decoded of one exposure. keys: of the left and the right camera."""
    keys: tuple
    leds: str


def _photograph(record, known):
    message = subprocess.run(
        ["protoc", "--decode=lamella.v1.FrameOffer", f"-I{PROTO}", "link.proto"],
        input=record.read_bytes()[8:-4], check=True, capture_output=True).stdout.decode()
    frame = plan.parse_text(message)["frame"][0]
    return Photograph(frame["camera"][0], frame["role"][0], int(frame.get("index", ["0"])[0]),
                      frame["analyser"][0], float(frame.get("trigger_us", ["0"])[0]),
                      known.get(record.with_suffix(".raw").read_bytes()))


def photographs(folder, known):
    """Every photograph of a burst's store. known: {packed bytes: key} of pictures."""
    return [_photograph(record, known) for record in sorted(folder.glob("store/*/frame-*.record"))]


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


def _in_turn(taken, camera):
    return sorted((p for p in taken if p.camera == camera), key=lambda p: p.trigger_us)


def recorded(folder):
    """Its pictures were test cards: a subject is told from the order of the triggers."""
    every = fed((folder / "feeder").read_text())
    account, by_camera = every[-STEPS:], []
    for camera in ("left", "right"):
        taken = _in_turn(photographs(folder, {}), camera)
        if len(taken) != len(account):
            raise ValueError(f"{len(account)} exposures, {len(taken)} photographs of {camera}")
        by_camera.append([p.subject for p in taken])
    shots = list(zip(*by_camera))
    expected = {subject: key for subjects, exposure in zip(shots, account)
                for subject, key in zip(subjects, exposure.keys)}
    return Recorded(expected, shots, account, len(every) - len(account))


def _led_digests(folder, machine):
    """Of each frame that the bus brought, by the suite's own decoder."""
    edges = kernel_trace.edges((folder / "trace").read_bytes(),
                               kernel_trace.read_format((machine / "gpio_value.format").read_text()),
                               kernel_trace.read_line_names((machine / "gpio").read_text()))
    return [digest(frame.bits) for frame in led_chain.frames(led_chain.split(edges)[1])]


def wrong(taken, expected):
    """[(subject, expected key, its key)] of the photographs that are of another light."""
    return [(p.subject, expected.get(p.subject), p.key) for p in taken
            if p.key != expected.get(p.subject)]


def _words(faults):
    return [f"{' '.join(map(str, subject))} shows {key or 'no known picture'}, not {right}"
            for subject, right, key in faults[:4]]


def _judge(evidence, name, key, judge):
    """judge(what the recording burst left, what this one did, its photographs)."""
    if evidence.folder is None:
        return Result(name, [], [], skipped="the simulated rig's photographs come from the twin")
    first, folder = evidence.folder / "camera-record", evidence.folder / key
    refusals = list(filter(None, map(_refusal, (first, folder))))
    if refusals:
        return Result(name, [], refusals)
    try:
        known = pictures.read(evidence.folder / "known")
        return judge(first, folder, photographs(folder, known))
    except ValueError as why:
        return Result(name, [], [str(why)])


def right_pictures(evidence):
    """40 photographs, each of its own light, and the feeder's decoding held against the suite's."""
    name = "40 photographs, each of the light that its step asks for"

    def judge(first, folder, taken):
        expected, _, account, _ = recorded(first)
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

    def judge(first, folder, taken):
        expected = recorded(first).expected
        swapped = {(c, role, i, a): expected[c, other.get(role, role), i, a]
                   for c, role, i, a in expected}
        faults = _words(wrong(taken, swapped))
        touched = wrong(taken, expected)
        if len(touched) != 8:
            faults.append(f"{len(touched)} photographs changed, not the 8 of these steps")
        return Result(name, [Measure("photographs exchanged", len(touched), "")], faults)

    return _judge(evidence, name, "camera-swapped", judge)


def unknown_light(evidence):
    """What was never recorded is the test card, in both cameras, and nothing else is."""
    name = (f"control: {UNKNOWN[0]} {UNKNOWN[1]} with another period, and LEDs that shine for 1.5 ms less, "
            "are unknown states: test cards")

    def judge(first, folder, taken):
        _, shots, account, _ = recorded(first)
        if len(taken) != 2 * STEPS:
            return Result(name, [], [f"{len(taken)} photographs, not {2 * STEPS}"])
        lit = [number for number, exposure in enumerate(account) if int(exposure.leds, 16)]
        faults, seen = [], 0
        for place, camera in enumerate(("left", "right")):
            for number, photograph in enumerate(_in_turn(taken, camera)):
                unknown = shots[number][place][1:3] == UNKNOWN or number == lit[SHORT_PULSE]
                right = CARD if unknown else account[number].keys[place]
                faults += _words(wrong([photograph], {photograph.subject: right}))
                seen += photograph.key == CARD
        return Result(name, [Measure("test cards", seen, "")],
                      faults + ([] if seen == 4 else [f"{seen} test cards, not 4"]))

    return _judge(evidence, name, "camera-unknown", judge)


def dropped_frame(evidence):
    """A frame that never comes: the rig says which, takes it again, and mixes up no other."""
    name = "one frame never reaches the left camera: told, and taken again"

    def judge(first, folder, taken):
        expected, _, _, before = recorded(first)
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
