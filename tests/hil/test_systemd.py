"""What is said of a service's processes, lights and buzzer."""
import pathlib
import tempfile
import unittest

from suite import systemd
from witness.edges import Edge

PROCESS = """Uid:\t991\t991\t991\t991
VmLck:\t  113796 kB
CapEff:\t0000000000000000
NoNewPrivs:\t1
Max locked memory         unlimited            unlimited            bytes
Max realtime priority     90                   90
policy                                       :                    1
prio                                         :                   19
l-wx------ 1 lamella lamella 64 Nov 29 10:05 8 -> /dev/cpu_dma_latency
"""
UNIT = "Result=watchdog\nNRestarts=0\n"


def look(t_s, blank, monostable, lamp, ready):
    return f"{t_s:.2f} {blank} {monostable} {lamp} {ready}\n"


class Boot(unittest.TestCase):
    def setUp(self):
        self._folder = tempfile.TemporaryDirectory()
        self.out = pathlib.Path(self._folder.name)

    def tearDown(self):
        self._folder.cleanup()

    def leave(self, scene, **files):
        (self.out / scene).mkdir(exist_ok=True)
        for name, text in files.items():
            (self.out / scene / name).write_text(text, encoding="utf-8")

    def hung(self, looks, light="off 7300.0\n"):
        ready = "".join(look(20 + i / 10, 1, 1, 0, 1) for i in range(systemd.READY_LOOKS))
        self.leave("watchdog", unit=UNIT, light=light, looks=looks + ready)
        return systemd.hung(self.out)

    def faults(self, text):
        self.leave("start", sequencer=text)
        return systemd.process_faults(self.out, "start", "sequencer", 80)[0]

    def test_a_process_with_everything_that_its_unit_promises_is_right(self):
        self.assertEqual(self.faults(PROCESS), [])

    def test_each_thing_that_is_missing_is_named(self):
        for old, new, said in (("Uid:\t991", "Uid:\t0", "root"), ("VmLck:\t  113796", "VmLck:\t 0", "0 kB"),
                               ("unlimited  ", "65536  ", "MEMLOCK"), ("90  ", "0  ", "RTPRIO"),
                               (":                   19", ":                  120", "rank"),
                               ("/dev/cpu_dma_latency", "/dev/null", "cpu_dma_latency"),
                               ("CapEff:\t0", "CapEff:\t8", "capabilities")):
            faults = self.faults(PROCESS.replace(old, new, 1))
            self.assertEqual(len(faults), 1, faults)
            self.assertIn(said, faults[0])

    def test_a_hung_rig_that_stays_dark_passes(self):
        self.assertEqual(self.hung(look(10, 0, 1, 0, 0) + look(15, 1, 1, 0, 0)).verdict(), "pass")

    def test_a_light_that_comes_back_is_found(self):
        relit = self.hung(look(10, 0, 1, 0, 0) + look(12, 0, 0, 0, 0) + look(15, 1, 1, 0, 0))
        self.assertIn("a light shone 2.0 s later", relit.faults)

    def test_a_rig_that_the_watchdog_forgets_is_found(self):
        self.assertEqual(self.hung(look(10, 0, 1, 0, 0) + look(18, 1, 1, 0, 0)).verdict(), "FAIL")

    def test_lights_that_stay_on_are_found(self):
        self.assertIn("the lights: lit", self.hung(look(15, 1, 1, 0, 0), light="lit\n").faults)


class Buzzer(unittest.TestCase):
    def test_its_beeps_have_their_lengths(self):
        edges = [Edge(int(t_ms * 1e6), "BUZZER", level) for t_ms, level
                 in ((0, 1), (100, 0), (1000, 1), (1100, 0), (2000, 1), (2600, 0))]
        self.assertEqual(systemd.beeps_ms(edges + [Edge(0, "READY", 1)]), [100, 100, 600])


if __name__ == "__main__":
    unittest.main()
