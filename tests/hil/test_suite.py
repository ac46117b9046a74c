import json
import unittest

from made_up import PLAN, clocked, edges_in_time
from suite import controls, report, scenes
from suite.evidence import Burst, Evidence, Light, read_record
from suite.report import Measure, Result
from witness import compare, led_chain

LEDS = [(0, 0, (1.0, 0.0, 0.0)), (6, 23, (0.0, 1.0, 0.0))]


def evidence(bits=None, edges=None, lights=None):
    bits = bits or led_chain.encode(led_chain.codes_for(LEDS, "GRADIENT_X"))
    burst = Burst(edges or edges_in_time(), compare.LINES, read_record("zero 0"),
                  frames=led_chain.frames(clocked(bits)))
    return Evidence("made up", PLAN, LEDS, {"burst": burst}, lights or {}, {})


class ScenesTest(unittest.TestCase):
    def test_right_bits_pass_and_one_wrong_bit_fails(self):
        self.assertEqual(scenes.led_frames(evidence()).verdict(), "pass")
        bits = list(evidence().bursts["burst"].frames[0].bits)
        bits[77] ^= 1
        self.assertEqual(scenes.led_frames(evidence(tuple(bits))).verdict(), "FAIL")

    def test_drivers_that_were_told_anything_but_zeros_and_functions_before_a_burst_fail(self):
        dark = led_chain.Frame(0, 1, 2, (0,) * led_chain.BITS, True)
        told = dark._replace(bits=led_chain.FUNCTIONS, functions=True)
        other = told._replace(bits=dark.bits)
        for start, before, verdict in (([dark, told], [dark, told, dark], "pass"), ([told], [dark], "pass"),
                                       ([dark], [dark], "FAIL"), ([other], [dark], "FAIL"),
                                       ([told], [], "FAIL"), ([told], [other], "FAIL"),
                                       ([told], [told._replace(dark=False)], "FAIL"),
                                       ([told], [told, dark._replace(bits=(0, 0))], "FAIL")):
            burst = evidence().bursts["burst"]._replace(frames_before=before)
            found = scenes.functions(evidence()._replace(bursts={"burst": burst}, frames_at_start=start))
            self.assertEqual(found.verdict(), verdict, (start, before))

    def test_a_short_frame_fails(self):
        self.assertEqual(scenes.led_frames(evidence((1, 0))).verdict(), "FAIL")

    def test_edges_in_time_pass_and_a_late_one_fails(self):
        self.assertEqual(scenes.edges(evidence()).verdict(), "pass")
        edges = edges_in_time()
        edges[3] = edges[3]._replace(t_ns=edges[3].t_ns + 51_000)
        self.assertEqual(scenes.edges(evidence(edges=edges)).verdict(), "FAIL")

    def test_a_critical_edge_3_us_late_fails(self):
        for late_ns, verdict in ((1_000, "pass"), (3_000, "FAIL")):
            edges = edges_in_time()
            at = next(i for i, edge in enumerate(edges) if edge.line == "BLANK")
            edges[at] = edges[at]._replace(t_ns=edges[at].t_ns + late_ns)
            told = evidence(edges=edges)
            burst = told.bursts["burst"]._replace(record=read_record("zero 0\nverdict none late"))
            told = told._replace(bursts={"burst": burst}, bursts_in_turn=("burst",), plan_crossed=PLAN)
            self.assertEqual(scenes.ten_bursts(told).verdict(), verdict, late_ns)

    def test_light_after_10_ms_fails_and_so_does_a_light_that_was_never_lit(self):
        for light, verdict in ((Light(9999.0, "off 9999.0"), "pass"),
                               (Light(10001.0, "off 10001.0"), "FAIL"),
                               (Light(None, "lit"), "FAIL"), (Light(None, "never lit"), "FAIL")):
            found = scenes.lights_off(evidence(lights={"off": light}), "off", "a signal")
            self.assertEqual(found.verdict(), verdict, light)

    def test_a_control_fails_where_the_light_went_off(self):
        lights = {"control-no-pull-up": Light(12.0, "off 12.0")}
        self.assertEqual(controls.no_pull_up(evidence(lights=lights)).verdict(), "FAIL")

    def test_a_control_fails_where_nothing_was_planted(self):
        told = evidence()
        told.bursts["control-flipped-bit"] = told.bursts["burst"]
        self.assertEqual(controls.flipped_bit(told).verdict(), "FAIL")
        told.bursts["control-skipped-latch"] = told.bursts["burst"]
        self.assertEqual(controls.skipped_latch(told).verdict(), "FAIL")


class RecordTest(unittest.TestCase):
    def test_levels_that_a_line_has_are_no_edges(self):
        record = read_record("zero 100.5\nedge LAMP 0 3 1 2\nedge BLANK 0 0 10 11.25\n"
                             "seen LAMP 0 90\nseen LAMP 1 120\nseen BLANK 0 111\n"
                             "seen BLANK 1 inf\ncodes 111 7 8\n")
        self.assertEqual([tuple(edge) for edge in record.edges], [(111750, "BLANK", 0)])
        self.assertEqual([edge.line for edge in record.seen], ["BLANK", "LAMP"])
        self.assertEqual(record.codes, [[7, 8]])


class ReportTest(unittest.TestCase):
    def test_one_failure_fails_the_run_and_so_does_nothing_at_all(self):
        good, bad = Result("a", [], []), Result("b", [Measure("late", 11.0, "us", 10)], [])
        skipped = Result("c", [], [], skipped="no bus")
        self.assertTrue(report.has_passed([good, skipped]))
        self.assertFalse(report.has_passed([good, bad]))
        self.assertFalse(report.has_passed([skipped]))

    def test_the_page_says_what_failed_and_what_was_not_looked_at(self):
        bad = Result("b", [Measure("late", 11.0, "us", 10)], ["too late"])
        text = report.as_text("vm", [bad], ["cameras"], {"took": "1 s"})
        for part in ("FAIL", "late: 11.00 us (at most 10)  <- beyond", "FAULT: too late",
                     "- cameras", "FAILED"):
            self.assertIn(part, text)
        self.assertFalse(json.loads(report.as_json("vm", [bad], ["cameras"], {}))["passed"])


if __name__ == "__main__":
    unittest.main()
