"""Which photographs are of another light."""
import unittest

from suite import camera


def photograph(role, key, index=0):
    return camera.Photograph("left", role, index, "CROSS", 0, key)


class Light(unittest.TestCase):
    def test_a_photograph_of_another_light_is_found_and_no_other(self):
        taken = [photograph("FRINGE", "a"), photograph("FRINGE", "c", 1)]
        expected = {taken[0].subject: "a", taken[1].subject: "b"}
        self.assertEqual(camera.wrong(taken, expected), [(taken[1].subject, "b", "c")])

    def test_a_photograph_that_is_no_known_picture_is_wrong(self):
        taken = [photograph("FRINGE", None)]
        self.assertEqual(len(camera.wrong(taken, {taken[0].subject: "a"})), 1)

    def test_the_feeders_account_has_both_keys_and_the_leds(self):
        text = "ready\nframe 0 aa bb leds cc lamp 0 pattern 00 analyser 1 lit 1 0 of 2 in 5\n"
        self.assertEqual(camera.fed(text), [camera.Fed(("aa", "bb"), "cc")])


if __name__ == "__main__":
    unittest.main()
