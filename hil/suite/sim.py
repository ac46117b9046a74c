"""Target sim: the simulated rig in memory; its witness is what that hardware remembers."""
import subprocess

from suite.controls import FAULTS
from suite.evidence import Burst, Evidence, read_record
from witness import plan

LINES = ("BLANK", "TRIGGER", "LAMP", "ANALYSER")


def _burst(programs, rig_file, options):
    done = subprocess.run([programs / "hil-play", "--rig", rig_file, *options],
                          check=True, capture_output=True)
    record = read_record(done.stdout.decode())
    return Burst(record.seen, LINES, record, codes=record.codes)


def run(root, programs):
    """Plays every burst; seconds."""
    rig_file = root / "firmware/board/sim.rig"
    bursts = {"burst": _burst(programs, rig_file, [])}
    for key, fault in FAULTS.items():
        bursts[key] = _burst(programs, rig_file, ["--plant", fault])
    return Evidence("sim", plan.read(programs / "lamella-rigd", rig_file, root / "proto"),
                    plan.read_leds(rig_file), bursts, {}, {})
