#!/usr/bin/env python3
"""Where the time of a command goes: percent of samples by part of the program.

    python docs/measurements/performance/shares.py MANYLIGHT render SCENE -m path --passes 64 --size 256x256 -t 1 -o x.exr

A sample of `perf record` counts for the innermost function of the core outside of lanes, also if it was inlined. Needs Linux with
perf, readelf and addr2line, and a program built with `CARGO_PROFILE_RELEASE_DEBUG=1`.
"""

import argparse
import collections
import os
import re
import subprocess
import tempfile

CORE = "crates/manylight/src/"
# The first part whose pattern is found in the path of a file.
PARTS = [
    ("rays", r"geometry/bvh|geometry/surface_set|stream/arrivals"),
    ("emitters", r"emitters/"),
    ("film", r"film/"),
    ("connections of paths", r"integrators/connections|transport/direct"),
    ("camera rays", r"sensors/|camera_starts"),
    ("scattering", r"bsdf/"),
    ("points, textures", r"texture/|geometry/|image"),
    ("lights and their sum", r"gather/|virtual_lights/|light_tree/"),
    ("kd-trees, densities", r"maps/"),
    ("stages of many lights", r"many_light|photon_map|particles/"),
    ("vertices", r"transport/|integrators/|sampling/"),
]
INNERMOST = re.compile(r"lanes|simd|math|color")


def output(*command: str, text: str | None = None) -> str:
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def samples(data: str, program: str) -> tuple[collections.Counter[int], int]:
    """Samples by address in the file of the program, and the number of others."""
    events = output("perf", "script", "-i", data, "-F", "ip,dso", "--show-mmap-events")
    name = re.escape(os.path.basename(program))
    mapping = re.search(rf"\[0x([0-9a-f]+)\(0x[0-9a-f]+\) @ (?:0x)?([0-9a-f]+) .*r-xp.*/{name}$", events, re.M)
    if mapping is None:
        raise SystemExit(f"error: perf has no samples of {program}")
    base = int(mapping[1], 16) - int(mapping[2], 16)
    headers = re.findall(r"LOAD\s+(0x\w+) (0x\w+) 0x\w+ (0x\w+)", output("readelf", "-lW", program))
    segments = [tuple(int(number, 16) for number in header) for header in headers]
    own, others = collections.Counter(), 0
    for ip, file in re.findall(r"^\s*([0-9a-f]+) \((.*)\)$", events, re.M):
        at = int(ip, 16) - base
        inside = [at - start + address for start, address, size in segments if start <= at < start + size]
        if file.endswith(f"/{os.path.basename(program)}") and inside:
            own[inside[0]] += 1
        else:
            others += 1
    return own, others


def part(frames: list[tuple[str, str]]) -> tuple[str, str]:
    """The part of the program of a sample, and its function: `frames` are functions and files, the innermost first."""
    for function, file in frames:
        path = file.partition(CORE)[2]
        if path and not INNERMOST.match(path):
            part = next((name for name, pattern in PARTS if re.search(pattern, path)), "other")
            return part, f"{short(function)} ({path.split(':')[0]})"
    return "other", short(frames[0][0])


def short(function: str) -> str:
    """The last two names of a path, without type parameters."""
    while (stripped := re.sub(r"<[^<>]*>", "", function)) != function:
        function = stripped
    names = [name for name in function.split("::") if name not in ("", "{{closure}}")]
    return "::".join(names[-2:])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("words", nargs=argparse.REMAINDER, help="words of its command line")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        data = f"{folder}/perf.data"
        output("perf", "record", "-q", "-F", "499", "-o", data, args.program, *args.words)
        own, others = samples(data, args.program)
    addresses = "\n".join(map(hex, own))
    lines = output("addr2line", "-C", "-f", "-i", "-a", "-e", args.program, text=addresses)
    frames = re.split(r"^0x[0-9a-f]+$", lines, flags=re.M)[1:]
    parts, functions = collections.Counter({"kernel, libc": others}), collections.Counter()
    for count, of_sample in zip(own.values(), frames, strict=True):
        at = of_sample.strip().splitlines()
        name, function = part(list(zip(at[::2], at[1::2], strict=True)))
        parts[name] += count
        functions[function] += count
    total = sum(parts.values())
    for title, counts in (("part", parts), ("function", functions)):
        print(f"\n| {title} | % |\n|---|---|")
        for name, count in counts.most_common(20):
            print(f"| {name} | {100 * count / total:.1f} |")


if __name__ == "__main__":
    main()
