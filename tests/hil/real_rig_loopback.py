"""./dev hil --target HOST with no board: lamella-rigd on its simulated rig, paired over TLS, and an
analyser on that rig's lines that the firmware is not told of.
usage: real_rig_loopback.py PROGRAMS [TEST...]"""

import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "hil"))

from suite.calibration import calibration  # noqa: E402
from witness import vcd  # noqa: E402

PARTS = "chain,actuator,projector,temperature,estop"  # that need no twin
PASSED, FAILED, BAD_INPUT = 0, 1, 2
MOVED_US = 50


def make_key(path):
    """A key of Ed25519; returns its fingerprint as rigs and hosts compare it."""
    subprocess.run(
        ["openssl", "genpkey", "-algorithm", "ed25519", "-out", path],
        check=True,
        capture_output=True,
    )
    path.chmod(0o600)
    public = subprocess.run(
        ["openssl", "pkey", "-in", path, "-pubout", "-outform", "DER"],
        check=True,
        capture_output=True,
    ).stdout
    return hashlib.sha256(public).hexdigest()


def write_private(path, text):
    path.write_text(text, encoding="utf-8")
    path.chmod(0o600)


class RealRig(unittest.TestCase):
    programs = None
    rig_file = ROOT / "firmware/board/vm.rig"

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.witness = cls.folder / "lines.vcd"
        state, config = cls.folder / "state", cls.folder / "config/lamella"
        for place in (state, config):
            place.mkdir(parents=True, mode=0o700)
        rig_key = make_key(state / "key.pem")
        write_private(state / "paired_hosts", f"{make_key(config / 'key.pem')} suite\n")
        (cls.folder / "calibration.json").write_text(
            json.dumps(calibration(cls.rig_file)), encoding="utf-8"
        )
        cls.rigd = subprocess.Popen(
            [
                cls.programs / "hil-watched-rigd",
                "--hal",
                "sim",
                "--test-frames",
                "--rig",
                cls.rig_file,
                "--calibration",
                cls.folder / "calibration.json",
                "--listen",
                "127.0.0.1:0",
                "--state",
                state,
            ],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "HIL_WITNESS": str(cls.witness)},
        )
        cls.address = cls.rigd.stdout.readline().split()[-1]
        write_private(config / "known_rigs", f"{rig_key} {cls.address} rig\n")
        cls.first = cls.play(
            "--witness", cls.witness, "--flashing-confirmed", "--selftest", PARTS, out="first"
        )
        cls.recording = vcd.read(cls.witness)

    @classmethod
    def tearDownClass(cls):
        cls.rigd.terminate()
        cls.rigd.wait()
        cls.rigd.stdout.close()
        cls.scratch.cleanup()

    @classmethod
    def play(cls, *options, out):
        """hil/run on the rig; its process and the page that it left."""
        done = subprocess.run(
            [
                ROOT / "hil/run",
                "--target",
                cls.address,
                "--programs",
                cls.programs,
                "--rig-file",
                cls.rig_file,
                "--out",
                cls.folder / out,
                *options,
            ],
            capture_output=True,
            text=True,
            env={**os.environ, "XDG_CONFIG_HOME": str(cls.folder / "config")},
        )
        done.page = done.stdout
        return done

    def again(self, change, left_out=("SPI_SCK", "SPI_MOSI")):
        """The same session, held against a witness that saw something else: edges through `change`.
        Without the LEDs' bus, which is most of the edges, it is quicker."""
        lines = tuple(line for line in self.recording.levels if line not in left_out)
        other = self.folder / f"{self.id().split('.')[-1]}.vcd"
        vcd.write(other, change([e for e in self.recording.edges if e.line in lines]), lines)
        return self.play(
            "--session", self.folder / "first/session", "--witness", other, out=self.id()
        )

    def test_a_good_burst_passes_on_its_witness_every_led_bit_too(self):
        self.assertEqual(self.first.returncode, PASSED, self.first.page + self.first.stderr)
        for part in (
            "pass      order and time of every edge of BLANK, LATCH, TRIGGER, LAMP, ANALYSER",
            "pass      the rig's own record of its edges is true",
            "bits: 16128",
            "bits that are wrong: 0",
            "bytes that differ: 0",
            "light pulses of the LEDs: 8",
        ):
            self.assertIn(part, self.first.page)

    def test_the_witness_is_read_again_as_it_was(self):
        again = self.again(lambda edges: edges)
        self.assertEqual(again.returncode, PASSED, again.page + again.stderr)

    def test_without_a_witness_it_is_self_reported_and_does_not_pass(self):
        alone = self.play("--session", self.folder / "first/session", out="alone")
        self.assertEqual(alone.returncode, FAILED)
        self.assertIn("self-reported: no witness was given", alone.page)

    def test_one_edge_50_us_late_is_found(self):
        def move(edges):
            at = [i for i, e in enumerate(edges) if e.line == "BLANK" and e.value == 1][3]
            return sorted(
                edges[:at]
                + [edges[at]._replace(t_ns=edges[at].t_ns + MOVED_US * 1000)]
                + edges[at + 1 :]
            )

        found = self.again(move)
        self.assertEqual(found.returncode, FAILED)
        self.assertIn(f"was {MOVED_US}.0 us off", found.page)

    def test_one_missing_trigger_is_found(self):
        def skip(edges):
            at = [i for i, e in enumerate(edges) if e.line == "TRIGGER"][10]
            return edges[:at] + edges[at + 2 :]

        found = self.again(skip)
        self.assertEqual(found.returncode, FAILED)
        self.assertIn("TRIGGER to 1", found.page)

    def test_a_dead_photodiode_is_found(self):
        found = self.again(lambda edges: [e for e in edges if e.line != "LIGHT"])
        self.assertEqual(found.returncode, FAILED)
        self.assertIn("BLANK was low and there was no light", found.page)

    def test_light_that_goes_on_for_a_millisecond_is_found(self):
        def linger(edges):
            at = [i for i, e in enumerate(edges) if e.line == "LIGHT" and e.value == 0][4]
            return sorted(
                edges[:at] + [edges[at]._replace(t_ns=edges[at].t_ns + 1_000_000)] + edges[at + 1 :]
            )

        found = self.again(linger)
        self.assertEqual(found.returncode, FAILED)
        self.assertIn("longest light after it was ended", found.page)

    def test_a_witness_whose_clock_runs_away_is_found(self):
        found = self.again(lambda edges: [e._replace(t_ns=round(e.t_ns * 1.001)) for e in edges])
        self.assertEqual(found.returncode, FAILED)
        self.assertIn("drift fitted: 1000.00 ppm", found.page)

    def test_one_flipped_led_bit_is_found(self):
        def flip(edges):
            at = [i for i, e in enumerate(edges) if e.line == "SPI_MOSI"][-300]
            return edges[:at] + edges[at + 1 :]

        found = self.again(flip, left_out=())
        self.assertEqual(found.returncode, FAILED)
        self.assertIn("FAIL      every LED frame's bits are right", found.page)

    def test_a_command_line_that_does_not_fit_together_is_refused_with_what_to_do(self):
        for options, part in (
            (("--witness", "w.vcd"), "--flashing-confirmed"),
            (("--flashing-confirmed", "--driver", "demo"), "needs --channels and --samplerate"),
        ):
            refused = self.play(*options, out="refused")
            self.assertEqual(refused.returncode, BAD_INPUT, refused.page)
            self.assertIn(part, refused.stderr)


if __name__ == "__main__":
    RealRig.programs = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
