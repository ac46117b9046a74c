import struct
import unittest

from suite import display as judge
from witness import display, patterns, plan
from witness.edges import Edge

NUMBERS = {"projector.width_px": 64, "projector.height_px": 48, "projector.gamma": 2.2,
           "projector.latency_us": 9000, "projector.settle_us": 2000,
           "camera.start_delay_us": 60, "pattern.fringe_0_periods": 1,
           "pattern.fringe_1_periods": 2, "pattern.fringe_2_periods": 4,
           "pattern.fringe_3_periods": 8, "pattern.stripe_period_px": 8,
           "pattern.stripe_shift_px": 2, "pattern.dot_pitch_px": 24, "pattern.dot_diameter_px": 10,
           "pattern.dot_offset_u_px": 32, "pattern.dot_offset_v_px": 24}
WHITE, BLACK = b"\xff\xff\xff\0", bytes(4)
REFRESH_US = 16720
PLANNED = [("FRINGE", 1), ("GRADIENT_X", 0), ("FRINGE", 2)]


def pixel(image, u, v):
    return image[v][4 * u:4 * u + 4]


def burst(framebuffers=(7, 8), late_us=0):
    """Three steps, the middle one lit by LEDs; framebuffer 7 is fringe 1, 8 is fringe 2."""
    edges = []
    for step, vblank in enumerate((2, 4, 6)):
        for value, after_us in ((1, 11000), (0, 11000 + 2 * REFRESH_US)):
            edges.append((vblank * REFRESH_US + after_us - 60, "TRIGGER", value, step))
    planned = [plan.PlannedEdge(t, 50, line, value, step) for t, line, value, step in edges]
    planned += [plan.PlannedEdge(vblank * REFRESH_US, 1000, "VBLANK", 1, step)
                for step, vblank in ((0, 2), (2, 6))]
    planned.sort(key=lambda edge: edge.t_us)
    vblanks = {100 + n: 5e6 + n * REFRESH_US for n in range(12)}
    shown = [display.Shown(99, 5e6 - REFRESH_US, 5e6, 5),
             display.Shown(102, vblanks[102], vblanks[102] + 9, framebuffers[0]),
             display.Shown(106, vblanks[106] + late_us, vblanks[106] + 9, framebuffers[1])]
    images = {7: patterns.draw(NUMBERS, "FRINGE 1"), 8: patterns.draw(NUMBERS, "FRINGE 2")}
    watched = judge.Watched(
        shown, vblanks, images,
        [Edge(round((5e6 + t) * 1e3), line, value) for t, line, value, _ in edges], [])
    return plan.Plan(planned, [role for role, _ in PLANNED], [k for _, k in PLANNED]), watched


class PatternsTest(unittest.TestCase):
    def test_black_and_white_are_the_ends_of_the_full_range(self):
        self.assertEqual(pixel(patterns.draw(NUMBERS, "BLACK"), 3, 5), BLACK)
        self.assertEqual(pixel(patterns.draw(NUMBERS, "WHITE"), 63, 47), WHITE)

    def test_stripes_are_white_in_the_first_half_of_each_period_and_move_by_the_shift(self):
        still, moved = (patterns.draw(NUMBERS, f"STRIPES {k}") for k in (0, 3))
        for u in range(64):
            self.assertEqual(pixel(still, u, 0), WHITE if u % 8 < 4 else BLACK)
            self.assertEqual(pixel(moved, u, 0), WHITE if (u - 6) % 8 < 4 else BLACK)

    def test_fringes_are_blue_green_red_a_third_of_a_period_apart(self):
        blue, green, red, _ = pixel(patterns.draw(NUMBERS, "FRINGE 0"), 0, 0)
        self.assertEqual(green, 255)
        self.assertEqual((blue, red), (round(255 * 0.25 ** (1 / 2.2)),) * 2)

    def test_dots_are_black_discs_on_white(self):
        dots = patterns.draw(NUMBERS, "DOTS")
        self.assertEqual(pixel(dots, 32, 24), BLACK)
        self.assertEqual(pixel(dots, 32 - 24, 24), BLACK)
        self.assertEqual(pixel(dots, 32 + 12, 24), WHITE)
        self.assertNotIn(pixel(dots, 32 + 5, 24), (BLACK, WHITE))


class DisplayTest(unittest.TestCase):
    def test_a_framebuffers_rows_are_put_together_again(self):
        rows = [WHITE * 3, BLACK * 3]
        data = b"3 4 2\n" + struct.pack("<4I", 0, 1, 1, 0) + b"".join(rows)
        self.assertEqual(display.read_framebuffer(data), [rows[0], rows[1], rows[1], rows[0]])
        with self.assertRaises(Exception):
            display.read_framebuffer(data[:-1])

    def test_one_wrong_pixel_is_one_that_differs_and_the_unused_byte_is_none(self):
        image = patterns.draw(NUMBERS, "WHITE")
        spoilt = list(image)
        spoilt[7] = image[7][:20] + b"\xfe" + image[7][21:]
        spoilt[8] = image[8][:23] + b"\xff" + image[8][24:]
        self.assertEqual(display.differing_pixels(image, spoilt), 1)
        self.assertEqual(display.differing_pixels(image, image[1:]), 64 * 48)


class JudgeTest(unittest.TestCase):
    def test_a_right_burst_has_nothing_wrong(self):
        planned, watched = burst()
        wrong, pixels = judge.wrong_exposures(planned, watched, NUMBERS)
        self.assertEqual((wrong, pixels), ([], 2 * 64 * 48))
        found, faults, _ = judge.flips(planned, watched)
        self.assertEqual(([edge.step for edge, _ in found], faults), ([0, 2], []))

    def test_exchanged_patterns_are_named(self):
        planned, watched = burst(framebuffers=(8, 7))
        self.assertEqual(judge.wrong_exposures(planned, watched, NUMBERS)[0],
                         [(0, "FRINGE 1", "FRINGE 2"), (2, "FRINGE 2", "FRINGE 1")])

    def test_a_framebuffer_that_is_no_pattern_is_told_by_its_pixels(self):
        planned, watched = burst()
        watched.images[7][3] = WHITE * 64
        wrong, _ = judge.wrong_exposures(planned, watched, NUMBERS)
        self.assertEqual([step for step, _, _ in wrong], [0])
        self.assertIn("no pattern", wrong[0][2])

    def test_a_flip_while_the_camera_looks_spoils_the_exposure(self):
        planned, watched = burst()
        watched.shown.insert(2, display.Shown(103, watched.vblanks[103], 0, 8))
        wrong, _ = judge.wrong_exposures(planned, watched, NUMBERS)
        self.assertEqual(wrong, [(0, "FRINGE 1", "FRINGE 1 then FRINGE 2")])

    def test_a_flip_at_another_vblank_is_a_fault(self):
        planned, watched = burst()
        watched.shown[2] = watched.shown[2]._replace(sequence=107)
        _, faults, _ = judge.flips(planned, watched)
        self.assertEqual(faults, ["step 2: FRINGE 2 was not flipped to at vblank 106"])


if __name__ == "__main__":
    unittest.main()
