"""The rig's package on a machine whose first process is systemd. Judged by what dpkg, systemd and the kernel
say, by lines and by pictures; the daemon's own words are held against them."""
import re

from suite import vm
from suite.camera import STEPS, photographs, recorded
from suite.pictures import CARD, CARD_DN
from suite.report import Measure, Result
from suite.twin import packed
from witness.edges import Edge, changes
from witness.kernel_trace import read_line_names

OWNERS = {"/dev/gpiochip1": "root gpio 660", "/dev/spidev0.0": "root spi 660",
          "/dev/dri/card0": "root video 660", "/dev/video0": "root video 660",
          "/dev/video1": "root video 660", "/dev/cpu_dma_latency": "root lamella 660"}
LIGHTS_OFF_LIMIT_US = 10_000
STOP_LIMIT_US = 200_000  # systemctl's own way to the signal is in it
WATCHDOG_S, KILLED_AFTER_S = 5, 1
GOOD_BEEPS_MS = (100, 100, 100, 600)  # README.md: the countdown, then "good"
BEEP_SLACK_MS = 30
RIG_CPU_PRIORITY = 80  # linux.priority of the rig file; its supervisor is one above
FIFO = 1
PIXELS = 160 * 120
READY_LOOKS = 20  # 2 s: it is off sooner at anything else than waiting
LOCKED_LEAST_KB = 8_388_608 // 1024  # store.capacity_bytes of the rig file
SET = re.compile(r" (\d+\.\d+): gpio_value: (\d+) set ([01])")


def _text(folder, name):
    path = folder / name
    if not path.exists():
        raise vm.MachineError(f"the machine left no {path}")
    return path.read_text(encoding="utf-8", errors="replace")


def _find(pattern, text):
    found = re.search(pattern, text, re.M)
    if not found:
        raise vm.MachineError(f"the kernel's word on a process has no {pattern}: {text[:80]}")
    return found[1]


def _unit(out, scene):
    return dict(line.split("=", 1) for line in _text(out / scene, "unit").splitlines())


def _expect(unit, **expected):
    return [f"{name} is {unit.get(name)}, not {value}" for name, value in expected.items()
            if unit.get(name) != value]


def _edges(out, scene):
    names = read_line_names(_text(out / "start", "gpio"))
    return [Edge(round(float(t_s) * 1e9), names[int(number)], int(value))
            for t_s, number, value in SET.findall(_text(out / scene, "trace"))]


def _looks(out, scene):
    """Looks at the lines: (time, BLANK, monostable, lamp, ready light)."""
    return [line.split() for line in _text(out / scene, "looks").splitlines()]


def _not_ready(looks):
    steady = [look[4] for look in looks[-READY_LOOKS:]] == ["1"] * READY_LOOKS
    return [] if steady else ["the ready light did not stay on"]


def installed(out):
    """dpkg -i, with every dependency there, and the package's own scripts."""
    folder = out / "install"
    faults = [] if _text(folder, "exit").strip() == "0" else [_text(folder, "log")]
    faults += [line for line in _text(folder, "audit").splitlines() if line]
    if _text(folder, "enabled").strip() != "enabled":
        faults.append(f"the unit is {_text(folder, 'enabled').strip()}, not enabled")
    groups = re.findall(r"\((\w+)\)", _text(folder, "user").partition("groups=")[2])
    faults += [f"lamella is not in the group {group}" for group in ("gpio", "spi", "video", "render")
               if group not in groups]
    faults += _expect(_unit(out, "install"), ActiveState="inactive", ConditionResult="no")
    return Result("dpkg -i of lamella-rig: user, groups, enabled; without a rig file it does not start",
                  [], faults, [f"lamella is in {', '.join(groups)}"])


def devices(out):
    """udev's rules, for devices that were there before the package, and for those that came after."""
    found = dict(line.split(" ", 1) for line in _text(out / "devices", "owners").splitlines())
    faults = [f"{device} is of {found.get(device)}, not {owner}" for device, owner in OWNERS.items()
              if found.get(device) != owner]
    return Result("the rig's devices belong to the unit's groups", [], faults)


