"""Target vm: the arm64 firmware on a stock kernel; its witness is that kernel's trace."""
import re
import shutil
import subprocess

from suite import coverage
from suite.controls import FAULTS
from suite.evidence import Burst, Evidence, Light, read_record
from witness import compare, kernel_trace, led_chain, plan, vcd

TIMED_OUT = 124  # of the command timeout
BUS = ("SPI_SCK", "SPI_MOSI")
LIGHTS = ("off-term-leds", "off-term-lamp", "off-kill-leds", "off-kill-lamp", "off-kill-supervisor",
          "off-kill-both", "off-stop-both", "off-estop-leds", "off-estop-lamp", "off-heat", "off-abort",
          "off-host-gone", "control-no-pull-up")
BURSTS = ("burst", *(f"burst-{number}" for number in range(2, 11)))


class PackagesError(Exception):
    """What the machine is made of cannot be had: no network, or no apt."""


class MachineError(Exception):
    """The machine did not play its scenes."""


def _apt(command):
    try:
        return subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout.decode().strip()
    except subprocess.CalledProcessError as why:
        raise PackagesError(f"exit {why.returncode} of {command[0].name}") from None


def install(root, say):
    """Debian's cross-compiler, emulator and decoders, where they are missing."""
    say("what the machine is built with")
    _apt([root / "hil/vm/install"])


def build(root, cache, say):
    """Makes the machine, or finds it made; returns its kernel's version."""
    vm = root / "hil/vm"
    say("the machine's packages")
    kernel = _apt([vm / "fetch", cache])
    say(f"modules for {kernel}")
    subprocess.run([vm / "modules", cache, kernel], check=True)
    say("firmware for arm64")
    subprocess.run([vm / "programs", cache, kernel], check=True)
    say("initramfs")
    subprocess.run([vm / "initramfs", cache, kernel], check=True)
    return kernel


def build_installed(root, cache, kernel, say):
    """Over that: the machine whose first process is systemd, with the rig's package to install."""
    say("the machine with systemd and the rig's package")
    for step in ("userland", "package", "image"):
        subprocess.run([root / "hil/vm" / step, cache, kernel], check=True)


def empty(out):
    """The folder in which boots leave what they saw, without an earlier run's."""
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    return out


def boot(root, cache, kernel, out, scenes, say):
    """Boots once and plays a folder of scenes; the guest leaves a folder for each under out."""
    say(f"boot of {scenes}")
    done = subprocess.run([root / "hil/vm/boot", cache, kernel, out, scenes],
                          stdin=subprocess.DEVNULL)
    if done.returncode == TIMED_OUT:
        raise MachineError(f"the machine never switched itself off: see {console(out, scenes)}")
    done.check_returncode()
    say(f"end of {scenes}")


def console(out, scenes):
    """What a boot said."""
    return out / f"console-{scenes}"


def _text(path):
    if not path.exists():
        raise MachineError(f"the machine left no {path}: see {path.parent.parent}/console-*")
    return path.read_text(encoding="utf-8", errors="replace")


def _refuse_lost_events(key, stats):
    lost = re.findall(r"^(?:overrun|commit overrun|dropped events): ([1-9]\d*)$", stats, re.M)
    if lost:
        raise MachineError(f"{key}: the kernel's trace lost {', '.join(lost)} events")


def _edges(out, key):
    """What the kernel saw of the lines."""
    _refuse_lost_events(key, _text(out / key / "stats"))
    pages = (out / key / "trace").read_bytes()
    return kernel_trace.edges(pages,
                              kernel_trace.read_format(_text(out / "machine/gpio_value.format")),
                              kernel_trace.read_line_names(_text(out / "machine/gpio")))


def _burst(out, key):
    folder = out / key
    if _text(folder / "exit").strip() != "0":
        raise MachineError(f"{key}: the player failed: {_text(folder / 'errors').strip()}")
    before, edges = led_chain.split(_edges(out, key))
    vcd_file = folder / "lines.vcd"
    vcd.write(vcd_file, edges, BUS + compare.LINES)
    return Burst(edges, compare.LINES, read_record(_text(folder / "record")),
                 frames=led_chain.frames(edges), vcd_file=str(vcd_file),
                 frames_before=led_chain.frames(before))


def _light(out, key):
    told = _text(out / key / "light").strip()
    return Light(float(told.split()[1]) if told.startswith("off ") else None, told)


def read(root, programs, out):
    """Everything that a boot left under out."""
    rig_file = root / "firmware/board/vm.rig"
    machine = {name: _text(out / "machine" / name).split() for name in ("devices", "idle")}
    machine["kernel"] = _text(out / "machine/kernel").strip()
    rigd = programs / "lamella-rigd"
    crossed_file = plan.other_rest(rig_file, out / "crossed")
    return Evidence("vm", plan.read(rigd, rig_file, root / "proto"), plan.read_leds(rig_file),
                    {key: _burst(out, key) for key in (*BURSTS, *FAULTS)},
                    {key: _light(out, key) for key in LIGHTS}, machine, BURSTS,
                    plan.read(rigd, crossed_file, root / "proto"), out,
                    led_chain.frames(_edges(out, "start")))


def lines_run(root, cache, kernel, out):
    """How much of the firmware's door to the kernel the boot of counted.d ran."""
    if not (out / "counted/exit").exists() or _text(out / "counted/exit").strip() != "0":
        raise MachineError(f"the burst that counts its lines failed: see {console(out, 'counted.d')}")
    objects = cache / kernel / "counted/firmware/CMakeFiles/lamella_firmware.dir"
    ran = coverage.read(objects, out / "counted/lines", out / "counted/gcov")
    return coverage.lines_run(ran, sorted(path.name for path in (root / "firmware").glob("hal_linux*.c")))
