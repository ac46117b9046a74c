"""The kernel's own simulated cameras, read by the firmware's camera code; and a TRIGGER that is active low."""
import re
from typing import NamedTuple

from suite.report import Measure, Result
from suite.scenes import LIGHTS_OFF_LIMIT_US
from suite.twin import unpacked
from witness import compare, kernel_trace, led_chain

WIDTH_PX, HEIGHT_PX = 320, 180
VIMC_WIDTH_PX, VIMC_ROW = 480, 300  # below the text that vimc writes
DEPTHS = ("8", "10", "12", "16")
MONO = ("GREY", "Y10", "Y12", "Y16")
BAYER = tuple(order + bits for bits in DEPTHS for order in ("SRGGB", "SGRBG", "SGBRG", "SBGGR"))
#The bars of the test picture, left to right, at three quarters of full scale.
BARS = ("RGB", "RG", "GB", "G", "RB", "R", "B", "")
BRIGHT, DARK = (2900, 3200), (0, 100)  # 12-bit steps
FALLING_GREY = 60   # by so much each bar is darker than the one before
TAKEN, STARVED_AT, AGAIN = 12, 2, 3
DROPS, DROPPED = 8, 3
LEAST_WAIT_US, LONGEST_WAIT_US = 200e3, 400e3
NOT_HERE = "the simulated rig has no kernel"


class Shot(NamedTuple):
    """What the firmware said of one shot."""
    number: int
    status: str
    waited_us: float
    why: str


def read_shots(text):
    """shoot_camera's output."""
    rows = [line.split(" ", 4) for line in text.splitlines()]
    return [Shot(int(row[1]), row[2], float(row[3]), row[4].strip()) for row in rows]


def _scene(evidence, key):
    """Exit status, shots and the word of a refusal."""
    folder = evidence.folder / key
    return (int((folder / "exit").read_text()), read_shots((folder / "shots").read_text()),
            (folder / "errors").read_text().strip())


def _unwell(key, scene, shots):
    status, taken, error = scene
    bad = [shot for shot in taken if shot.status != "ok"]
    if status != 0 or len(taken) != shots or bad:
        return [f"{key}: exit {status}, {len(taken)} of {shots} shots, "
                f"{bad[0].why if bad else error or 'no word why'}"]
    return []


def _pixel(values, width, x, y):
    return values[y * width + x]


