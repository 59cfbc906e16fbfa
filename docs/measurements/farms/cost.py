"""Measures what checkpoints, merging and sharing cost.

Usage: python cost.py MANYLIGHT checkpoint|merge|scaling|all [--scene FILE] [--folder DIR] [--out FILE.md]

checkpoint: seconds to write one at 640x360 with all layers, and their share of a minute.
merge: seconds and memory for parts of 1920x1080. Four are rendered, and read from the disk. 64 are made up: their sums are
    zeros, stored as holes, so that 45 GB need no disk; their reading rate is that of memory. Needs 3 GB of disk.
scaling: seconds for 64 passes by threads and by processes.

Files are in a temporary folder in DIR. Measure on a machine that does nothing else.
"""

import argparse
import hashlib
import json
import os
import shlex
import statistics
import sys
import tempfile
import time
from pathlib import Path

from program import SCENE, Program, Table

REPEATS = 3
#: Blocks that are as short as possible: one per part.
BLOCK = 8
REAL_PARTS = 4
MADE_UP_PARTS = 64
DIGEST_DIGITS = 64
MB = 1e6


def measure_checkpoint(program, scene):
    """A run that ends in the first block of 8 passes writes one set of sums, a longer one two. Both write once, at the end."""
    table = Table("checkpoint at 640x360, path, all layers", "MB", "s", "share of a minute")
    for block, passes in (("in the first block", 3), ("later", 9)):
        seconds = []
        for _ in range(REPEATS):
            ended = program.run(
                f"render {scene} --size 640x360 -m path --aov all --passes {passes} --block {BLOCK}"
                " --checkpoint state.part --checkpoint-every 1h -o image.exr --json -q"
            )
            seconds.append(ended.report["stages"]["checkpoint"])
        size = (program.folder / "state.part").stat().st_size
        median = statistics.median(seconds)
        table.row(block, f"{size / MB:.0f}", f"{median:.2f}", f"{median / 60:.2%}")
    return table


def measure_merge(program, scene):
    """Merges of real and of made up parts."""
    table = Table("merge of parts of 1920x1080", "GB", "s", "CPU s", "GB/s", "peak memory in GB")
    for k in range(1, REAL_PARTS + 1):
        program.run(
            f"render {scene} --size 1920x1080 -m direct --passes {REAL_PARTS * BLOCK} --block {BLOCK}"
            f" --shard {k}/{REAL_PARTS} -o {k}.part -q"
        )
    real = [program.folder / f"{k}.part" for k in range(1, REAL_PARTS + 1)]
    for name, is_cached in (("from the disk", False), ("from memory", True)):
        if not is_cached:
            for part in real:
                forget(part)
        merge_row(program, table, f"{len(real)} rendered, {name}", real)
    source = program.folder / "source.part"
    real[0].rename(source)
    for part in real[1:]:
        part.unlink()
    made_up = [program.folder / f"made-up-{k}.part" for k in range(MADE_UP_PARTS)]
    for k, part in enumerate(made_up):
        make_up(source, part, k, MADE_UP_PARTS * BLOCK)
    merge_row(program, table, f"{len(made_up)} made up", made_up)
    return table


def merge_row(program, table, name, parts):
    """Merges `parts`, and adds a row."""
    size = sum(part.stat().st_size for part in parts) / 1e9
    ended = program.run(f"merge {shlex.join(part.name for part in parts)} -o merged.exr -q")
    rate = size / ended.seconds
    table.row(
        name, f"{size:.1f}", f"{ended.seconds:.1f}", f"{ended.cpu_seconds:.1f}", f"{rate:.2f}", f"{ended.peak_bytes / 1e9:.2f}"
    )


def forget(path):
    """Takes a file out of the memory of the operating system."""
    with open(path, "rb") as file:
        os.fsync(file.fileno())
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)


def make_up(source, path, block, passes):
    """A part with block 0 of `source` as another block of a render with `passes` passes. Sums of pixels are zeros."""
    with open(source, "rb") as file:
        header = json.loads(file.read(int.from_bytes(file.read(8), "little")))
        data = file.tell()
        entries = header.pop("__metadata__")
        part = json.loads(entries["manylight.part"])
        part["render"]["passes"] = passes
        entries = {"manylight.part": json.dumps(part), "manylight.sha256": "0" * DIGEST_DIGITS}
        arrays, small, end = {"__metadata__": entries}, {}, 0
        for name, info in header.items():
            start, stop = info["data_offsets"]
            end = max(end, stop)
            if name == "block.0.batches":
                file.seek(data + start)
                small[start] = file.read(stop - start)
            if name == "block.0.passes":
                small[start] = (block * BLOCK).to_bytes(4, "little") + ((block + 1) * BLOCK).to_bytes(4, "little")
            arrays[name.replace("block.0.", f"block.{block}.")] = info
    head = json.dumps(arrays, separators=(",", ":")).encode()
    head += b" " * (-len(head) % 8)
    head = bytearray(len(head).to_bytes(8, "little") + head)
    with open(path, "wb+") as file:
        file.write(head)
        for start, values in small.items():
            file.seek(len(head) + start)
            file.write(values)
        file.truncate(len(head) + end)
        file.seek(0)
        digest = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(head.index(b'"manylight.sha256":"') + len('"manylight.sha256":"'))
        file.write(digest.encode())


def measure_scaling(program, scene):
    """The same passes by threads and by processes, in turns."""
    table = Table("64 passes", "1 process, 1 thread: s", "1 process, 2 threads: s", "2 processes and merge: s")
    methods = (
        ("path, 320x180", "-m path --size 320x180"),
        ("rich-vpl, 96x54", "-m rich-vpl -n 64 --photons 4096 --size 96x54"),
    )
    for name, options in methods:
        render = f"render {scene} {options} --passes 64 --block 16 -q"
        cases = [
            lambda: program.run(f"{render} -t 1 -o image.exr"),
            lambda: program.run(f"{render} -t 2 -o image.exr"),
            lambda: shares_and_merge(program, render),
        ]
        seconds = [[] for _ in cases]
        for _ in range(REPEATS):
            for case, times in zip(cases, seconds):
                start = time.perf_counter()
                case()
                times.append(time.perf_counter() - start)
        table.row(name, *(f"{statistics.median(times):.2f}" for times in seconds))
    return table


def shares_and_merge(program, render):
    """Two processes at a time, each with a share and a thread."""
    shares = [program.start(f"{render} -t 1 --shard {k}/2 -o {k}.part") for k in (1, 2)]
    for process in shares:
        process.communicate()
        program.check(process, render)
    program.run("merge 1.part 2.part -o merged.exr -q")


MEASURES = {"checkpoint": measure_checkpoint, "merge": measure_merge, "scaling": measure_scaling}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("manylight", help="the program")
    parser.add_argument("measure", choices=[*MEASURES, "all"])
    parser.add_argument("--scene", type=Path, default=SCENE)
    parser.add_argument("--folder", type=Path, help="for files")
    parser.add_argument("--out", type=Path, help="file for the tables, as Markdown")
    arguments = parser.parse_args()
    names = MEASURES if arguments.measure == "all" else [arguments.measure]
    tables = []
    for name in names:
        with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
            program = Program(arguments.manylight, folder)
            tables.append(MEASURES[name](program, shlex.quote(str(arguments.scene.resolve()))))
        print()
    if arguments.out:
        arguments.out.write_text("\n\n".join("\n".join(table.lines) for table in tables) + "\n")


if __name__ == "__main__":
    sys.exit(main())
