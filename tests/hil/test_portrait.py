"""Photographs of two sessions, told apart only by more than the sensor's noise."""
import json
import pathlib
import random
import tempfile
import unittest

from made_up import exr_of
from suite import exr, portrait
from suite.report import Result

READ, WELL = 0.0004, 30000
SUBJECT = {"camera": "left", "role": "FRONT", "analyser": "CROSS", "file": "front.exr"}
LINES = 16 * (max(portrait.CHUNKS) + 1)


def write_session(folder, radiance, scale, seed):
    """One noisy photograph of an even surface."""
    noise, stored = random.Random(seed), radiance / scale
    sigma = (stored / WELL + READ * READ) ** 0.5
    folder.mkdir()
    (folder / SUBJECT["file"]).write_bytes(exr_of([[tuple(noise.gauss(stored, sigma) for _ in range(3))
                                                   for _ in range(16)] for _ in range(LINES)]))
    camera = {"id": "left", "read_noise": READ, "full_well_electrons": WELL}
    (folder / "session.json").write_text(json.dumps(
        {"rig": {"cameras": [camera]}, "frames": [{**SUBJECT, "radiance_scale": [scale] * 3}]}))


class Portrait(unittest.TestCase):
    def verdict(self, ours, twins=0.1):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            write_session(folder / "ours", ours, 1, 1)
            write_session(folder / "twins", twins, 1, 2)
            measures = portrait.frames_agree(folder / "ours", folder / "twins")
            return Result("", measures, []).verdict()

    def test_the_same_light_with_other_noise_agrees_and_one_percent_more_does_not(self):
        self.assertEqual(self.verdict(0.1), "pass")
        self.assertEqual(self.verdict(0.101), "FAIL")

    def test_lines_come_back_out_of_an_image_packed_or_not(self):
        rows = [[(x / 64, y / 64, 0.5) for x in range(8)] for y in range(20)]
        for chunk, top in ((0, 0), (1, 16)):
            found = exr.lines(exr_of(rows), chunk)
            self.assertEqual(found, [tuple(zip(*row)) for row in rows[top:top + 16]])


if __name__ == "__main__":
    unittest.main()
