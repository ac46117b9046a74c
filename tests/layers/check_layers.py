"""check_layers.py ROOT: prints each include that does not run the way the design says."""
import pathlib
import re
import sys

# A room may include itself and these. `proto` is the generated messages.
HOST = {
    "base": set(),
    "model": {"base"},
    "io": {"base", "proto"},
    "calib": {"base", "io", "proto"},
    "fit": {"base", "model", "io", "calib", "proto"},
    "render": {"base", "model", "io", "proto"},
    "export": {"base", "model", "io", "proto"},
    "review": {"base", "model", "io", "proto"},
    "apps": {"base", "model", "io", "calib", "fit", "render", "export", "review", "twin", "proto"},
    "twin": {"base", "io", "proto"},
}
# Only these firmware files may touch the operating system.
FIRMWARE_OS = re.compile(r"^(hal_.*|store.*|link.*|supervise.*|collector|input_file|main)\.(c|cpp|h)$")
OS_HEADER = re.compile(
    r"^(sys/|systemd/|arpa/|netinet/|linux/|net/|"
    r"(unistd|fcntl|signal|poll|pthread|sched|dirent|termios|netdb)\.h$)")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
MAX_LINES = 500


def includes(path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        found = INCLUDE.match(line)
        if found:
            yield number, found.group(1) == "<", found.group(2)


def room_of(header):
    return "proto" if header.endswith(".pb.h") else header.split("/")[0]


def host_faults(path, room):
    for number, _, header in includes(path):
        to = room_of(header)
        if "firmware" in header or header.startswith("hal"):
            yield f"{path}:{number}: host includes firmware: {header}"
        elif (to in HOST or to == "proto") and to != room and to not in HOST[room]:
            yield f"{path}:{number}: {room} must not include {header}"


def firmware_faults(path):
    for number, system, header in includes(path):
        if room_of(header) in HOST and "/" in header and not system:
            yield f"{path}:{number}: firmware includes host: {header}"
        if system and OS_HEADER.match(header) and not FIRMWARE_OS.match(path.name):
            yield (f"{path}:{number}: only hal_*, store*, link*, supervise*, collector, input_file and main "
                   f"may include <{header}>")


def sources(folder):
    return (p for p in sorted(folder.rglob("*")) if p.suffix in {".c", ".cpp", ".h"})


def faults(root):
    for room in HOST:
        folder = root / ("hil/twin" if room == "twin" else f"host/{room}")
        for path in sources(folder):
            yield from host_faults(path, room)
    for path in sources(root / "firmware"):
        yield from firmware_faults(path)
    for part in ("host", "hil", "firmware"):
        for path in sources(root / part):
            lines = len(path.read_text().splitlines())
            if lines > MAX_LINES:
                yield f"{path}: {lines} lines; split files of more than {MAX_LINES}"


def main():
    found = list(faults(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or "every include runs the way the design says")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
