import pathlib
import tempfile
import unittest

from made_up import clocked
from witness import led_chain, vcd
from witness.edges import Edge


class LedChainTest(unittest.TestCase):
    def test_the_first_bit_out_is_the_top_of_the_last_chips_output_23(self):
        bits = led_chain.encode({(6, 23): 0x800})
        self.assertEqual((bits[0], sum(bits), len(bits)), (1, 1, 2016))

    def test_the_last_bit_out_is_the_bottom_of_the_first_chips_output_0(self):
        bits = led_chain.encode({(0, 0): 1})
        self.assertEqual((bits[-1], sum(bits)), (1, 1))

    def test_decoding_undoes_encoding(self):
        codes = {(chip, output): (chip * 700 + output * 31) % 4096
                 for chip in range(7) for output in range(24)}
        self.assertEqual(led_chain.decode(led_chain.encode(codes)), codes)

    def test_a_gradient_is_half_where_the_led_stands_across_it(self):
        leds = [(0, 0, (1.0, 0.0, 0.0)), (0, 1, (-1.0, 0.0, 0.0)), (0, 2, (0.0, 1.0, 0.0))]
        self.assertEqual(led_chain.codes_for(leds, "GRADIENT_X"),
                         {(0, 0): 4095, (0, 1): 0, (0, 2): 2048})
        self.assertEqual(set(led_chain.codes_for(leds, "GRADIENT_FULL").values()), {4095})

    def test_bits_are_rebuilt_from_the_bus(self):
        bits = (1, 0, 1, 1, 0, 0, 1, 0)
        (frame,) = led_chain.frames(clocked(bits))
        self.assertEqual((frame.bits, frame.dark), (bits, True))
        self.assertEqual(led_chain.to_bytes(frame.bits), b"\xb2")

    def test_each_latch_ends_a_frame(self):
        edges = clocked((1, 0)) + clocked((0, 0, 1), start_ns=9000)
        self.assertEqual([f.bits for f in led_chain.frames(edges)], [(1, 0), (0, 0, 1)])

    def test_a_latch_without_bits_is_an_empty_frame(self):
        self.assertEqual(led_chain.frames([Edge(5, "LATCH", 1)])[0].bits, ())

    def test_bits_that_come_while_latch_is_high_are_functions(self):
        edges = [Edge(1, "LATCH", 1)] + clocked((1, 0))[:-2] + [
            Edge(5000, "LATCH", 0), Edge(5001, "LATCH", 1), Edge(5002, "LATCH", 0)]
        edges += clocked((0, 1), start_ns=6000)
        self.assertEqual([(f.bits, f.functions) for f in led_chain.frames(edges)],
                         [((), False), ((1, 0), True), ((0, 1), False)])

    def test_functions_say_full_current_in_repeated_12_bit_periods(self):
        chip = led_chain.FUNCTIONS[:288]
        self.assertEqual((len(led_chain.FUNCTIONS), led_chain.FUNCTIONS), (2016, chip * 7))
        register = chip[::-1]  # bit 0 goes in last
        self.assertEqual(set(register[:168]), {1})        # dot correction
        self.assertEqual(set(register[168:192]), {1})     # brightness
        self.assertEqual(register[192:199], (1, 1, 1, 1, 0, 0, 0))
        self.assertEqual(set(register[199:]), {0})

    def test_zeros_and_functions_before_a_burst_are_no_part_of_it(self):
        before = clocked((0, 0)) + [Edge(2000, "LATCH", 1)] + clocked((1, 1), 2100)[:-2] + [
            Edge(3000, "LATCH", 0), Edge(3001, "LATCH", 1), Edge(3002, "LATCH", 0)]
        burst = clocked((1, 0), 4000) + clocked((0, 0), 5000)
        self.assertEqual(led_chain.split(before + burst), (before, burst))
        self.assertEqual(led_chain.split(burst), ([], burst))

    def test_light_while_bits_move_is_seen(self):
        edges = clocked((1, 0, 1, 0))
        for at in (0, 3, len(edges) - 2):
            lit = edges[:at] + [Edge(edges[at].t_ns, "BLANK", 0)] + edges[at:]
            self.assertFalse(led_chain.frames(lit)[0].dark, at)

    def test_light_that_ends_before_the_bits_is_no_fault(self):
        lit = [Edge(1, "BLANK", 0), Edge(2, "BLANK", 1)] + clocked((1, 0))
        self.assertTrue(led_chain.frames(lit)[0].dark)


class VcdTest(unittest.TestCase):
    def test_nanoseconds_and_first_levels_are_kept(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "lines.vcd"
            vcd.write(path, [Edge(500, "BLANK", 0), Edge(507, "BLANK", 1)], ("BLANK", "LATCH"))
            text = path.read_text()
        self.assertIn("$timescale 1 ns $end", text)
        self.assertTrue(text.endswith("#0\n1!\n0\"\n#1000\n0!\n#1007\n1!\n"))


if __name__ == "__main__":
    unittest.main()
