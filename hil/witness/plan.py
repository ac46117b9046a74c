"""The burst that a rig file asks for, as `lamella-rigd --plan` writes it."""
import pathlib
import re
import shutil
import subprocess
from typing import NamedTuple

TOKEN = re.compile(r'\s*(?:(\w+)\s*(\{|:\s*("(?:[^"\\]|\\.)*"|\S+))|(\}))')


class PlannedEdge(NamedTuple):
    """One edge of the plan; t_us is counted from the burst's zero."""
    t_us: float
    tolerance_us: float
    line: str
    value: int
    step: int


class Plan(NamedTuple):
    """Edges in the order of time; roles[step] is a name of Frame.Role, indices[step] its index."""
    edges: list
    roles: list
    indices: list = []


def parse_text(text):
    """protobuf's text format to nested {field: [values]}; numbers stay text."""
    root, stack = {}, []
    current = root
    for name, opener, value, closer in TOKEN.findall(text):
        if closer:
            current = stack.pop()
        elif opener == "{":
            stack.append(current)
            current = current.setdefault(name, [])
            current.append({})
            current = current[-1]
        else:
            current.setdefault(name, []).append(value.strip('"'))
    return root


def _number(message, field):
    return float(message.get(field, ["0"])[0])


def from_text(text):
    """protoc's --decode of a lamella.v1.Plan; fields that are 0 are not written."""
    message = parse_text(text)
    edges = [PlannedEdge(_number(edge, "planned_us"), _number(edge, "tolerance_us"),
                         edge["line"][0], int(_number(edge, "value")), int(_number(edge, "step")))
             for edge in message.get("edges", [])]
    roles = [step.get("role", ["ROLE_UNSPECIFIED"])[0] for step in message.get("steps", [])]
    indices = [int(_number(step, "index")) for step in message.get("steps", [])]
    if message.get("refusal"):
        raise ValueError(f"the rig would not play this plan: {message['refusal'][0]}")
    return Plan(edges, roles, indices)


def read(rigd, rig_file, proto_folder):
    """Asks the firmware for its plan."""
    encoded = subprocess.run([rigd, "--plan", "--rig", rig_file], check=True, capture_output=True)
    decoded = subprocess.run(
        ["protoc", "--decode=lamella.v1.Plan", f"-I{proto_folder}", "plan.proto"],
        input=encoded.stdout, check=True, capture_output=True)
    return from_text(decoded.stdout.decode())


def other_rest(rig_file, folder):
    """The same rig in a folder of its own, its analyser at the other end before the burst."""
    rig_file = pathlib.Path(rig_file)
    shutil.copytree(rig_file.parent, folder, dirs_exist_ok=True)
    other = {"parallel": "crossed", "crossed": "parallel"}
    turned = folder / rig_file.name
    turned.write_text(re.sub(r"(?m)^(analyser\.park\s*=\s*)(parallel|crossed)",
                             lambda found: found[1] + other[found[2]],
                             rig_file.read_text(encoding="utf-8")), encoding="utf-8")
    return turned


def led_steps(plan):
    """Steps that load the LED chain, in the order of the plan."""
    return [edge.step for edge in plan.edges if edge.line == "SHIFT"]


def read_leds(rig_file):
    """The list of LEDs that a rig file names, `led.N = chip output x y z`, to
    [(chip, output, (x, y, z))]."""
    rig_file = pathlib.Path(rig_file)
    named = re.search(r"^\s*leds\.file\s*=\s*(\S+)", rig_file.read_text(encoding="utf-8"), re.M)
    leds = []
    for line in (rig_file.parent / named[1]).read_text(encoding="utf-8").splitlines():
        found = re.match(r"\s*led\.\d+\s*=\s*(.*?)\s*(#|$)", line)
        if found:
            chip, output, *direction = found[1].split()
            leds.append((int(chip), int(output), tuple(map(float, direction))))
    return leds


def read_numbers(rig_file):
    """Every `key = number` of a rig file to {key: number}."""
    numbers = {}
    with open(rig_file, encoding="utf-8") as lines:
        for line in lines:
            found = re.match(r"\s*([\w.]+)\s*=\s*([-+\d.e]+)\s*(#|$)", line)
            if found:
                numbers[found[1]] = float(found[2])
    return numbers