def wrong_bars(name, values):
    """What of a picture of bars is not as `name`, a format of V4L2, would have it, in words."""
    bar_px, y = WIDTH_PX // len(BARS), HEIGHT_PX - 10
    middles = [bar * bar_px + bar_px // 2 for bar in range(len(BARS))]
    if name in MONO:
        grey = [_pixel(values, WIDTH_PX, x, y) for x in middles]
        falls = all(a - b >= FALLING_GREY for a, b in zip(grey, grey[1:]))
        ends = BRIGHT[0] < grey[0] < BRIGHT[1] and DARK[0] <= grey[-1] <= DARK[1]
        return [] if falls and ends else [f"{name}: the bars are {grey}"]
    wrong = []
    for bar, x in zip(BARS, middles):
        for place, colour in enumerate(name[1:5]):
            value = _pixel(values, WIDTH_PX, x + place % 2, y + place // 2)
            low, high = BRIGHT if colour in bar else DARK
            if not low <= value <= high:
                wrong.append(f"{name}: {colour} of bar '{bar}' is {value}")
    return wrong


def formats(evidence):
    """Each format that the rig file may name and vivid has, once, unpacked to the right colours."""
    name = "V4L2: bars of vivid in 8, 10, 12 and 16 bits, mono and each Bayer order"
    if evidence.folder is None:
        return Result(name, [], [], skipped=NOT_HERE)
    faults = []
    for key in MONO + BAYER:
        scene = f"vivid-{key}"
        unwell = _unwell(scene, _scene(evidence, scene), 1)
        raw = (evidence.folder / scene / "picture").read_bytes() if not unwell else b""
        faults += unwell or wrong_bars(key, unpacked(raw))
    return Result(name, [Measure("formats", len(MONO + BAYER), "")], faults[:4])


def _drop(evidence, key, pattern):
    status, shots, error = _scene(evidence, key)
    dropped = [(shot.number, shot.why) for shot in shots if shot.status != "ok"]
    if status != 0 or len(shots) != DROPS:
        return [f"{key}: exit {status}, {len(shots)} of {DROPS} shots: {error}"]
    if [number for number, _ in dropped] != [DROPPED]:
        return [f"{key}: shots {[number for number, _ in dropped]} were dropped, not {DROPPED}"]
    return [] if re.search(pattern, dropped[0][1]) else [f"{key}: the rig says '{dropped[0][1]}'"]


def dropped_buffer(evidence):
    """vivid drops one frame: a gap in its sequence, told as such, and the next shots have their own."""
    name = "V4L2: a frame that vivid drops is told as a gap in the sequence, whether stamps tell shots apart or not"
    if evidence.folder is None:
        return Result(name, [], [], skipped=NOT_HERE)
    faults = _drop(evidence, "vivid-drop", r"the frame of shot \d+ was dropped, a gap of 1 in the sequence: "
                   r"the next, number \d+, is stamped \d+ us too late$")
    faults += _drop(evidence, "vivid-drop-late", r"a gap of 1 in the sequence before shot \d+: dropped, or not")
    return Result(name, [Measure("frames dropped", 2, ""), Measure("shots", 2 * DROPS, "")], faults)


def _vimc_bars(raw):
    """The first bars of vimc's picture: three bytes a pixel, of which the rig took a third of each row."""
    row = unpacked(raw)[VIMC_WIDTH_PX * VIMC_ROW:VIMC_WIDTH_PX * (VIMC_ROW + 1)]
    found = []
    for x in (30, 90, 150):
        colours = "RGB"
        found.append("".join(c for c, v in zip(colours, row[3 * x:3 * x + 3]) if BRIGHT[0] < v < BRIGHT[1]))
    return found


def libcamera(evidence):
    """Frames through libcamera and the plug-in, each its shot's; wishes that it cannot grant are told."""
    name = "libcamera: frames of vimc through the plug-in, loaded at run time"
    if evidence.folder is None:
        return Result(name, [], [], skipped=NOT_HERE)
    faults = _unwell("vimc", _scene(evidence, "vimc"), TAKEN)
    faults += _unwell("vimc-again", _scene(evidence, "vimc-again"), AGAIN)
    bars = _vimc_bars((evidence.folder / "vimc/picture").read_bytes()) if not faults else []
    if bars and bars != list(BARS[:3]):
        faults.append(f"the first bars are {bars}, not {list(BARS[:3])}")
    for key, told in (("vimc-refused", "gives 480x360-BGR888, not camera.format"),
                      ("vimc-nobody", "no camera of that name: `cam -l` lists them")):
        status, _, error = _scene(evidence, key)
        if status != 1 or not error.endswith(told):
            faults.append(f"{key}: exit {status}: {error}")
    return Result(name, [Measure("frames", TAKEN + AGAIN, "")], faults)


def starved(evidence):
    """A camera that no longer delivers is a time-out, which is told, and is none when it is there again."""
    name = "libcamera: a camera that stops delivering is a time-out, told in words"
    if evidence.folder is None:
        return Result(name, [], [], skipped=NOT_HERE)
    status, shots, error = _scene(evidence, "vimc-starved")
    lost = [shot for shot in shots if shot.status != "ok"]
    if status != 0 or not lost or [s.status for s in shots[:STARVED_AT]] != ["ok"] * STARVED_AT:
        return Result(name, [], [f"exit {status}, {shots}: {error}"])
    faults = [f"the rig says '{shot.why}'" for shot in lost
              if not re.search(r"no frame of shot \d+: it was dropped, or the trigger did not reach", shot.why)]
    if not LEAST_WAIT_US <= lost[0].waited_us <= LONGEST_WAIT_US:
        faults.append(f"it was waited for {lost[0].waited_us / 1e3:.0f} ms")
    return Result(name, [Measure("waited for the frame", lost[0].waited_us / 1e3, "ms")], faults)


def _edges(evidence, key):
    """Those of the burst itself."""
    machine = evidence.folder / "machine"
    edges = kernel_trace.edges((evidence.folder / key / "trace").read_bytes(),
                               kernel_trace.read_format((machine / "gpio_value.format").read_text()),
                               kernel_trace.read_line_names((machine / "gpio").read_text()))
    return led_chain.split(edges)[1]


def upside_down(edges, line):
    """The edges, those of one line the other way round."""
    return [edge._replace(value=1 - edge.value) if edge.line == line else edge for edge in edges]


def active_low(evidence):
    """TRIGGER is 1 at rest and 0 for each exposure, also when the sequencer is killed within one."""
    name = "a TRIGGER that is active low: 1 at rest, 0 for each exposure, 1 again after kill -9 in one"
    if evidence.folder is None:
        return Result(name, [], [], skipped=NOT_HERE)
    folder = evidence.folder / "active-low"
    if (folder / "exit").read_text().strip() != "0":
        return Result(name, [], [f"no burst: {(folder / 'errors').read_text().strip()}"])
    rests = (folder / "rests").read_text().split()
    found = compare.compare(evidence.plan, upside_down(_edges(evidence, "active-low"), "TRIGGER"))
    faults = [found.order_fault] if found.order_fault else []
    if rests != ["1", "1"]:
        faults.append(f"at rest, before and after a burst, TRIGGER was {rests}")
    if compare.compare(evidence.plan, _edges(evidence, "active-low")).order_fault is None:
        faults.append("TRIGGER's edges are those of an active-high one too")
    after = [edge.value for edge in _edges(evidence, "active-low-killed") if edge.line == "TRIGGER"]
    if after[-2:] != [0, 1]:
        faults.append(f"killed in an exposure, TRIGGER's last edges are {after[-2:]}")
    told = (evidence.folder / "active-low-killed/light").read_text().split()
    if told[:1] != ["off"]:
        return Result(name, [], faults + [f"lights after the kill: {' '.join(told)}"])
    largest = compare.largest(found.deviations, "TRIGGER")
    return Result(name, [Measure("exposures", sum(edge.value for edge in evidence.plan.edges
                                                  if edge.line == "TRIGGER"), ""),
                         Measure("largest deviation of TRIGGER", abs(largest.us) if largest else 0, "us", 20),
                         Measure("lights off after kill -9", float(told[1]), "us", LIGHTS_OFF_LIMIT_US)], faults)
