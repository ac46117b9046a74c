"""A host as its user has it: the program lamella, its keys, a line to the rig that can be cut."""
import os
import socket
import subprocess
import threading

from suite import exr
from suite.pictures import CARD, KEY_BITS

LONGEST_S = 120
DARKEST_OF_BRIGHT, BRIGHTEST_OF_DARK = 0.55, 0.2  # of a camera's full scale; the test card is between


class Line:
    """A TCP proxy of an address that stays while the machine behind it is booted again."""

    def __init__(self):
        self.port = None  # of the rig, now
        self.connections = 0
        self._cuts = []
        self._on_cut = None
        self._door = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._door.getsockname()[1]}"
        threading.Thread(target=self._serve, daemon=True).start()

    def cut_after(self, *counts, on_cut=None):
        """The next connections are cut after so many bytes from the rig, one count each."""
        self._on_cut = on_cut
        self._cuts = list(counts)

    def cuts_left(self):
        """Of those asked for."""
        return len(self._cuts)

    def _serve(self):
        while True:
            host = self._door.accept()[0]
            self.connections += 1
            try:
                rig = socket.create_connection(("127.0.0.1", self.port), timeout=LONGEST_S)
            except OSError:
                host.close()
                continue
            threading.Thread(target=self._pass, args=(host, rig, False), daemon=True).start()
            threading.Thread(target=self._pass, args=(rig, host, True), daemon=True).start()

    def _pass(self, source, sink, from_rig):
        passed = 0
        try:
            while data := source.recv(16384):
                sink.sendall(data)
                passed += len(data)
                if from_rig and self._cuts and passed >= self._cuts[0]:
                    self._cuts.pop(0)
                    if self._on_cut:
                        self._on_cut()
                    break
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass


class Host:
    """One user's lamella."""

    def __init__(self, program, folder):
        self._program = program
        self.config = folder / "lamella"
        self._environment = {**os.environ, "XDG_CONFIG_HOME": str(folder)}

    def start(self, *arguments):
        """Runs it beside us."""
        return subprocess.Popen([self._program, *map(str, arguments)], env=self._environment,
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True)

    def run(self, *arguments):
        """(exit status, what it printed, what it complained of)."""
        process = self.start(*arguments)
        try:
            out, errors = process.communicate(timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            process.kill()
            out, errors = process.communicate()
            errors += f" (killed after {LONGEST_S} s)"
        return process.returncode, out, errors.strip()


def key_in_exr(image):
    """The key that a developed picture carries in its first row, CARD, or None for neither."""
    values = exr.lines(image)[0][0][:KEY_BITS]
    if any(BRIGHTEST_OF_DARK < value < DARKEST_OF_BRIGHT for value in values):
        return CARD if all(BRIGHTEST_OF_DARK < v < DARKEST_OF_BRIGHT for v in values) else None
    return f"{sum((value > DARKEST_OF_BRIGHT) << bit for bit, value in enumerate(values)):016x}"
