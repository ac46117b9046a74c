"""firmware/board: pin table (README.md), overlay and rig file of each board say the same, and every
overlay compiles."""
import json
import pathlib
import re
import shutil
import subprocess
import unittest

BOARD = pathlib.Path(__file__).resolve().parents[2] / "firmware/board"
# Board, the heading of its table, what its chain's bus and thermometer take.
BOARDS = {"pi4": ("### Raspberry Pi 4 and 5", {2, 3, 8, 9, 10, 11}),
          "pi5": ("### Raspberry Pi 4 and 5", {2, 3, 8, 9, 10, 11}),
          "beagleplay": ("### BeaglePlay", {7, 8, 14})}
# What a pad's bits say (of a BeaglePlay's processor), and devices that have pads of its sockets.
PULL_UP, INPUT, GPIO_MODE = 1 << 17, 1 << 18, 7
OWNERS = {"main_i2c1": {28, 29}, "main_i2c3": {22, 23}, "main_uart5": {24, 25}}


def pin_table(heading):
    """Rows of the first table behind a heading: {line: (offset, pin, direction, pull)}."""
    text = (BOARD / "README.md").read_text().split(heading + "\n", 1)[1]
    rows = {}
    for line in text.splitlines():
        if line.startswith("#"):
            break
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|") and len(cells) > 4 and cells[1].isdigit():
            assert cells[0] not in rows, f"{cells[0]} stands twice"
            rows[cells[0]] = (int(cells[1]), *cells[2:5])
    return rows


def overlay(board):
    text = (BOARD / f"lamella-{board}.dts").read_text()
    return re.sub(r"//.*", "", text)


def line_names(board):
    """{name: offset} as the overlay gives them."""
    listed = re.search(r"gpio-line-names = (.*?);", overlay(board), re.S)[1]
    return {name: at for at, name in enumerate(re.findall(r'"(.*?)"', listed)) if name}


