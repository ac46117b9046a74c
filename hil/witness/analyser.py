"""A logic analyser that sigrok knows, or what one has recorded; which channel is on which line."""

import re
import subprocess
import threading
import time
from pathlib import Path

from witness import vcd

STARTS_S, ENDS_S = 20, 60  # the driver may first load the analyser's own firmware
STARTED = "Starting acquisition"


class AnalyserError(Exception):
    """The analyser did not record."""


def read_channels(text):
    """ "D0=BLANK,D6=!LIGHT" to {channel: (line, whether the channel is inverted)}."""
    names = {}
    for word in text.split(","):
        found = re.fullmatch(r"(\w+)=(!?)([A-Z_]+)", word.strip())
        if not found or found[1] in names:
            raise ValueError(
                f'--channels: "{word}" is no CHANNEL=LINE of its own, such as D0=BLANK'
            )
        names[found[1]] = (found[3], found[2] == "!")
    return names


def _convert(path):
    """A session of sigrok to a dump of its lines beside it."""
    dump = path.with_suffix(".sr.vcd")
    done = subprocess.run(
        ["sigrok-cli", "-i", path, "-O", "vcd", "-o", dump],
        stdin=subprocess.DEVNULL,
        capture_output=True,
    )
    if done.returncode != 0 or not dump.exists():
        raise AnalyserError(f"{path}: sigrok-cli cannot read it: {done.stderr.decode().strip()}")
    return dump


def read(path, names):
    """FILE.sr or FILE.vcd."""
    path = Path(path)
    return vcd.read(_convert(path) if path.suffix == ".sr" else path, names)


class Analyser:
    """Records from entry on, for so long, to a dump. On exit it is stopped."""

    def __init__(self, driver, samplerate_hz, names, longest_s, path):
        self.path = path
        self._said, self._has_started = [], False
        # Not a session of sigrok: to add to its archive takes longer the larger that is.
        self._command = [
            "sigrok-cli",
            "--loglevel",
            "4",
            "--driver",
            driver,
            "--config",
            f"samplerate={samplerate_hz:.0f}",
            "--channels",
            ",".join(names),
            "--time",
            f"{longest_s * 1e3:.0f}",
            "--output-format",
            "vcd",
            "--output-file",
            path,
        ]
        self._process = self._listener = None

    def __enter__(self):
        try:
            self._process = subprocess.Popen(
                self._command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
            )
        except OSError as why:
            raise AnalyserError(f"sigrok-cli: {why.strerror}: install sigrok-cli") from None
        started = threading.Event()
        self._listener = threading.Thread(target=self._listen, args=(started,), daemon=True)
        self._listener.start()
        if not started.wait(STARTS_S) or not self._has_started:
            self._stop()
            raise AnalyserError(f"the analyser does not start: {self._complaint()}")
        return self

    def __exit__(self, *_):
        self._stop()

    def _stop(self):
        self._process.terminate()
        self._process.wait()
        self._listener.join()
        self._process.stderr.close()

    def _listen(self, started):
        for line in self._process.stderr:
            self._said.append(line.strip())
            if STARTED in line:
                self._has_started = True
                started.set()
        started.set()  # it ended

    def _complaint(self):
        return "; ".join(self._said[-2:]) or "it says nothing"

    def finish(self):
        """Until it has recorded for as long as it was told to."""
        deadline_s = time.monotonic() + ENDS_S
        try:
            self._process.wait(timeout=max(1.0, deadline_s - time.monotonic()))
        except subprocess.TimeoutExpired:
            raise AnalyserError(f"the analyser does not end: {self._complaint()}") from None
        if self._process.returncode != 0 or not Path(self.path).exists():
            raise AnalyserError(f"the analyser recorded nothing: {self._complaint()}")
