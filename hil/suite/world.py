"""The rig among hosts, disks and power cuts: a machine on the real clock, judged from the host's side.

Order and content are judged here, no microseconds: the emulator keeps none on the real clock."""
import hashlib
import json
import re
import shutil
import socket
import ssl
import subprocess
import time
from pathlib import Path
from typing import NamedTuple

from suite import light, pictures, world_disk
from suite.camera import STEPS, recorded
from suite.host import Host, Line, key_in_exr
from suite.machine import Machine, MachineError, make_disk
from suite.report import Measure, Result, expect

LONGEST_S = 150  # of anything in the guest, on a machine that others use too
REFUSED, PHOTOGRAPHS = 3, 2 * STEPS
WIDTH_PX, HEIGHT_PX = 160, 120  # of a camera, as in vm.rig
DIGITS, DIGIT_GAP_S, ROUND_GAP_S = 5, 0.9, 2.5
CUTS_BYTES = (200_000, 300_000, 70_001)
KILLED_AT_BYTES = 400_000
EXPOSED_BEFORE_CUT, WRITTEN_BEFORE_CUT = 6, 20
RISE_OR_FALL = re.compile(r" (\d+\.\d+): gpio_value: \d+ set ([01])")


class Machinery(NamedTuple):
    """What the world is made with. out: a folder for everything that it leaves."""
    root: Path
    cache: Path
    kernel: str
    out: Path
    lamella: Path


class World:
    """What the scenes share. expected: the key of each subject's picture."""

    def __init__(self, made, expected):
        self.out, self.disk, self.expected = made.out, made.out / "disk", expected
        self.line = Line()
        self.host, self.stranger = (Host(made.lamella, made.out / n) for n in ("host", "stranger"))
        self.machine, self.whole_burst = None, 0
        self._boot = made.root, made.cache, made.kernel, made.out, self.disk

    def boot(self):
        """The same disk, another life."""
        self.machine = Machine(*self._boot).__enter__()
        self.line.port = self.machine.port
        self.machine.must("stand_up", LONGEST_S)
        self.must("serve")

    def cut_power(self):
        """Whatever the guest is doing."""
        if self.machine:
            self.machine.cut_power()

    def must(self, command):
        """In the guest."""
        return self.machine.must(command, LONGEST_S)

    def count(self, command):
        """A number that the guest says."""
        return int(self.must(command)[-1])

    def capture(self, name):
        """A new burst to a new session."""
        return self.host.run("capture", "--rig", self.line.address, "--flashing-confirmed", "--out",
                             self.out / name)

    def press(self):
        """The button starts a burst; returns how many exposures there were before."""
        before = self.count("exposures || true")
        self.must("press_for_burst")
        return before

    def held(self):
        """The rig's own list of what it holds."""
        _, told, errors = self.host.run("rig", "recover", "--rig", self.line.address, "--json")
        if not told:
            raise MachineError(f"rig recover: {errors}")
        return {burst["burst"]: burst for burst in json.loads(told)["bursts"]}

    def sync(self, name):
        """(exit status, bursts by number, complaint), sessions in a folder of that name."""
        status, told, errors = self.host.run("rig", "sync", "--rig", self.line.address, "--out",
                                             self.out / name, "--json")
        bursts = json.loads(told)["bursts"] if told else []
        return status, {burst["burst"]: burst for burst in bursts}, errors

    def wrong(self, session):
        """(how many photographs a session has, faults in words): each must be of its own light."""
        frames = json.loads((session / "session.json").read_text(encoding="utf-8")).get("frames", [])
        faults = []
        for f in frames:
            subject = f["camera"], f["role"], f.get("index", 0), f["analyser"]
            key = key_in_exr((session / f["file"]).read_bytes())
            if key != self.expected.get(subject):
                faults.append(f"{f['file']} shows {key}, not {self.expected.get(subject)}")
        return len(frames), faults[:4]

    def whole(self, session):
        """Faults of a session that must be whole."""
        if not (session / "session.json").exists():
            return [f"there is no session {session.name}"]
        count, faults = self.wrong(session)
        return faults + ([] if count == PHOTOGRAPHS else [f"{count} photographs in {session.name}"])


# --- Who is let in ---

