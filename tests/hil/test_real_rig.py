"""A real rig's witness: read, brought to the rig's clock, and the light that it must see."""

import pathlib
import shutil
import tempfile
import unittest

from made_up import PLAN, edges_in_time
from suite import real_rig
from suite.photodiode import light
from suite.real_rig import Gathered
from suite.rig_link import Told
from suite.evidence import Record
from witness import analyser, clocks, vcd
from witness.edges import START_LEVELS, Edge, changes

LEVELS = {**START_LEVELS, "ANALYSER": 0, "LIGHT": 0}


def read_text(text, names=None):
    """A dump of that text, read."""
    with tempfile.NamedTemporaryFile("w", suffix=".vcd") as file:
        file.write(text)
        file.flush()
        return vcd.read(file.name, names)


class Dump(unittest.TestCase):
    def test_what_was_written_is_read(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "x.vcd"
            vcd.write(path, edges_in_time(), ("BLANK", "LATCH", "TRIGGER"))
            read = vcd.read(path)
        first_ns = edges_in_time()[0].t_ns
        self.assertEqual(
            [(e.t_ns - vcd.LEAD_NS + first_ns, *e[1:]) for e in read.edges],
            [tuple(e) for e in edges_in_time()],
        )
        self.assertEqual(read.levels["BLANK"], 1)

    def test_sigroks_form_is_read_and_channels_get_their_lines(self):
        text = (
            '$timescale 100 ps $end\n$var wire 1 ! D0 $end\n$var wire 1 " D6 $end\n'
            '$enddefinitions $end\n#0 1! 1"\n#417 0!\n#5000 1! 0"\n#90000\n'
        )
        read = read_text(text, analyser.read_channels("D0=BLANK,D6=!LIGHT"))
        self.assertEqual(read.levels, {"BLANK": 1, "LIGHT": 0})
        self.assertEqual(
            read.edges, [Edge(42, "BLANK", 0), Edge(500, "BLANK", 1), Edge(500, "LIGHT", 1)]
        )
        self.assertEqual(read.end_ns, 9000)

    def test_what_is_no_dump_and_a_channel_that_is_not_there_are_said(self):
        with self.assertRaisesRegex(vcd.VcdError, "no Value Change Dump"):
            read_text("hello\n")
        with self.assertRaisesRegex(vcd.VcdError, "no channel D9; it has D0"):
            read_text(
                "$timescale 1ns $end\n$var wire 1 ! D0 $end\n$enddefinitions $end\n",
                {"D9": ("BLANK", False)},
            )

    def test_channels_that_make_no_sense_are_refused(self):
        for text in ("D0", "D0=BLANK,D0=LATCH", "D0=blank", ""):
            with self.assertRaises(ValueError, msg=text):
                analyser.read_channels(text)


class Clocks(unittest.TestCase):
    RIG = [Edge(i * 10_000_000, "TRIGGER", i % 2) for i in range(40)]

    def test_drift_and_offset_are_found_though_one_edge_strays(self):
        seen = [e._replace(t_ns=round((e.t_ns + 7_000_000) * (1 + 80e-6))) for e in self.RIG]
        seen[5] = seen[5]._replace(t_ns=seen[5].t_ns + 50_000)
        clock = clocks.fit(seen, self.RIG)
        self.assertAlmostEqual(clock.drift_ppm, 80, delta=0.1)
        apart_ns = [abs(clock.edge(s).t_ns - r.t_ns) for s, r in zip(seen, self.RIG)]
        self.assertLess(sorted(apart_ns)[-2], 20)
        self.assertAlmostEqual(apart_ns[5], 50_000, delta=20)

    def test_a_burst_is_found_behind_triggers_of_a_self_test(self):
        stray = [
            Edge(t, "TRIGGER", v)
            for t, v in ((1_000, 1), (2_000_000, 0), (9_000_000, 1), (9_500_000, 0))
        ]
        burst = [e._replace(t_ns=e.t_ns + 900_000_000) for e in self.RIG]
        levels, edges = clocks.find_burst(
            vcd.Recording({"TRIGGER": 0}, stray + burst, 10**10), self.RIG, self.RIG[0].t_ns - 1000
        )
        self.assertEqual(edges, burst)
        self.assertEqual(levels, {"TRIGGER": 0})


    def test_latches_before_the_bursts_zero_are_no_part_of_it(self):
        begin_ns = self.RIG[0].t_ns - 100_000
        before = [Edge(begin_ns - 3000, "LATCH", 1), Edge(begin_ns - 1000, "LATCH", 0)]
        recording = vcd.Recording({"LATCH": 0}, before + self.RIG, 10**10)
        levels, edges = clocks.find_burst(recording, self.RIG, begin_ns)
        self.assertEqual((edges, levels), (self.RIG, {"LATCH": 0}))


def lit(edges, delay_ns=20_000):
    """Those edges, and a photodiode's that follows BLANK."""
    follows = [Edge(e.t_ns + delay_ns, "LIGHT", 1 - e.value) for e in edges if e.line == "BLANK"]
    return sorted(edges + follows)


class Light(unittest.TestCase):
    def test_light_with_blank_passes_and_none_or_no_photodiode_fails(self):
        self.assertEqual(light(lit(edges_in_time()), True).verdict(), "pass")
        self.assertEqual(light(edges_in_time(), True).verdict(), "FAIL")
        self.assertEqual(light(lit(edges_in_time()), False).verdict(), "FAIL")

    def test_pulse_width_modulation_is_no_darkness_but_an_early_end_is(self):
        blank_ns = [e.t_ns for e in edges_in_time() if e.line == "BLANK"]
        chopped = [
            Edge(t, "LIGHT", v)
            for i in range(9)
            for t, v in (
                (blank_ns[0] + 100_000 * i + 1000, 1),
                (blank_ns[0] + 100_000 * i + 70_000, 0),
            )
        ]
        self.assertEqual(light(sorted(edges_in_time() + chopped), True).verdict(), "pass")
        edges = [
            e._replace(t_ns=e.t_ns + 3_000_000) if (e.line, e.value) == ("BLANK", 1) else e
            for e in edges_in_time()
        ]
        self.assertEqual(light(sorted(edges + chopped), True).verdict(), "FAIL")

    def test_light_while_nothing_lets_it_through_fails(self):
        stray = [Edge(10**9, "LIGHT", 1), Edge(10**9 + 10_000, "LIGHT", 0)]
        self.assertEqual(light(lit(edges_in_time()) + stray, True).verdict(), "FAIL")


class Retaken(unittest.TestCase):
    def test_the_plan_of_another_rig_file_is_found(self):
        told = Told(PLAN.edges, Record(0, [], [], [], "", []))
        self.assertEqual(
            real_rig.planned_as_filed(Gathered(told, [PLAN], None, None)).verdict(), "pass"
        )
        moved = PLAN.edges[:3] + [PLAN.edges[3]._replace(t_us=201)] + PLAN.edges[4:]
        told = Told(moved, Record(0, [], [], [], "", []))
        self.assertEqual(
            real_rig.planned_as_filed(Gathered(told, [PLAN], None, None)).verdict(), "FAIL"
        )

    def test_no_trigger_in_a_recording_is_said(self):
        recorded = changes(edges_in_time(), START_LEVELS)
        gathered = Gathered(
            Told(PLAN.edges, Record(0, recorded, [], [], "", [])),
            [PLAN],
            vcd.Recording(LEVELS, [Edge(5, "BLANK", 0)], 10),
            None,
        )
        self.assertIn("no TRIGGER", real_rig.place(gathered)[2])


@unittest.skipUnless(shutil.which("sigrok-cli"), "sigrok-cli is not here: packages-hil.txt")
class Live(unittest.TestCase):
    CHANNELS = analyser.read_channels("D0=BLANK,D1=LATCH,D2=TRIGGER,D3=!LIGHT")

    def test_an_analyser_records_and_what_it_recorded_is_read(self):
        with tempfile.TemporaryDirectory() as folder:
            dump = pathlib.Path(folder) / "live.vcd"
            with analyser.Analyser("demo", 100_000, self.CHANNELS, 0.2, dump) as running:
                running.finish()
            read = analyser.read(dump, self.CHANNELS)
        self.assertEqual(set(read.levels), {"BLANK", "LATCH", "TRIGGER", "LIGHT"})
        self.assertGreater(len(read.edges), 100)
        self.assertAlmostEqual(read.end_ns, 0.2e9, delta=0.01e9)

    def test_an_analyser_that_is_not_there_is_said(self):
        with tempfile.TemporaryDirectory() as folder, self.assertRaises(analyser.AnalyserError):
            with analyser.Analyser(
                "fx2lafw", 1e6, self.CHANNELS, 0.2, pathlib.Path(folder) / "live.vcd"
            ):
                pass


if __name__ == "__main__":
    unittest.main()
