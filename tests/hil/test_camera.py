"""Keys in pictures, and which photographs are of another light."""
import unittest

from suite import camera


def packed(values):
    raw = b""
    for a, b in zip(values[::2], values[1::2]):
        raw += bytes((a & 255, a >> 8 | (b & 15) << 4, b >> 4))
    return raw


def picture(key):
    return packed([3000 if key >> bit & 1 else 200 for bit in range(64)] + [1600] * 8)


def photograph(role, key, index=0):
    return camera.Photograph("left", role, index, "CROSS", 0, key)


class Keys(unittest.TestCase):
    def test_a_key_comes_back_out_of_its_picture(self):
        for key in (0, 1, 0x9f07dc8a9858611b, (1 << 64) - 1):
            self.assertEqual(camera.key_in(picture(key)), f"{key:016x}")

    def test_the_test_card_is_told_from_every_key(self):
        self.assertEqual(camera.key_in(packed([1600] * 72)), camera.CARD)

    def test_half_a_card_is_neither(self):
        self.assertIsNone(camera.key_in(packed([3000] * 32 + [1600] * 40)))

    def test_the_digest_is_fnv_1a(self):
        self.assertEqual(camera.digest([]), "cbf29ce484222325")
        self.assertEqual(camera.digest(b"a"), "af63dc4c8601ec8c")


class Light(unittest.TestCase):
    def test_a_photograph_of_another_light_is_found_and_no_other(self):
        taken = [photograph("FRINGE", "a"), photograph("FRINGE", "c", 1)]
        expected = {taken[0].subject: "a", taken[1].subject: "b"}
        self.assertEqual(camera.wrong(taken, expected), [(taken[1].subject, "b", "c")])

    def test_the_feeders_account_has_both_keys_and_the_leds(self):
        text = "ready\nframe 0 aa bb leds cc lamp 0 pattern 00 analyser 1 in 5\n"
        self.assertEqual(camera.fed(text), [camera.Fed(("aa", "bb"), "cc")])


if __name__ == "__main__":
    unittest.main()