def _alert(world):
    """What TLS says to a guest that shows a certificate of its own, and the digest of the rig's key."""
    pem = world.out / "guest.pem"
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ed25519", "-nodes", "-keyout", pem, "-out",
                    world.out / "guest.crt", "-subj", "/CN=guest"], check=True, capture_output=True)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    context.set_alpn_protocols(["lamella/1"])
    context.load_cert_chain(world.out / "guest.crt", pem)
    with socket.create_connection(("127.0.0.1", world.machine.port), timeout=LONGEST_S) as raw:
        with context.wrap_socket(raw) as wire:
            public = subprocess.run(
                ["openssl", "x509", "-inform", "DER", "-pubkey", "-noout"], check=True,
                input=wire.getpeercert(True), capture_output=True).stdout
            try:
                told = f"{len(wire.recv(1))} bytes"
            except ssl.SSLError as why:
                told = why.reason or str(why)
    spki = ssl.PEM_cert_to_DER_cert(public.decode().replace("PUBLIC KEY", "CERTIFICATE"))
    return told, hashlib.sha256(spki).hexdigest()


def _know_rig(host, key, address):
    """As if this host had been paired: it trusts the rig. The rig is told nothing."""
    host.config.mkdir(parents=True, exist_ok=True, mode=0o700)
    known = host.config / "known_rigs"
    known.write_text(f"{key} {address} rig\n", encoding="utf-8")
    known.chmod(0o600)


def stranger_refused(world):
    """A host that was never paired, though it knows the rig's key."""
    faults = []
    told, key = _alert(world)
    expect(faults, "ALERT_BAD_CERTIFICATE" in told, f"on the wire: {told}, no alert bad_certificate")
    _know_rig(world.stranger, key, world.line.address)
    status, _, errors = world.stranger.run("rig", "status", "--rig", world.line.address)
    expect(faults, status == REFUSED and "not paired" in errors, f"exit {status}: {errors}")
    return Result("a host that is not paired is refused", [], faults, [f"on the wire: {told}"])


def rounds(rises_s):
    """Blinks at these times to [[blinks of each digit]] of each round, in order."""
    found, last_s = [], None
    for t in rises_s:
        if last_s is None or t - last_s > ROUND_GAP_S:
            found.append([])
        if last_s is None or t - last_s > DIGIT_GAP_S:
            found[-1].append(0)
        found[-1][-1] += 1
        last_s = t
    return found


def _read_code(world):
    """As an operator does: counts the blinks of the ready light, until a round of five is over. What
    the light said before may have become part of a round, which is longer then."""
    deadline_s = time.monotonic() + LONGEST_S
    while time.monotonic() < deadline_s:
        time.sleep(1)
        lines = world.must('cat "$panel/trace"; cut -d" " -f1 /proc/uptime')
        edges = [(float(t), int(v)) for t, v in RISE_OR_FALL.findall("\n".join(lines))]
        rises = [t for i, (t, v) in enumerate(edges) if v and (i == 0 or not edges[i - 1][1])]
        over = [r for r in rounds(rises + [float(lines[-1])])[:-1] if len(r) == DIGITS]
        if over:
            return "".join(map(str, over[0]))
    raise MachineError("the ready light blinks no code")


def pairing(world):
    """Refused while nobody holds START; then by the code that the ready light blinks."""
    faults = []
    pair = "rig", "pair", "--rig", world.line.address, "--wait"
    status, _, errors = world.host.run(*pair, "0.5")
    expect(faults, status == REFUSED and "BUTTON" in errors, f"nobody held START: exit {status}")
    world.must("watch_ready")
    process = world.host.start(*pair, "60")
    world.must("pull START up")
    try:
        code = _read_code(world)
        out, errors = process.communicate(f"{code}\n", timeout=LONGEST_S)
    finally:
        process.kill()
        world.must("pull START down")
    expect(faults, process.returncode == 0, f"code {code}: exit {process.returncode}: {errors}")
    status, _, errors = world.host.run("rig", "status", "--rig", world.line.address)
    expect(faults, status == 0, f"the paired host: exit {status}: {errors}")
    status, _, errors = world.stranger.run("rig", "status", "--rig", world.line.address)
    expect(faults, status == REFUSED, f"another host is let in: exit {status}")
    return Result("pairing while START is held, by the code that the ready light blinks", [], faults,
                  [f"read from the ready light: {code}"])


