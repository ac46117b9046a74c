"""The virtual machine on the real clock: its console takes commands, its port is the rig's link."""
import os
import queue
import shlex
import signal
import socket
import subprocess
import threading
import time

LISTENS, STATUS = "hil-listens", "hil-status "
BOOT_S, COMMAND_S = 120, 60
DISK_MB = 256


class MachineError(Exception):
    """The machine did not do what it was told."""


def make_disk(path):
    """An empty file system for a rig's store and keys."""
    with open(path, "wb") as disk:
        disk.truncate(DISK_MB << 20)
    subprocess.run(["mkfs.ext4", "-q", "-F", path], check=True)


def free_port():
    """A port of this machine that nobody has."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Machine:
    """Booted on entry; on exit its power is cut, if it is still on."""

    def __init__(self, root, cache, kernel, out, disk):
        out.mkdir(parents=True, exist_ok=True)
        self.port = free_port()
        self.address = f"127.0.0.1:{self.port}"
        self._boot = [root / "hil/vm/boot", cache, kernel, out, "world.d", disk, str(self.port)]
        self._lines = queue.Queue()
        self._process = None

    def __enter__(self):
        self._process = subprocess.Popen(self._boot, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                         start_new_session=True)
        threading.Thread(target=self._read, daemon=True).start()
        self._await(LISTENS, BOOT_S)
        return self

    def __exit__(self, *_):
        self.cut_power()

    def cut_power(self):
        """What the guest had not yet given to its disk is lost."""
        if self._process.poll() is None:
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def _read(self):
        for line in self._process.stdout:
            self._lines.put(line.decode(errors="replace").rstrip("\r\n"))
        self._lines.put(None)

    def _await(self, start, longest_s):
        """Lines up to the first that begins with `start`, and that line."""
        before, deadline_s = [], time.monotonic() + longest_s
        while True:
            try:
                line = self._lines.get(timeout=max(0.01, deadline_s - time.monotonic()))
            except queue.Empty:
                raise MachineError(f"nothing said '{start}' in {longest_s} s") from None
            if line is None:
                raise MachineError(f"the machine ended before it said '{start}'")
            if line.startswith(start):
                return before, line
            before.append(line)

    def do(self, command, longest_s=COMMAND_S):
        """Runs a line of shell in the guest; returns (exit status, lines that it wrote)."""
        self._process.stdin.write(f"{command}\n".encode())
        self._process.stdin.flush()
        lines, status = self._await(STATUS, longest_s)
        return int(status[len(STATUS):]), lines

    def must(self, command, longest_s=COMMAND_S):
        """The same, where failure ends the run."""
        status, lines = self.do(command, longest_s)
        if status != 0:
            raise MachineError(f"exit {status} of: {command}: {' '.join(lines)}")
        return lines

    def start(self, *arguments):
        """A daemon in the guest; returns its process number there. Its log is /tmp/NAME.log."""
        name = arguments[0]
        return int(self.must(f"{shlex.join(arguments)} >/tmp/{name}.log 2>&1 & echo $!")[-1])
