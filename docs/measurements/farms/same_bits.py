"""Shows by hashes that shares, killed and resumed renders, and other numbers of threads give the bits of one run.

Usage: python same_bits.py MANYLIGHT [--method NAME]... [--scene FILE] [--seed N] [--out FILE.md]

A render has 64 passes in 8 blocks, with all layers. The SHA-256 is that of the values of all channels of the EXR file, by
name: layers, variances, mattes. The order of merged shares and the times of kills, after the first
checkpoint of each process, are random, by `--seed`. Another seed of the
render must give other bits. Ends with 1 if a row is wrong.

Needs the Python package OpenEXR.
"""

import argparse
import hashlib
import json
import random
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from program import SCENE, Program, Table

try:
    import OpenEXR
except ImportError:
    sys.exit("error: cannot read EXR files: the Python package OpenEXR is missing (pip install OpenEXR)")

METHODS = {
    "rich-vpl": "-m rich-vpl -n 64 --photons 4096",
    "path": "-m path",
    "photon-map": "-m photon-map --photons 4096",
    "rich-lightcuts": "-m rich-lightcuts -n 64 --photons 4096",
}
PASSES = "--size 64x36 --passes 64 --block 8 --aov all -q"
SHARES = (1, 2, 3, 8)
THREADS = (1, 2, 5)
KILLS = 10
#: Longest life of a killed process after its first checkpoint, as a part of the time of one run.
LONGEST_LIFE = 0.08


def pixel_digest(path):
    """SHA-256 of names, types and values of all channels of an EXR file."""
    digest = hashlib.sha256()
    for part in OpenEXR.File(str(path), separate_channels=True).parts:
        for name, channel in sorted(part.channels.items()):
            digest.update(f"{name} {channel.pixels.dtype} {channel.pixels.shape}\n".encode())
            digest.update(channel.pixels.tobytes())
    return digest.hexdigest()


def checkpoint_passes(path):
    """Number of passes in a checkpoint; 0 if there is none."""
    if not path.exists():
        return 0
    with open(path, "rb") as file:
        header = json.loads(file.read(int.from_bytes(file.read(8), "little")))
        start, end = header["current.passes"]["data_offsets"]
        file.seek(start, 1)
        return int.from_bytes(file.read(end - start)[4:], "little")


class Method:
    """Renders of one method, in a folder."""

    def __init__(self, program, scene, options, chance):
        self.program, self.chance = program, chance
        self.render = f"render {shlex.quote(str(scene))} {options} {PASSES}"

    def image(self, options=""):
        """The digest of an image of one run."""
        self.program.run(f"{self.render} {options} -o image.exr")
        return pixel_digest(self.program.folder / "image.exr")

    def merged(self, count):
        """The digest of merged shares, and their order."""
        for share in range(1, count + 1):
            self.program.run(f"{self.render} --shard {share}/{count} -t {share % 3 + 1} -o {share}.part")
        order = list(range(1, count + 1))
        self.chance.shuffle(order)
        parts = " ".join(f"{share}.part" for share in order)
        self.program.run(f"merge {parts} -o merged.exr -q")
        return pixel_digest(self.program.folder / "merged.exr"), order

    def killed(self, seconds):
        """The digest of a render that is killed and resumed; the numbers of kills, of kills while a checkpoint was written, and
        of passes before the last run. `seconds` is the time of one run."""
        command = f"{self.render} --checkpoint state.part --checkpoint-every 1ms --resume state.part -o killed.exr"
        kills = unfinished = 0
        checkpoint = self.program.folder / "state.part"
        while kills < KILLS:
            before = checkpoint_passes(checkpoint)
            process = self.program.start(command)
            while process.poll() is None and checkpoint_passes(checkpoint) == before:
                time.sleep(0.001)
            try:
                process.wait(self.chance.uniform(0, LONGEST_LIFE * seconds))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                kills += 1
                unfinished += self.remove_unfinished()
            else:
                self.program.check(process, command)
                break
            finally:
                process.stdout.close()
        passes = checkpoint_passes(checkpoint)
        self.program.run(command)
        return pixel_digest(self.program.folder / "killed.exr"), kills, unfinished, passes

    def remove_unfinished(self):
        """Removes what a killed process has left of a file. True if there was one."""
        files = list(self.program.folder.glob(".manylight-*"))
        for file in files:
            file.unlink()
        return bool(files)


def rows(method):
    """Cases with their digests, and whether a digest should be that of the first case."""
    start = time.perf_counter()
    yield "one run", method.image(), True
    seconds = time.perf_counter() - start
    for count in SHARES:
        digest, order = method.merged(count)
        yield f"{count} shares, merged as {' '.join(map(str, order))}", digest, True
    digest, kills, unfinished, passes = method.killed(seconds)
    yield f"killed {kills} times ({unfinished} in a checkpoint), last resumed with {passes} passes", digest, True
    for threads in THREADS:
        yield f"{threads} threads", method.image(f"-t {threads}"), True
    yield "another seed", method.image("--seed 1"), False


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("manylight", help="the program")
    parser.add_argument("--method", choices=METHODS, action="append", help="default: all")
    parser.add_argument("--scene", type=Path, default=SCENE)
    parser.add_argument("--seed", type=int, default=0, help="of the order of shares and the times of kills")
    parser.add_argument("--out", type=Path, help="file for the table, as Markdown")
    arguments = parser.parse_args()
    table = Table("method", "case", "SHA-256", "equal")
    wrong = 0
    for name in arguments.method or METHODS:
        with tempfile.TemporaryDirectory() as folder:
            chance = random.Random(f"{arguments.seed} {name}")
            method = Method(Program(arguments.manylight, folder), arguments.scene.resolve(), METHODS[name], chance)
            expected = None
            for case, digest, should_equal in rows(method):
                expected = expected or digest
                is_right = (digest == expected) == should_equal
                wrong += not is_right
                table.row(name, case, digest[:12], ("yes" if digest == expected else "no") + ("" if is_right else ": wrong"))
    if arguments.out:
        arguments.out.write_text("\n".join(table.lines) + "\n")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
