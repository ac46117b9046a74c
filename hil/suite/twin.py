"""The digital twin, asked as the simulated rig asks it: a report of light in, a photograph out."""
import socket
import struct
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

from witness import plan

PROTO = Path(__file__).resolve().parents[2] / "proto"
LONGEST_S = 300


class Photograph(NamedTuple):
    """dn: R G B a pixel, row by row, 12 bits each; radiance = (dn - black) * gain * scale."""
    width: int
    height: int
    black_dn: int
    scale: float
    dn: list


def unpacked(raw):
    """Samples of a 12-bit packed photograph."""
    low, middle, high = raw[0::3], raw[1::3], raw[2::3]
    dn = [0] * (len(low) * 2)
    dn[0::2] = [a | (b & 15) << 8 for a, b in zip(low, middle)]
    dn[1::2] = [b >> 4 | c << 4 for b, c in zip(middle, high)]
    return dn


def packed(dn):
    """The other way; an even number of samples."""
    first, second = dn[0::2], dn[1::2]
    raw = bytearray(len(first) * 3)
    raw[0::3] = bytes(a & 255 for a in first)
    raw[1::3] = bytes(a >> 8 | (b & 15) << 4 for a, b in zip(first, second))
    raw[2::3] = bytes(b >> 4 for b in second)
    return bytes(raw)


def _protoc(how, message, file, data):
    return subprocess.run(["protoc", f"--{how}=lamella.v1.{message}", f"-I{PROTO}", file],
                          input=data, check=True, capture_output=True).stdout


class Twin:
    """Runs beside us from entry to exit. It writes a session of its own first, truth and all, and its rig's
    calibration."""

    def __init__(self, lamella, subject, scale, session, calibration):
        self._folder = tempfile.TemporaryDirectory()  # a socket's path must be short
        self._path = Path(self._folder.name) / "twin"
        self._command = [lamella, "twin", "--serve", self._path, "--subject", subject, "--scale",
                         str(scale), "--out", session, "--calibration-out", calibration]
        self._process, self._wire = None, socket.socket(socket.AF_UNIX)
        self._wire.settimeout(LONGEST_S)

    def __enter__(self):
        self._process = subprocess.Popen(self._command, stdout=subprocess.PIPE, text=True)
        if not any(line.startswith("serving") for line in self._process.stdout):
            raise ValueError(f"the twin ended with {self._process.wait()}")
        self._wire.connect(str(self._path))
        return self

    def __exit__(self, *_):
        self._wire.close()
        self._process.terminate()
        self._process.wait()
        self._process.stdout.close()
        self._folder.cleanup()

    def _receive(self, count):
        data = bytearray()
        while len(data) < count:
            more = self._wire.recv(count - len(data))
            if not more:
                raise ValueError("the twin fell silent")
            data += more
        return bytes(data)

    def photograph(self, report):
        """Of a lamella.v1.ExposureReport in protobuf's text."""
        message = _protoc("encode", "ExposureReport", "twin.proto", report.encode())
        self._wire.sendall(struct.pack("<I", len(message)) + message)
        (length,) = struct.unpack("<I", self._receive(4))
        header = plan.parse_text(_protoc("decode", "PhotographHeader", "twin.proto",
                                         self._receive(length)).decode())
        if "error" in header:
            raise ValueError(f"the twin says: {header['error'][0]}")
        raw = self._receive(int(header["size_bytes"][0]))
        return Photograph(int(header["width"][0]), int(header["height"][0]),
                          int(float(header["black_level_dn"][0])),
                          float(header["radiance_scale"][0]), unpacked(raw))
