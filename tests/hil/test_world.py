"""The code that a rig's ready light blinks, read as an operator reads it."""
import unittest

from suite import world


def blinks(digits, start_s):
    """Times of one round, and when the next may begin."""
    times, t = [], start_s
    for digit in digits:
        times += [t + 0.4 * i for i in range(digit)]
        t = times[-1] + world.DIGIT_GAP_S + 0.2
    return times, times[-1] + world.ROUND_GAP_S + 0.5


class Rounds(unittest.TestCase):
    def test_two_rounds_are_told_apart(self):
        first, then_s = blinks([2, 6, 1, 5, 4], 10)
        second, _ = blinks([2, 6, 1, 5, 4], then_s)
        self.assertEqual(world.rounds(first + second), [[2, 6, 1, 5, 4]] * 2)

    def test_a_stray_blink_makes_its_round_longer_and_leaves_the_next_alone(self):
        first, then_s = blinks([2, 6, 1, 5, 4], 10)
        second, _ = blinks([2, 6, 1, 5, 4], then_s)
        stray = [10 - world.ROUND_GAP_S + 0.3]
        self.assertEqual([len(r) for r in world.rounds(stray + first + second)], [6, 5])


if __name__ == "__main__":
    unittest.main()
