"""What the command line says about a real rig and its witness."""

import re
from pathlib import Path

from suite.real_rig import Wanted
from witness.analyser import read_channels

PORT = 7391  # as its service listens
DEFAULTS = {
    "rig_file": None,
    "witness": None,
    "driver": None,
    "channels": None,
    "samplerate": None,
    "session": None,
    "selftest": None,
    "programs": None,
    "flashing_confirmed": False,
}


class OptionError(ValueError):
    """The command line does not fit together."""


def add(parser):
    """Options of a real rig alone."""
    group = parser.add_argument_group("a real rig (--target HOST[:PORT])")
    group.add_argument(
        "--rig-file", type=Path, help="the rig's own rig file; its list of LEDs lies beside it"
    )
    group.add_argument(
        "--flashing-confirmed",
        action="store_true",
        help="nobody sits before the rig, or who does was asked and bears flashing light",
    )
    group.add_argument(
        "--driver", help="record with this logic analyser, as sigrok-cli names it (fx2lafw)"
    )
    group.add_argument("--samplerate", help="of that analyser, in Hz, k and M being known (24M)")
    group.add_argument(
        "--witness",
        type=Path,
        help="a recording in place of --driver: FILE.sr or FILE.vcd, saved once the burst is over",
    )
    group.add_argument(
        "--channels",
        help="D0=BLANK,D1=LATCH,...: which channel is on which line; D6=!LIGHT is inverted. "
        "Needed: BLANK LATCH TRIGGER ANALYSER LIGHT; LAMP where there is one; "
        "SPI_SCK SPI_MOSI for the LEDs' bits",
    )
    group.add_argument(
        "--session", type=Path, help="judge this session and --witness again: no burst"
    )
    group.add_argument("--selftest", help="parts of the self-test, as chain,actuator (all of them)")
    group.add_argument(
        "--programs", type=Path, help="where lamella and lamella-rigd are (built here)"
    )


def _hertz(text):
    found = re.fullmatch(r"(\d+(?:\.\d+)?)([kM]?)", text)
    if not found or float(found[1]) == 0:
        raise OptionError(f'--samplerate: "{text}" is no frequency such as 24M')
    return float(found[1]) * {"": 1, "k": 1e3, "M": 1e6}[found[2]]


def _require(holds, otherwise):
    if not holds:
        raise OptionError(otherwise)


def refuse_for(target, arguments):
    """On sim and vm the options of a real rig would be passed over in silence."""
    given = [name for name, default in DEFAULTS.items() if getattr(arguments, name) != default]
    _require(
        not given,
        f"{', '.join('--' + name.replace('_', '-') for name in given)}: of a real rig alone, "
        f"not of target {target}",
    )


def read(arguments):
    """The Wanted; OptionError says what is missing and what to do."""
    _require(
        arguments.rig_file and arguments.rig_file.is_file(),
        "--rig-file: give the rig's own (firmware/board/pi4.rig, ...), which says what a burst is",
    )
    _require(
        arguments.session or arguments.flashing_confirmed,
        "--flashing-confirmed: a burst flashes: say that nobody sits before the rig, or was asked",
    )
    _require(
        not (arguments.driver and arguments.witness), "--driver and --witness: give one of them"
    )
    _require(
        not (arguments.driver and arguments.session),
        "--session: was taken already; give its --witness, no --driver",
    )
    _require(
        not arguments.driver or (arguments.channels and arguments.samplerate),
        "--driver: needs --channels and --samplerate",
    )
    _require(
        not arguments.session or (arguments.session / "timing.json").is_file(),
        f"--session: there is no {arguments.session}/timing.json",
    )
    try:
        channels = read_channels(arguments.channels) if arguments.channels else None
    except ValueError as why:
        raise OptionError(str(why)) from None
    address = arguments.target if ":" in arguments.target else f"{arguments.target}:{PORT}"
    return Wanted(
        address,
        arguments.rig_file,
        channels,
        arguments.witness,
        arguments.driver,
        _hertz(arguments.samplerate) if arguments.samplerate else 0,
        arguments.session,
        arguments.selftest.split(",") if arguments.selftest else [],
    )
