"""The program `manylight` as a child process: used by same_bits.py and cost.py."""

import json
import os
import shlex
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

#: A scene of the project: diffuse and glossy surfaces, textures.
SCENE = Path(__file__).resolve().parents[3] / "scenes" / "glossy-room" / "scene.xml"


@dataclass
class Ended:
    """What a process took."""

    #: From start to end, in s.
    seconds: float
    #: Time of all its threads on processors, in s. Other programs that run beside it hardly change it.
    cpu_seconds: float
    #: Largest resident memory, in bytes.
    peak_bytes: int
    #: The object of `--json`, or None.
    report: dict | None


class Program:
    """Starts `manylight` in a folder for its files."""

    def __init__(self, binary, folder):
        self.binary, self.folder = str(Path(binary).resolve()), Path(folder)

    def start(self, arguments):
        """A running process. `arguments` are words as in a shell."""
        return subprocess.Popen([self.binary, *shlex.split(arguments)], cwd=self.folder, stdout=subprocess.PIPE)

    def run(self, arguments):
        """Waits for the end of a process. Ends this one with its code if it fails."""
        start = time.perf_counter()
        process = self.start(arguments)
        output = process.stdout.read()
        process.stdout.close()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.check(process, arguments)
        # Linux counts in KiB, macOS in bytes.
        unit = 1 if sys.platform == "darwin" else 1024
        report = json.loads(output) if output.strip() else None
        seconds = time.perf_counter() - start
        return Ended(seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * unit, report)

    @staticmethod
    def check(process, arguments):
        """Ends this program if `process` has failed."""
        if process.returncode != 0:
            sys.exit(f"error: manylight {arguments} ended with {process.returncode}")


class Table:
    """A Markdown table that is printed row by row."""

    def __init__(self, *names):
        self.lines = []
        self.row(*names)
        self.row(*("---" for _ in names))

    def row(self, *cells):
        """Prints a row."""
        self.lines.append(f"| {' | '.join(str(cell) for cell in cells)} |")
        print(self.lines[-1], flush=True)