def started(out):
    """Type=notify: active is what the unit is after its self-test, as the kernel's trace has that."""
    unit, edges = _unit(out, "start"), _edges(out, "start")
    faults = _expect(unit, Type="notify", ActiveState="active", SubState="running", Result="success",
                     NRestarts="0", User="lamella", WatchdogUSec=f"{WATCHDOG_S}s", StatusText="ready")
    begun_us, active_us = (int(unit[f"{name}TimestampMonotonic"])
                           for name in ("ExecMainStart", "ActiveEnter"))
    tested_us = [e.t_ns / 1e3 for e in edges if e.line in ("ANALYSER", "TRIGGER") and e.value]
    if len(tested_us) < 3:
        faults.append(f"{len(tested_us)} edges of ANALYSER and TRIGGER: that was no self-test")
    elif not begun_us < min(tested_us) <= max(tested_us) < active_us:
        faults.append(f"active at {active_us} us, the self-test went on until {max(tested_us):.0f} us")
    faults += _not_ready(_looks(out, "start"))
    faults += [line for line in _text(out / "start", "journal").splitlines() if "cannot" in line]
    return Result("multi-user.target starts the unit; it is active when its self-test is over", [
        Measure("from its start to active", (active_us - begun_us) / 1e6, "s"),
        Measure("edges of its self-test", len(tested_us), "")], faults)


def process_faults(out, scene, name, priority):
    """What is missing of what the unit promises to a process."""
    text = _text(out / scene, name)
    real_time = _find(r"^Max realtime priority +(\S+)", text)
    locked = _find(r"^Max locked memory +(\S+)", text)
    policy, rank = (int(_find(rf"^{field} +: +(\d+)", text)) for field in ("policy", "prio"))
    locked_kb = int(_find(r"^VmLck:\s+(\d+)", text))
    checks = {
        "it runs as root": not re.search(r"^Uid:\s+0\b", text, re.M),
        "it has capabilities": re.search(r"^CapEff:\s+0+$", text, re.M) is not None,
        "it may gain privileges": re.search(r"^NoNewPrivs:\s+1", text, re.M) is not None,
        f"RTPRIO is {real_time}": real_time == "90",
        f"MEMLOCK is {locked}": locked == "unlimited",
        f"its policy is {policy}, its rank {rank}": (policy, 99 - rank) == (FIFO, priority),
        f"{locked_kb} kB are locked": locked_kb >= (LOCKED_LEAST_KB if name == "sequencer" else 1),
        "it does not hold /dev/cpu_dma_latency": name != "sequencer" or "/dev/cpu_dma_latency" in text,
    }
    return [f"{name}: {fault}" for fault, holds in checks.items() if not holds], locked_kb


def privileged(out):
    """What the kernel says of the two processes."""
    sequencer, locked_kb = process_faults(out, "start", "sequencer", RIG_CPU_PRIORITY)
    supervisor, _ = process_faults(out, "start", "rigd", RIG_CPU_PRIORITY + 1)
    return Result("not root, no capabilities; RTPRIO, MEMLOCK and the processor's latency are in force", [
        Measure("memory that the sequencer has locked", locked_kb / 1024, "MiB")],
        sequencer + supervisor)


def unprivileged(out):
    """Control: a drop-in takes user, limits and watchdog away."""
    found, _ = process_faults(out, "control", "sequencer", RIG_CPU_PRIORITY)
    missed = [word for word in ("root", "RTPRIO", "MEMLOCK", "policy") if word not in " ".join(found)]
    return Result("control: a unit as root, without limits, is found", [],
                  [f"{word} was not seen to be wrong" for word in missed], found)


def beeps_ms(edges):
    """How long the buzzer sounded, each time."""
    moves = changes([e for e in edges if e.line == "BUZZER"], {"BUZZER": 0})
    return [(b.t_ns - a.t_ns) / 1e6 for a, b in zip(moves, moves[1:]) if a.value]


