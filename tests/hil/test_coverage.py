import unittest

from suite import coverage


def report_of(name, *counts):
    return {"files": [{"file": f"/somewhere/firmware/{name}",
                       "lines": [{"line_number": i, "count": n} for i, n in enumerate(counts)]}]}


class CoverageTest(unittest.TestCase):
    def test_lines_that_ran_are_counted_of_the_door_to_the_kernel_alone(self):
        reports = [report_of("hal_linux.c", 1, 0, 7, 0), report_of("player.c", 1), report_of("hal.h", 1)]
        self.assertEqual(coverage.count(reports), {"hal_linux.c": (2, 4)})

    def test_a_file_of_which_nothing_ran_fails_and_so_does_one_that_was_not_counted(self):
        sources = ["hal_linux.c", "hal_linux_spi.c"]
        for ran, verdict in (({"hal_linux.c": (2, 4), "hal_linux_spi.c": (1, 9)}, "pass"),
                             ({"hal_linux.c": (2, 4), "hal_linux_spi.c": (0, 9)}, "FAIL"),
                             ({"hal_linux.c": (2, 4)}, "FAIL"), ({}, "FAIL")):
            self.assertEqual(coverage.lines_run(ran, sources).verdict(), verdict, ran)

    def test_the_plug_in_that_a_static_program_cannot_load_need_not_run(self):
        ran = {"hal_linux.c": (3, 4), "hal_linux_plugin.c": (0, 3)}
        found = coverage.lines_run(ran, sorted(ran))
        self.assertEqual(found.verdict(), "pass")
        self.assertIn("together: of 7 lines ran: 42.86 %", [str(measure) for measure in found.measures])


if __name__ == "__main__":
    unittest.main()