def pads():
    """[(line, bits, what the comment calls them)] of a BeaglePlay. Its processor has lines 0 to 40 of
    GPIO1 on pads in a row, from 0x178 on, four bytes each."""
    group = re.search(r"lamella_lines: [\w-]+ \{(.*?)\}", overlay("beagleplay"), re.S)[1]
    rows = re.findall(r"(0x\w+) (0x\w+) /\* GPIO1_(\d+ \w+) \*/", group)
    assert len(rows) == group.count("0x") / 2, "a pad without its line and name"
    return [((int(pad, 16) - 0x178) // 4, int(bits, 16), said) for pad, bits, said in rows]


def pulls(board):
    """{offset: pull} as the overlay sets them."""
    if board == "beagleplay":
        return {line: "up" if bits & PULL_UP else "down" for line, bits, _ in pads()}
    text = overlay(board)
    found = {}
    for group in re.findall(r"lamella_(?:up|down): [\w-]+ \{(.*?)\}", text, re.S):
        pins = re.search(r"pins = (.*?);", group, re.S)[1]
        up = "bias-pull-up" in group or "brcm,pull = <2>" in group
        for pin in re.findall(r"\d+", pins):
            assert int(pin) not in found, f"pin {pin} has two pulls"
            found[int(pin)] = "up" if up else "down"
    return found


def rig_lines(board):
    text = (BOARD / f"{board}.rig").read_text()
    return re.findall(r"^linux\.\w+_line\s*=\s*(\S+)", text, re.M)


class EveryBoard(unittest.TestCase):
    def each(self):
        for board, (heading, taken) in BOARDS.items():
            with self.subTest(board):
                yield board, pin_table(heading), taken

    def test_has_the_overlays_names_where_its_table_has_them(self):
        for board, table, _ in self.each():
            self.assertEqual({name: row[0] for name, row in table.items()}, line_names(board))

    def test_has_a_rig_file_that_takes_every_line_of_the_table_and_no_other(self):
        for board, table, _ in self.each():
            lines = rig_lines(board)
            self.assertEqual(len(lines), len(set(lines)))
            self.assertEqual(set(lines), set(table))

    def test_uses_no_pin_twice(self):
        for _, table, taken in self.each():
            offsets = [row[0] for row in table.values()]
            self.assertEqual(len(offsets), len(set(offsets)))
            self.assertFalse(set(offsets) & taken, "a pin of the chain's bus or the thermometer")
            pins = [row[1] for row in table.values()]
            self.assertEqual(len(pins), len(set(pins)))

    def test_pulls_each_line_as_its_table_says(self):
        for board, table, _ in self.each():
            self.assertEqual({row[0]: row[3] for row in table.values()}, pulls(board))

    def test_pulls_blank_up_and_what_moves_or_shines_down(self):
        for _, table, _ in self.each():
            self.assertEqual(table["BLANK"][3], "up")
            for name in ("TRIGGER", "LAMP", "ANALYSER", "ESTOP", "START"):
                self.assertEqual(table[name][3], "down", name)

    def test_names_a_node_for_the_chain_that_spidev_knows(self):
        for board, _, _ in self.each():
            self.assertIn('compatible = "rohm,dh2228fv"', overlay(board))

    @unittest.skipUnless(shutil.which("dtc"), "there is no dtc (device-tree-compiler)")
    def test_has_an_overlay_that_compiles_without_a_warning(self):
        for board, _, _ in self.each():
            done = subprocess.run(["dtc", "-@", "-I", "dts", "-O", "dtb", "-o", "/dev/null",
                                   BOARD / f"lamella-{board}.dts"], capture_output=True)
            self.assertEqual((done.returncode, done.stderr.decode()), (0, ""))


class RaspberryPi(unittest.TestCase):
    def test_header_pins_carry_the_lines_of_their_offsets(self):
        header = {2: 3, 3: 5, 4: 7, 17: 11, 18: 12, 27: 13, 22: 15, 23: 16, 24: 18, 25: 22, 5: 29,
                  6: 31, 12: 32, 13: 33, 19: 35, 16: 36, 26: 37, 20: 38, 21: 40}
        for name, row in pin_table(BOARDS["pi4"][0]).items():
            self.assertEqual(str(header[row[0]]), row[1], name)

    def test_takes_power_from_pins_that_give_it_and_puts_no_line_there(self):
        supply = {"5 V": {2, 4}, "3.3 V": {1, 17}, "Ground": {6, 9, 14, 20, 25, 30, 34, 39}}
        text = " ".join((BOARD / "README.md").read_text().split())
        named = {"5 V": re.search(r"\+5 V on pins ([\d, and]+)", text)[1],
                 "3.3 V": re.search(r"own 3\.3 V on pins ([\d, and]+)", text)[1],
                 "Ground": re.search(r"Ground: ([\d, ]+)", text)[1]}
        self.assertEqual({rail: set(map(int, re.findall(r"\d+", pins)))
                          for rail, pins in named.items()}, supply)
        lines = {int(row[1]) for row in pin_table(BOARDS["pi4"][0]).values()}
        self.assertFalse(lines & set().union(*supply.values()))

    def test_has_a_time_out_for_libcamera_that_its_pipeline_takes_and_the_unit_names(self):
        for board, target in (("pi4", "bcm2835"), ("pi5", "pisp")):
            text = (BOARD / f"libcamera-{board}.yaml").read_text()
            config = json.loads(re.sub(r"^#.*", "", text, flags=re.M))
            self.assertEqual((config["version"], config["target"]), (1.0, target))
            self.assertGreater(config["pipeline_handler"]["camera_timeout_value_ms"], 12 * 3600e3)
        unit = (BOARD / "lamella-rigd.service").read_text()
        self.assertIn("Environment=LIBCAMERA_RPI_CONFIG_FILE=/etc/lamella/libcamera.yaml\n", unit)

    def test_blank_is_on_a_pin_that_is_up_before_any_software(self):
        self.assertLessEqual(pin_table(BOARDS["pi4"][0])["BLANK"][0], 8)


class BeaglePlay(unittest.TestCase):
    def test_pins_of_its_sockets_carry_the_lines_of_their_offsets(self):
        socket = {10: "AN", 12: "RST", 13: "CS", 11: "PWM", 9: "INT", 24: "RX", 25: "TX", 22: "SCL",
                  23: "SDA", 28: "Grove 1", 29: "Grove 2"}
        for name, row in pin_table(BOARDS["beagleplay"][0]).items():
            self.assertEqual(socket[row[0]], row[1], name)

    def test_makes_every_pad_of_a_line_an_input_of_the_gpio_that_pulls(self):
        for line, bits, said in pads():
            self.assertEqual(bits & ~PULL_UP, INPUT | GPIO_MODE, said)

    def test_says_beside_each_pad_which_line_it_is(self):
        names = {line: name for name, line in line_names("beagleplay").items()}
        for line, _, said in pads():
            self.assertEqual(said, f"{line} {names.get(line)}")

    def test_takes_every_line_from_the_device_that_has_its_pad(self):
        disabled = set(re.findall(r'&(\w+) \{\s*status = "disabled";', overlay("beagleplay")))
        lines = {line for line, _, _ in pads()}
        self.assertEqual(disabled, {device for device, has in OWNERS.items() if has & lines})


    def test_names_the_codes_that_its_light_alone_does_not_tell_from_ready_and_these_are_all(self):
        text = (BOARD.parents[1] / "README.md").read_text().split("| code | light | buzzer |", 1)[1]
        table = text.split("\n\n", 1)[0]
        lights = dict(re.findall(r"^\| (\w[^|]+?) \| ([^|]+?) \|", table, re.M))
        alike = {code for code, light in lights.items() if light == lights["ready"]}
        self.assertEqual(len(set(lights.values())), len(lights) - len(alike) + 1)
        guide = " ".join((BOARD / "README.md").read_text().split())
        said = re.search(r"It does not tell (.*?) apart", guide)[1]
        self.assertEqual(set(re.findall(r"`(\w+)`", said)), alike)


def parts():
    """The bill of materials: {part: [counts]}, a part for each ';' or ',' group of its row."""
    text = (BOARD / "README.md").read_text().split("## Parts\n", 1)[1].split("\n## ", 1)[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")]
            for line in text.splitlines() if line.startswith("| ")]
    return {row[0]: [int(count) for count in re.findall(r"\d+", row[2])]
            for row in rows if re.search(r"\d", row[2])}


def count(part):
    found = [counts for name, counts in parts().items() if name.startswith(part)]
    assert len(found) == 1, f"{part}: {len(found)} rows"
    return found[0]


def prose(pattern):
    """The number that the first group of a pattern finds in the guide."""
    return float(re.search(pattern, " ".join((BOARD / "README.md").read_text().split()))[1])


class TheGuide(unittest.TestCase):
    LEDS = len(re.findall(r"^led\.\d+ ", (BOARD / "dome150.leds").read_text(), re.M))

    def test_lists_a_stage_a_pull_up_and_a_film_for_every_led(self):
        self.assertEqual(count("LED, white"), [self.LEDS])
        self.assertEqual(count("power stage"), [self.LEDS])
        self.assertEqual(count("its RSET"), [self.LEDS, self.LEDS])
        self.assertEqual(count("pull-up of an output"), [self.LEDS])
        self.assertEqual(count("polarizing film"), [self.LEDS + 2])

    def test_lists_gates_and_pull_downs_for_every_led_and_not_eight_too_many(self):
        for part in ("inverting buffer", "pull-down array of EN"):
            self.assertLess(8 * count(part)[0] - self.LEDS, 8, part)
            self.assertGreaterEqual(8 * count(part)[0], self.LEDS, part)

    def test_lists_the_chips_that_the_led_file_names(self):
        chips = re.findall(r"^led\.\d+ = (\d)", (BOARD / "dome150.leds").read_text(), re.M)
        self.assertEqual(count("LED driver"), [len(set(chips))])
        self.assertEqual(count("its IREF"), count("LED driver"))

    def test_has_a_fuse_and_a_capacitor_for_every_branch_and_branches_for_every_led(self):
        branches = count("capacitor, 2200 uF")[0]
        self.assertEqual(count("fuse and holder, 7.5 A")[0], branches)
        self.assertEqual(branches * prose(r"branches of (\d+) LEDs"), self.LEDS)

    def test_lists_a_resistor_for_the_diode_of_every_slot_sensor_on_either_board(self):
        sensors, on_a_pi, pull_downs = count("slot sensor")
        self.assertEqual((on_a_pi, pull_downs), (sensors, sensors))
        self.assertEqual(count("BeaglePlay alone"), [1, sensors])

    def test_gives_the_pulled_up_sensors_of_a_beagleplay_more_than_they_have_to_sink(self):
        least_ma = 0.1 * 1e3 * (3.3 - 1.25) / prose(r"from that socket's 3\.3 V by (\d+) ohm")
        self.assertGreater(least_ma, 1.5 * prose(r"against the ([\d.]+) mA of"))

    def test_lists_a_capacitor_for_every_chip(self):
        chips = count("LED driver") + count("inverting buffer") + [21]
        self.assertEqual(count("decoupling"), [sum(chips)])

    def test_gives_the_leds_no_more_than_their_supply_has(self):
        lit_a = prose(r"(\d+\.\d) A while lit")
        self.assertGreaterEqual(lit_a, self.LEDS * 0.35)
        self.assertLess(lit_a, prose(r"RSP-320-5: (\d+) A"))
        self.assertLess(lit_a / count("capacitor, 2200 uF")[0], 0.75 * 7.5)  # of a blade fuse

    def test_times_the_monostable_as_the_self_test_judges_it(self):
        rc_ms = prose(r"(\d+) kohm 1 % and 100 nF film") * 1e3 * 100e-9 * 1e3
        source = (BOARD.parent / "selftest_blank.c").read_text()
        least_ms, most_ms = (float(re.search(name + r" = (\d+)", source)[1])
                             for name in ("kHoldsAtLeastMs", "kHoldsAtMostMs"))
        self.assertGreater(0.45 * rc_ms * 0.94, least_ms)
        self.assertLess(0.55 * rc_ms * 1.06, most_ms)

    def test_brings_up_every_part_of_the_self_test_and_none_that_it_lacks(self):
        source = (BOARD.parent / "selftest.c").read_text()
        known = set(re.findall(r"\[SELFTEST_\w+\] = \{\"(\w+)\"", source))
        steps = (BOARD / "README.md").read_text().split("## Bringing it up", 1)[1]
        self.assertEqual(set(re.findall(r"--only (\w+)", steps)), known)

    def test_begins_with_rig_files_that_name_no_device_that_is_not_plugged_yet(self):
        steps = (BOARD / "README.md").read_text().split("## Bringing it up", 1)[1]
        keys = (BOARD.parent / "rig_linux_keys.def").read_text()
        optional = set(re.findall(r"^(?:TEXT|LINE)\((\w+), false\)", keys, re.M))
        command = re.search(r"^    sed -i -E '([^']+)' \S+$", steps, re.M)[1]
        for board in BOARDS:
            was = (BOARD / f"{board}.rig").read_text()
            now = subprocess.run(["sed", "-E", command], input=was, text=True, check=True,
                                 capture_output=True).stdout
            named = r"^linux\.(\w+)"
            gone = set(re.findall(named, was, re.M)) - set(re.findall(named, now, re.M))
            self.assertEqual(gone, {"temperature_file", "display_device", "display_connector",
                                    "camera_left", "camera_right", "camera_trigger"}, board)
            self.assertLessEqual(gone, optional)
            for key in gone:  # at its step again
                told = "camera_" if key.startswith("camera_") else key
                self.assertRegex(steps, rf"\. \*\*.*\*\* With .*`linux\.{told}`", key)

    def test_gives_the_first_calibration_cameras_as_large_as_the_rig_files_that_see_as_much(self):
        made = {name: (float(was), float(now)) for name, was, now in re.findall(
            r's/"(\w+)": ([\d.]+)(?:\.\*)?,/"\w+": ([\d.]+),/', (BOARD / "README.md").read_text())}
        width, height = (float(re.search(rf"^camera\.{side}_px\s*=\s*(\d+)",
                                         (BOARD / "pi5.rig").read_text(), re.M)[1])
                         for side in ("width", "height"))
        self.assertEqual(made["width"], (60, width))
        self.assertEqual(made["height"], (75, height))
        for focal in ("fx", "fy"):
            self.assertAlmostEqual(made[focal][1] / width, (800 / 3) / 60, places=3)
        self.assertEqual(made["cx"], (59 / 2, (width - 1) / 2))
        self.assertEqual(made["cy"], (74 / 2, (height - 1) / 2))

    def test_draws_every_line_that_the_board_drives(self):
        drawn = "".join((BOARD / f"{name}.svg").read_text() for name in ("block", "wiring"))
        words = "".join(re.findall(r"<text[^>]*>(.*?)</text>", drawn)).replace("-", "")
        for name, row in pin_table(BOARDS["pi4"][0]).items():
            if row[2] == "out":
                self.assertIn(name, words)

    def test_names_readings_as_the_self_test_names_them(self):
        steps = (BOARD / "README.md").read_text().split("## Bringing it up", 1)[1]
        sources = "".join(file.read_text() for file in BOARD.parent.glob("selftest*.c"))
        rows = re.findall(r"^ {6,}(\w+) {2,}(\S+(?: \S+)*) {2,}", steps, re.M)
        self.assertGreater(len(rows), 12)
        for part, what in rows:
            self.assertTrue(f'"{what}"' in sources, f"{part}: {what}")

    def test_shows_readings_in_the_columns_of_the_program(self):
        steps = (BOARD / "README.md").read_text().split("## Bringing it up", 1)[1]
        asked = r"^ +\$ lamella rig selftest --only \w+\n(.*?)\n\n"
        for shown in re.findall(asked, steps, re.M | re.S):
            for row in shown.splitlines():
                columns = re.sub(r"^ {7,8}(?=  \w)", "", row)
                self.assertRegex(columns, r"^  \S.{11} \S.{29} \S.{17} .{24} (good|skipped)( {4,6}\S.*)?$")

    def test_names_the_driver_that_its_rig_files_name(self):
        for board in BOARDS:
            driver = re.search(r"^leds\.driver\s*=\s*(\w+)", (BOARD / f"{board}.rig").read_text(), re.M)
            self.assertIn(driver[1].upper(), (BOARD / "README.md").read_text())


if __name__ == "__main__":
    unittest.main()
