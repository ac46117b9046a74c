"""From a recorded state of the light to the picture that a camera is fed, and back."""
import pathlib
import tempfile
import unittest

from suite import light, pictures, twin
from suite.twin import Photograph
from witness import led_chain

LEDS = [(0, 0, (1.0, 0.0, 0.0)), (6, 23, (0.0, 1.0, 0.0))]
NUMBERS = {"leds.light_us": 30000, "projector.light_periods": 2, "projector.refresh_hz": 60}


def line(camera=0, lamp_us=0, leds_us=30000, pattern="0" * 16, analyser=0):
    bits = led_chain.encode({(0, 0): 0xabc, (6, 23): 1})
    digits = "".join(f"{int(''.join(map(str, bits[i:i + 4])), 2):x}" for i in range(0, len(bits), 4))
    return (f"state {'5' * 16} camera {camera} exposure 30600 leds {leds_us} lamp {lamp_us} "
            f"pattern {pattern} analyser {analyser} codes {digits}")


def state(**what):
    return light.read_states(line(**what))["5" * 16]


def report(**what):
    return light.report(state(**what), LEDS, {"d" * 16: "FRINGE 3"}, NUMBERS)


class States(unittest.TestCase):
    def test_the_twin_is_told_the_codes_that_were_clocked(self):
        self.assertIn(r'leds { on_us: 0 off_us: 30000 codes: "\274\012\001\000" }', report())

    def test_the_twin_is_told_the_pattern_that_the_display_showed_and_no_leds(self):
        told = report(leds_us=0, lamp_us=30600, pattern="d" * 16)
        self.assertIn("patterns { on_us: 0 off_us: 30600 kind: FRINGE index: 3 }", told)
        self.assertNotIn("leds {", told)

    def test_a_display_that_showed_something_else_is_no_state_of_a_burst(self):
        with self.assertRaises(ValueError):
            report(leds_us=0, lamp_us=30600, pattern="e" * 16)

    def test_the_left_analyser_turns_and_the_right_one_is_always_crossed(self):
        self.assertIn("from_rad: 0 to_rad: 0", report())
        self.assertIn("from_rad: 1.57", report(analyser=1))
        self.assertNotIn("analyser {", report(camera=1))

    def test_the_digest_is_fnv_1a(self):
        self.assertEqual(light.digest([]), "cbf29ce484222325")
        self.assertEqual(light.digest(b"a"), "af63dc4c8601ec8c")


class Pictures(unittest.TestCase):
    def test_packing_comes_back(self):
        dn = [0, 4095, 1, 2048, 777, 64]
        self.assertEqual(twin.unpacked(twin.packed(dn)), dn)

    def test_a_sensor_sees_one_colour_a_pixel_with_one_gain_and_clips_where_the_twin_did(self):
        dn = [164, 0, 0, 0, 264, 0,
              0, 364, 0, 0, 0, 4095]
        self.assertEqual(pictures.to_mosaic(Photograph(2, 2, 64, 0.5, dn)), [114, 164, 214, 4095])

    def test_a_photograph_is_known_by_every_pixel(self):
        with tempfile.TemporaryDirectory() as folder:
            known = pathlib.Path(folder) / "known"
            pictures.write(known, [state()], lambda _: [64, 65, 4095, 3])
            found = pictures.read(known)
        self.assertEqual(found[twin.packed([64, 65, 4095, 3])], "5" * 16)
        self.assertEqual(found[twin.packed([pictures.CARD_DN] * 4)], pictures.CARD)
        self.assertNotIn(twin.packed([64, 65, 4095, 4]), found)


if __name__ == "__main__":
    unittest.main()