def button(out, views):
    """Whole, in the state directory, private, each photograph's light the one that the other boot saw."""
    taken = photographs(out / "button", {packed([CARD_DN] * PIXELS): CARD})
    burst = recorded(out / "button")
    faults = [] if len(taken) == 2 * STEPS else [f"{len(taken)} photographs"]
    faults += [f"{' '.join(map(str, p.subject))} shows {p.key}" for p in taken if p.key != CARD]
    if burst.expected != recorded(views / "camera-record").expected:
        faults.append("its light is not that of the boot without systemd")
    faults += [f"{line}: not lamella's alone" for line in _text(out / "button", "owners").splitlines()
               if not line.endswith("lamella 700")]
    heard_ms = beeps_ms(_edges(out, "button"))
    if len(heard_ms) != len(GOOD_BEEPS_MS) or any(abs(heard - right) > BEEP_SLACK_MS for heard, right
                                                  in zip(heard_ms, GOOD_BEEPS_MS)):
        faults.append(f"the buzzer sounded {', '.join(f'{ms:.0f}' for ms in heard_ms)} ms")
    faults += _not_ready(_looks(out, "button"))
    return Result("button to session with no host: 40 photographs in the state directory, verdict good", [
        Measure("photographs", len(taken), ""),
        Measure("exposures of the self-test before", burst.before, "")], faults)


def _off(out, scene, limit_us):
    told = _text(out / scene, "light").strip()
    if not told.startswith("off "):
        return [], [f"the lights: {told}"]
    return [Measure("lights off after", float(told.split()[1]) / 1e3, "ms", limit_us / 1e3)], []


def _restarted(out, scene, name, **expected):
    """Dark soon, dark until it is ready again, and why systemd says that it ended."""
    measures, faults = _off(out, scene, LIGHTS_OFF_LIMIT_US)
    looks = _looks(out, scene)
    lit = [look for look in looks if look[1:3] == ["0", "0"] or look[3] == "1"]
    faults += _expect(_unit(out, scene), **expected) + _not_ready(looks)
    faults += [f"a light shone {float(look[0]) - float(looks[0][0]):.1f} s later" for look in lit[:1]]
    released_s = next((float(look[0]) for look in looks if look[1] == "1"), None)
    if released_s is None:
        return Result(name, measures, faults + ["BLANK never rose"])
    return Result(name, measures + [
        Measure("BLANK was up after", released_s - float(looks[0][0]), "s",
                WATCHDOG_S + KILLED_AFTER_S),
        Measure("ready after", float(looks[-1][0]) - float(looks[0][0]), "s")], faults)


def hung(out):
    """SIGSTOP: the monostable acts first, then the watchdog."""
    return _restarted(out, "watchdog", "SIGSTOP of the sequencer, LEDs lit: dark, killed by WatchdogSec, ready",
                      Result="watchdog", NRestarts="0")


def killed(out):
    """kill -9."""
    return _restarted(out, "killed", "kill -9 of the sequencer, LEDs lit: dark, started again, ready",
                      Result="exit-code", NRestarts="1")


def stopped(out):
    """systemctl stop in the middle of a burst."""
    measures, faults = _off(out, "stopped", STOP_LIMIT_US)
    faults += _expect(_unit(out, "stopped"), ActiveState="inactive", Result="success")
    levels = _text(out / "stopped", "levels").split()
    if levels[:1] + levels[2:] != ["1", "0", "0"]:
        faults.append(f"BLANK, monostable, LAMP and READY are {' '.join(levels)}")
    return Result("systemctl stop, LEDs lit: dark, BLANK stays up", measures, faults)


def judge(out, views):
    """Every scene of the boot; views: what the boot with cameras left."""
    results = []
    for scene in (installed, devices, started, privileged, lambda _: button(out, views), hung, killed,
                  stopped, unprivileged):
        try:
            results.append(scene(out))
        except (OSError, ValueError, vm.MachineError) as why:
            results.append(Result("the machine with systemd", [], [str(why)]))
    return results
