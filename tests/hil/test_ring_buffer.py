import struct
import unittest

from witness import kernel_trace, ring_buffer
from witness.edges import Edge

FORMAT = """name: gpio_value
ID: 953
format:
\tfield:unsigned short common_type;\toffset:0;\tsize:2;\tsigned:0;
\tfield:int common_pid;\toffset:4;\tsize:4;\tsigned:1;

\tfield:unsigned gpio;\toffset:8;\tsize:4;\tsigned:0;
\tfield:int get;\toffset:12;\tsize:4;\tsigned:1;
\tfield:int value;\toffset:16;\tsize:4;\tsigned:1;
"""


def page(body, t_ns=1000, flags=0):
    head = struct.pack("<QQ", t_ns, len(body) | flags)
    return (head + body).ljust(ring_buffer.PAGE_BYTES, b"\0")


def event(delta_ns, payload):
    return struct.pack("<I", delta_ns << 5 | len(payload) // 4) + payload


def gpio_value(gpio, get, value, event_id=953):
    return struct.pack("<HBBiIii", event_id, 0, 0, 1, gpio, get, value)


class RingBufferTest(unittest.TestCase):
    def test_times_add_up_from_the_page(self):
        found = list(ring_buffer.events(page(event(5, b"aaaa") + event(7, b"bbbb"))))
        self.assertEqual(found, [(1005, b"aaaa"), (1012, b"bbbb")])

    def test_a_long_pause_is_in_a_time_extend(self):
        extend = struct.pack("<II", 3 << 5 | ring_buffer.TIME_EXTEND, 2)
        found = list(ring_buffer.events(page(extend + event(1, b"aaaa"))))
        self.assertEqual(found, [(1000 + (2 << 27) + 3 + 1, b"aaaa")])

    def test_a_time_stamp_is_absolute(self):
        stamp = struct.pack("<II", 3 << 5 | ring_buffer.TIME_STAMP, 2)
        found = list(ring_buffer.events(page(stamp + event(1, b"aaaa"))))
        self.assertEqual(found, [((2 << 27) + 3 + 1, b"aaaa")])

    def test_a_long_event_has_its_length_before_it(self):
        payload = b"x" * 120
        body = struct.pack("<II", 5 << 5, 4 + len(payload)) + payload + event(1, b"aaaa")
        self.assertEqual(list(ring_buffer.events(page(body))), [(1005, payload), (1006, b"aaaa")])

    def test_padding_ends_a_page_and_the_next_one_is_read(self):
        first = page(event(5, b"aaaa") + struct.pack("<I", ring_buffer.PADDING) + b"junk")
        found = list(ring_buffer.events(first + page(event(1, b"bbbb"), 2000)))
        self.assertEqual(found, [(1005, b"aaaa"), (2001, b"bbbb")])

    def test_a_trace_that_lost_events_is_refused(self):
        with self.assertRaises(ring_buffer.TraceError):
            list(ring_buffer.events(page(event(5, b"aaaa"), flags=ring_buffer.MISSED)))

    def test_half_a_page_is_refused(self):
        with self.assertRaises(ring_buffer.TraceError):
            list(ring_buffer.events(b"\0" * 100))


class KernelTraceTest(unittest.TestCase):
    names = kernel_trace.read_line_names(
        " gpio-488 (SPI_SCK             |sck                 ) out lo \n"
        " gpio-491 (BLANK               )\n")

    def edges(self, *payloads):
        body = b"".join(event(10, payload) for payload in payloads)
        return kernel_trace.edges(page(body), kernel_trace.read_format(FORMAT), self.names)

    def test_lines_have_the_names_of_the_device_tree(self):
        self.assertEqual(self.names, {488: "SPI_SCK", 491: "BLANK"})

    def test_only_changes_are_edges(self):
        found = self.edges(gpio_value(491, 0, 1), gpio_value(491, 0, 1), gpio_value(491, 0, 0))
        self.assertEqual(found, [Edge(1030, "BLANK", 0)])

    def test_reads_other_lines_and_other_events_are_none(self):
        found = self.edges(gpio_value(491, 0, 1), gpio_value(491, 1, 0), gpio_value(7, 0, 1),
                           gpio_value(491, 0, 0, event_id=12))
        self.assertEqual(found, [])


if __name__ == "__main__":
    unittest.main()
