"""What is told of the kernel's simulated cameras, and a line the other way round."""
import unittest

from suite import drivers
from witness.edges import Edge

WHITE, BLACK = 3060, 0


def bars(order):
    """vivid's bars behind the four filters of an order, upper row first."""
    bar_px = drivers.WIDTH_PX // len(drivers.BARS)
    return [WHITE if order[y % 2 * 2 + x % 2] in drivers.BARS[x // bar_px] else BLACK
            for y in range(drivers.HEIGHT_PX) for x in range(drivers.WIDTH_PX)]


class Bars(unittest.TestCase):
    def test_each_bayer_order_is_taken_for_itself_and_for_no_other(self):
        orders = ("RGGB", "GRBG", "GBRG", "BGGR")
        for order in orders:
            for other in orders:
                wrong = drivers.wrong_bars(f"S{other}12", bars(order))
                self.assertEqual(not wrong, order == other, f"{order} as {other}: {wrong[:1]}")

    def test_a_sample_shifted_by_one_bit_is_found(self):
        self.assertTrue(drivers.wrong_bars("SRGGB10", [value // 2 for value in bars("RGGB")]))

    def test_grey_bars_fall_from_bright_to_black(self):
        bar_px = drivers.WIDTH_PX // len(drivers.BARS)
        row = [3040 - 434 * (x // bar_px) for x in range(drivers.WIDTH_PX)]
        self.assertEqual(drivers.wrong_bars("Y10", row * drivers.HEIGHT_PX), [])
        self.assertTrue(drivers.wrong_bars("Y10", row[::-1] * drivers.HEIGHT_PX))
        self.assertTrue(drivers.wrong_bars("Y10", [3040] * drivers.WIDTH_PX * drivers.HEIGHT_PX))


class Shots(unittest.TestCase):
    def test_are_read_with_and_without_a_reason(self):
        text = "shot 0 ok 36005 \nshot 1 dropped 94517 left camera: no frame of shot 6\n"
        self.assertEqual(drivers.read_shots(text), [
            drivers.Shot(0, "ok", 36005, ""),
            drivers.Shot(1, "dropped", 94517, "left camera: no frame of shot 6")])


class UpsideDown(unittest.TestCase):
    def test_one_line_is_turned_and_no_other(self):
        edges = [Edge(1, "TRIGGER", 0), Edge(2, "BLANK", 0)]
        self.assertEqual(drivers.upside_down(edges, "TRIGGER"),
                         [Edge(1, "TRIGGER", 1), Edge(2, "BLANK", 0)])


if __name__ == "__main__":
    unittest.main()
