"""calibration.py RIG: a calibration for a rig whose cameras nobody has measured, on stdout: sizes, LEDs and patterns
are the rig file's, the rest is made up."""
import json
import re
import sys
from pathlib import Path


def calibration(rig_file):
    """What a rig gives with its photographs: this rig file's LEDs, cameras and patterns."""
    numbers = dict(
        re.findall(r"(?m)^([\w.]+)\s*=\s*([-\d.]+)", rig_file.read_text(encoding="utf-8"))
    )
    value = {key: float(text) for key, text in numbers.items()}
    leds = re.findall(
        r"(?m)^led\.\d+\s*=\s*\d+\s+\d+\s+(\S+)\s+(\S+)\s+(\S+)",
        (rig_file.parent / "dome150.leds").read_text(encoding="utf-8"),
    )
    camera = {
        "width": int(value["camera.width_px"]),
        "height": int(value["camera.height_px"]),
        "fx": 500,
        "fy": 500,
        "cx": (value["camera.width_px"] - 1) / 2,
        "cy": (value["camera.height_px"] - 1) / 2,
        "rotation": [1, 0, 0, 0, -1, 0, 0, 0, -1],
        "saturation": 1,
        "read_noise": 0.001,
        "full_well_electrons": 10000,
        "extinction": 0,
    }
    placed = [
        {**camera, "id": name, "translation_mm": [x, 0, 700]}
        for name, x in (("left", 100), ("right", -100))
    ]
    return {
        "format": "lamella.session.v1",
        "rig": {
            "leds": [{"direction": [float(v) for v in led]} for led in leds],
            "cameras": placed,
            "projector": {
                **placed[0],
                "id": "projector",
                "width": int(value["projector.width_px"]),
                "height": int(value["projector.height_px"]),
                "translation_mm": [0, 0, 700],
            },
        },
        "patterns": {
            "fringe": {"periods": [value[f"pattern.fringe_{i}_periods"] for i in range(4)]},
            "stripes": {
                "period_px": value["pattern.stripe_period_px"],
                "shift_px": value["pattern.stripe_shift_px"],
            },
            "dots": {
                "pitch_px": value["pattern.dot_pitch_px"],
                "diameter_px": value["pattern.dot_diameter_px"],
                "offset_px": [value["pattern.dot_offset_u_px"], value["pattern.dot_offset_v_px"]],
            },
        },
    }


if __name__ == "__main__":
    print(json.dumps(calibration(Path(sys.argv[1]))))