# --- The LED drivers' far end ---

# (parameter of the simulated drivers, its value, its value again afterwards, the reading that must
# show it, what that must be). To set `chips` is to take the supply away for a moment.
CHAIN_FAULTS = (("flipped_bit", 1000, -1, "wrong bits", lambda bits: bits == 9),
                ("forgetful_chip", 3, -1, "wrong function bits", lambda bits: bits > 0),
                ("chips", 6, 7, "chips in the chain", lambda chips: chips == 6))


def _chain(world):
    """(exit status, {reading: value or its note}, complaint) of the self-test's chain."""
    status, told, errors = world.host.run("rig", "selftest", "--rig", world.line.address, "--only",
                                          "chain", "--json")
    readings = json.loads(told)["readings"] if told else []
    return status, {r["what"]: r.get("value", r.get("note")) for r in readings}, errors


def driver_chain(world):
    """What leaves the last driver comes back through spidev; each fault of theirs is found."""
    faults = []
    for name, value, again, reading, is_right in CHAIN_FAULTS:
        at = f"/sys/module/lamella_gpio_sim/parameters/{name}"
        world.must(f"echo {value} >{at}")
        status, found, errors = _chain(world)
        world.must(f"echo {again} >{at}")
        seen = found.get(reading)
        expect(faults, status == 1 and isinstance(seen, (int, float)) and is_right(seen),
               f"{name} {value}: exit {status}, {reading} {seen} {errors}")
    status, found, errors = _chain(world)
    right = {"chips in the chain": 7, "wrong bits": 0, "wrong function bits": 0}
    expect(faults, status == 0 and found == right, f"drivers without fault: {found} {errors}")
    return Result("the LED drivers' far end is read back, each of three faults of theirs is found", [],
                  faults)


# --- Photographs at the host ---

def captured(world):
    """A burst over TLS."""
    status, _, errors = world.capture("session")
    faults = [] if status == 0 else [f"exit {status}: {errors}"]
    return Result("lamella capture over TLS: 40 photographs, each of its own light",
                  [], faults + world.whole(world.out / "session"))


def cut_link(world):
    """The line breaks in the middle of photographs; the host goes on by itself."""
    before = world.line.connections
    world.line.cut_after(*CUTS_BYTES)
    status, _, errors = world.capture("cut")
    faults = [] if status == 0 else [f"exit {status}: {errors}"]
    expect(faults, world.line.cuts_left() == 0, f"{world.line.cuts_left()} cuts never came")
    return Result("the link is cut three times in a transfer, and goes on", [
        Measure("connections", world.line.connections - before, "")],
        faults + world.whole(world.out / "cut"))


def killed_host(world):
    """kill -9 of the host in a transfer: the rig keeps everything for the next one."""
    process = world.host.start("capture", "--rig", world.line.address, "--flashing-confirmed",
                               "--out", world.out / "killed")
    world.line.cut_after(KILLED_AT_BYTES, on_cut=process.kill)
    _, errors = process.communicate(timeout=LONGEST_S)
    faults = []
    expect(faults, process.returncode == -9, f"the host ended by itself: {errors.strip()}")
    expect(faults, not (world.out / "killed/session.json").exists(), "half a session was left")
    status, bursts, errors = world.sync("after-kill")
    expect(faults, status == 0 and len(bursts) == 1, f"sync: exit {status}, {bursts}: {errors}")
    for burst in bursts.values():
        faults += world.whole(world.out / "after-kill" / f"burst-{burst['burst']:06}")
    return Result("the host is killed in a transfer; rig sync fetches the burst", [], faults)


# --- No host, no power ---

def button(world):
    """START, with no host there: the burst is whole on the disk. It stays there for power_cuts."""
    faults = []
    lit = world.must('cat "$(line READY)/value"')[-1]
    expect(faults, lit == "1", "the ready light is off")
    before = world.press()
    world.must(f"await '[ $(exposures) -ge {before + STEPS} ]'; await is_stored")
    world.must("await '[ $(cat $(line READY)/value) = 1 ]'")
    held = world.held()
    world.whole_burst = max(held, default=0)
    burst = held.get(world.whole_burst, {})
    expect(faults, burst.get("whole") and burst.get("photographs_held") == PHOTOGRAPHS,
            f"the rig holds {held}")
    return Result("button to session with no host", [], faults)


def _cut_burst(world, name, until):
    """Power goes while the button's burst is under way; what the rig says after the next boot."""
    before_list = world.held()
    written = world.count("records || true")  # of bursts that were cut before
    exposed = world.press()
    world.must(until.format(exposed=exposed + EXPOSED_BEFORE_CUT, written=written + WRITTEN_BEFORE_CUT))
    world.cut_power()
    world.boot()
    faults, held = [], world.held()
    for number, burst in before_list.items():
        expect(faults, held.get(number) == burst, f"burst {number} was {burst}, is {held.get(number)}")
    new = [held[number] for number in held if number not in before_list]
    # Nothing of it may have reached the disk before the power went.
    for burst in new:
        expect(faults, burst["whole"] or burst["why"], f"{burst} is not explained")
    kept = sum(burst["photographs_held"] for burst in new)
    notes = [f"burst {b['burst']}: {'whole' if b['whole'] else b['why']}" for b in new]
    return Result(name, [Measure("photographs kept of it", kept, "")], faults,
                  notes or ["nothing of it had reached the disk"])


def power_cut_burst(world):
    """While edges are played."""
    return _cut_burst(world, "power cut during a burst: what was whole stays, the rest is explained",
                      "await '[ $(exposures) -ge {exposed} ]'")


def power_cut_writing(world):
    """While photographs go to the disk."""
    return _cut_burst(world, "power cut while photographs are written",
                      "await '[ $(records) -ge {written} ]'")


def recovered(world):
    """Everything that the cuts left comes to the host, right; what the host has, the rig gives up."""
    held = world.held()
    status, bursts, errors = world.sync("recovered")
    faults = [] if status in (0, 1) and errors == "" else [f"exit {status}: {errors}"]
    expect(faults, set(bursts) == set(held), f"of bursts {sorted(held)} came {sorted(bursts)}")
    total = 0
    for number, burst in bursts.items():
        if not burst["session"]:
            continue
        count, wrong = world.wrong(Path(burst["session"]))
        total += count
        faults += wrong
        expect(faults, count == held[number]["photographs_held"],
                f"burst {number}: {count} photographs of {held[number]['photographs_held']}")
    faults += world.whole(world.out / "recovered" / f"burst-{world.whole_burst:06}")
    expect(faults, world.held() == {}, "the rig holds something still")
    return Result("after two power cuts rig sync fetches all that is whole, each photograph right",
                  [Measure("photographs", total, "")], faults)


# The last: the cameras' feeder keeps what the bus brought until an exposure, and here there is none.
SCENES = (stranger_refused, pairing, captured, cut_link, killed_host, button, power_cut_burst,
          power_cut_writing, recovered, *world_disk.SCENES, driver_chain)


def _calibration(twins, out):
    """The twin's rig, its cameras as big as these are."""
    calibration = json.loads(twins.read_text(encoding="utf-8"))
    for camera in calibration["rig"]["cameras"]:
        camera["width"], camera["height"] = WIDTH_PX, HEIGHT_PX
    (out / "calibration.json").write_text(json.dumps(calibration), encoding="utf-8")


def _prepare(made, first_boot):
    """The world, its disk empty; its cameras know the states that an earlier boot recorded."""
    shutil.rmtree(made.out, ignore_errors=True)
    made.out.mkdir(parents=True)
    expected = recorded(first_boot / "camera-record").expected
    states = light.read_states((first_boot / "camera-record/states").read_text())
    pictures.write(made.out / "known", [states[key] for key in sorted(set(expected.values()))],
                   lambda state: pictures.draw_key(state.key, WIDTH_PX, HEIGHT_PX))
    _calibration(first_boot / "known/calibration.json", made.out)
    world = World(made, expected)
    make_disk(world.disk)
    return world


def play(made, first_boot, say):
    """Every scene, in order; they build on each other. Returns the results."""
    world, results = _prepare(made, first_boot), []
    try:
        say("boot on the real clock")
        world.boot()
        for scene in SCENES:
            say(scene.__name__.replace("_", " "))
            results.append(scene(world))
    except (MachineError, OSError, ValueError, subprocess.SubprocessError) as why:
        results.append(Result("the machine on the real clock", [], [str(why)]))
    finally:
        world.cut_power()
    return results
