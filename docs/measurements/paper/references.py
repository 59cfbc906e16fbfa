#!/usr/bin/env python3
"""References of docs/measurements/paper/plan.json, accumulated over independent seeds. Each call continues from the stored state.

    python3 references.py --time 60m [--scale quick] [--only NAME...] [--sources SOURCE...] [--manylight BINARY]
    python3 references.py --report
    python3 references.py --check [--only NAME...]

A source is the path tracer of Mitsuba, a method of manylight, or another renderer whose models differ: its file is a
reference for that renderer alone. The file references/SCALE/sources/NAME.SOURCE.exr is its
state: R, G, B (mean over batches), variance.R, .G, .B (of this mean, between batches), block.variance.* (of means of
8x8 pixels) and the number of batches, seeds and seconds in its header. references/SCALE/NAME.exr is the mean of the
sources that are combined, weighted by the inverse of their overall variance; sources of a single batch each, whose variance is
unknown, count equally. It replaces a noisier file only.
NAME.json describes it.

The time is spent on scenes in proportion to the noise of their references over its aim. Files are replaced every few
minutes: what a killed process loses is what it did since. Needs `pip install mitsuba numpy OpenEXR`.
"""
import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from accumulated import Accumulated, Moments, copy_file, read_exr, relative_noise, shortened, write_exr

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER / "rivals"))
#: Seconds of batches between two files of a source.
SLICE = 240.0
#: First seed of a source: apart from those of images that are compared with the references.
FIRST_SEED = 1 << 20
#: Where the noise of a reference is this many times its aim or more, it is treated as this.
MOST_URGENT = 8.0

#: Smallest relMSE that a method reaches in 30 s at `quick`. A third of its root is the aim for the noise of a reference.
BEST_RELMSE = {"cbox": 2.1e-4, "kitchen": 5.2e-3, "garage": 1.28e-2, "u-shape": 5.4e-3, "disco": 3.5e-2}


class Source(NamedTuple):
    """What is to be rendered of a source. A batch of a progressive method is one run, whose bias falls with its length."""

    #: Samples per pixel of a batch.
    samples: int
    #: Share of the scene's time; with 0 it is rendered only where --sources names it.
    share: float
    #: Whether the reference contains it.
    is_combined: bool


#: Other renderers with materials of their own: references for them alone.
RIVALS = {"cycles-path": Source(128, 0.0, False), "luxcore-bidir": Source(32, 0.0, False)}
SOURCES = {
    "cbox": {"mitsuba-path": Source(256, 0.2, True), "rich-vpl": Source(64, 0.8, True), **RIVALS},
    "kitchen": {"mitsuba-path": Source(128, 0.2, True), "rich-vpl": Source(64, 0.8, True), **RIVALS},
    "garage": {"mitsuba-path": Source(128, 0.2, True), "rich-vpl": Source(64, 0.8, True), **RIVALS},
    "u-shape": {
        "mitsuba-path": Source(128, 0.2, False),
        "rich-vpl": Source(96, 0.65, True),
        "photon-map": Source(192, 0.15, True),
        **RIVALS,
    },
    "disco": {
        "mitsuba-path": Source(128, 0.2, False),
        "rich-vpl": Source(64, 0.4, True),
        "photon-map": Source(160, 0.4, True),
        **RIVALS,
    },
}


def main():
    words = arguments()
    scenes = scenes_of_plan(words.scale, words.only)
    if words.report:
        report(scenes)
    elif words.check:
        for scene in scenes:
            check(scene)
    else:
        accumulate(scenes, words)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scale", default="quick")
    parser.add_argument("--only", nargs="+", metavar="NAME", help="names of scenes")
    parser.add_argument("--sources", nargs="+", metavar="SOURCE", help="only these sources")
    parser.add_argument("--time", default="60m", help="such as 90s or 2h")
    parser.add_argument("--manylight", metavar="BINARY", help="without it, only Mitsuba renders")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--report", action="store_true", help="print the noise of each reference, and its aim")
    parser.add_argument("--check", action="store_true", help="compare the sources of each scene")
    return parser.parse_args()


class Scene:
    """A scene of the plan at one scale, with the states of its sources."""

    def __init__(self, entry, values, folder):
        fill = lambda text: text.format(**values)
        self.name = entry["name"]
        self.file = (FOLDER / entry["file"]).resolve()
        self.size = tuple(int(n) for n in fill(entry["size"]).split("x"))
        self.max_depth = entry["max_depth"]
        self.folder = folder
        self.sources = SOURCES[self.name]
        self.spent = 0.0

    def reference_path(self):
        return self.folder / f"{self.name}.exr"

    def state_path(self, source):
        return self.folder / "sources" / f"{self.name}.{source}.exr"

    def states(self):
        """The sources that have a state."""
        paths = {source: self.state_path(source) for source in self.sources}
        return {source: Accumulated.load(path) for source, path in paths.items() if path.exists()}

    def aim(self):
        return np.sqrt(BEST_RELMSE[self.name]) / 3

    def combined(self):
        return combine({s: state for s, state in self.states().items() if self.sources[s].is_combined})

    def urgency(self):
        """Noise of the reference over its aim."""
        mean, variance, _ = self.combined()
        if mean is None:
            return MOST_URGENT
        return min(relative_noise(mean, variance) / self.aim(), MOST_URGENT)


def scenes_of_plan(scale, only):
    plan = json.loads((FOLDER / "plan.json").read_text())
    values = next((s["values"] for s in plan["scales"] if s["name"] == scale), None)
    if values is None:
        sys.exit(f"plan.json has no scale {scale}")
    scenes = [Scene(entry, values, FOLDER / "references" / scale) for entry in plan["scenes"]]
    unknown = set(only or []) - {scene.name for scene in scenes}
    if unknown:
        sys.exit(f"plan.json has no scene {', '.join(sorted(unknown))}")
    return [scene for scene in scenes if not only or scene.name in only]


def combine(states):
    """Mean and variance of the sources' weighted mean, and the weights: the inverse of the overall relative variance."""
    usable = {source: state for source, state in states.items() if state.pixels.count >= 2}
    if not usable:
        return combine_batches(states)
    inverse = {s: relative_noise(state.pixels.mean, state.pixels.variance()) ** -2 for s, state in usable.items()}
    weights = {source: value / sum(inverse.values()) for source, value in inverse.items()}
    mean = sum(w * usable[s].pixels.mean for s, w in weights.items())
    variance = sum(w**2 * usable[s].pixels.variance() for s, w in weights.items())
    return mean, variance, weights


def combine_batches(states):
    """The same where each source has one batch: the batches count equally, and their spread gives the variance."""
    batches = {source: state for source, state in states.items() if state.pixels.count == 1}
    if len(batches) < 2:
        return None, None, {}
    moments = Moments()
    for state in batches.values():
        moments.add(state.pixels.mean)
    return moments.mean, moments.variance(), {source: 1 / len(batches) for source in batches}


# Accumulating


def accumulate(scenes, words):
    """Renders batches until the time is over."""
    seconds = seconds_of(words.time)
    start = time.monotonic()
    while (left := seconds - (time.monotonic() - start)) > 0:
        choices = [scene for scene in scenes if available_sources(scene, words)]
        if not choices:
            sys.exit("no source can render: pass --manylight BINARY or install mitsuba")
        scene = max(choices, key=lambda scene: scene.urgency() / (scene.spent + SLICE))
        source = next_source(scene, available_sources(scene, words))
        begun = time.monotonic()
        add_slice(scene, source, words, min(SLICE, left))
        scene.spent += time.monotonic() - begun
        describe(scene)
        print(f"{time.strftime('%H:%M:%S')} {scene.name} {source}: noise {scene.urgency():.2f} of the aim", flush=True)


def seconds_of(text):
    return float(text[:-1]) * {"s": 1, "m": 60, "h": 3600}[text[-1]]


def available_sources(scene, words):
    """The sources of a scene that the command line asks for and can render."""
    if words.sources:
        chosen = [s for s in scene.sources if s in words.sources]
    else:
        chosen = [s for s, entry in scene.sources.items() if entry.share > 0]
    return [s for s in chosen if words.manylight or s == "mitsuba-path" or s in RIVALS]


def next_source(scene, names):
    """The source farthest behind its share of the scene's time."""
    states = scene.states()
    spent = {s: states[s].facts["seconds"] if s in states else 0.0 for s in names}
    return min(names, key=lambda s: (spent[s] + 1) / max(scene.sources[s].share, 1e-3))


def add_slice(scene, source, words, seconds):
    """Adds batches to a source for this time, at least one, and saves its state."""
    path = scene.state_path(source)
    state = Accumulated.load(path)
    samples = scene.sources[source].samples
    facts = state.facts or first_facts(samples)
    if facts["samples_per_batch"] != samples:
        sys.exit(f"{path}: batches of {facts['samples_per_batch']} samples, expected {samples}")
    render, facts["version"] = renderer(scene, source, words)
    start = time.monotonic()
    while time.monotonic() - start < seconds:
        image = render(samples, facts["seeds"][1])
        finite = np.isfinite(image)
        facts["zeroed"] += int(np.count_nonzero(~finite))
        state.add(np.where(finite, image, 0.0))
        facts["seeds"][1] += 1
    facts["seconds"] += time.monotonic() - start
    state.facts = facts
    state.save(path)


def first_facts(samples):
    """`seeds` is a half-open range; `zeroed` counts values that were not finite."""
    return {"samples_per_batch": samples, "seeds": [FIRST_SEED, FIRST_SEED], "seconds": 0.0, "zeroed": 0}


def renderer(scene, source, words):
    """A function from samples per pixel and seed to an image, and the version of the program."""
    if source == "mitsuba-path":
        return mitsuba_renderer(scene, words.threads)
    options = f"--filter box --size {scene.size[0]}x{scene.size[1]} --max-depth {scene.max_depth} --quiet --progress none"
    if source in RIVALS:
        script = FOLDER / "rivals" / f"{source.replace('-', '_')}.py"
        return child_renderer([sys.executable, str(script), str(scene.file), *options.split()]), source
    version = subprocess.run([words.manylight, "--version"], capture_output=True, text=True, check=True).stdout.strip()
    options += f" -m {source} --threads {words.threads}"
    return child_renderer([words.manylight, "render", str(scene.file), *options.split()]), version


def mitsuba_renderer(scene, threads):
    import mitsuba_path as mitsuba

    mitsuba.choose_variant()
    import drjit

    drjit.set_thread_count(threads)
    loaded = mitsuba.load(scene.file, scene.size)
    integrator = mitsuba.mi.load_dict({"type": "path", "max_depth": scene.max_depth})
    render = lambda samples, seed: mitsuba.render(loaded, integrator, samples, seed)
    return render, f"Mitsuba {mitsuba.mi.__version__}"


def child_renderer(command):
    """One child process per image. Its output's folder names it in the list of processes beside the parent."""

    def render(samples, seed):
        with tempfile.TemporaryDirectory(prefix="references.py-") as folder:
            output = Path(folder) / "image.exr"
            budget = ["--spp", str(samples), "--seed", str(seed), "--output", str(output)]
            subprocess.run([*command, *budget], check=True)
            return read_exr(output)[0][""]

    return render


def describe(scene):
    """Writes NAME.json, and NAME.exr if it is better than the one there."""
    mean, variance, weights = scene.combined()
    states = scene.states()
    sources = {source: facts_of(state, weights.get(source, 0.0)) for source, state in states.items()}
    facts = {"size": scene.size, "max_depth": scene.max_depth, "filter": "box", "aim": round(float(scene.aim()), 6)}
    if mean is not None:
        facts["noise"] = relative_noise(mean, variance)
        replace_reference(scene, mean, variance, weights)
    facts["sources"] = sources
    text = json.dumps(facts, indent=2) + "\n"
    (scene.folder / f"{scene.name}.json").write_text(text)


def replace_reference(scene, mean, variance, weights):
    """Writes NAME.exr, unless the file that is there is less noisy. That of a single source is a copy of its state."""
    path = scene.reference_path()
    if path.exists():
        layers, _ = read_exr(path)
        if relative_noise(layers[""], layers["variance."]) <= relative_noise(mean, variance):
            return
    if len(weights) == 1:
        copy_file(scene.state_path(*weights), path)
    else:
        write_exr(path, {"": mean, "variance.": shortened(variance)})


def facts_of(state, weight):
    """What NAME.json says of a source."""
    noise = relative_noise(state.pixels.mean, state.pixels.variance())
    return {
        **state.facts,
        "batches": state.pixels.count,
        "noise": noise if np.isfinite(noise) else None,
        "weight": weight,
        "mean": [float(x) for x in state.total.mean],
    }


# Report and check


def report(scenes):
    """Prints the noise of each reference and of its sources, their samples, and the aim."""
    print(f"{'reference':24} {'noise':>8} {'aim':>8} {'noise/aim':>10} {'samples':>9} {'hours':>6}")
    for scene in scenes:
        mean, variance, weights = scene.combined()
        noise = np.inf if mean is None else relative_noise(mean, variance)
        print(f"{scene.name:24} {noise:8.2%} {scene.aim():8.2%} {noise / scene.aim():10.2f}")
        for source, state in scene.states().items():
            noise = relative_noise(state.pixels.mean, state.pixels.variance())
            samples = state.pixels.count * state.facts["samples_per_batch"]
            hours = state.facts["seconds"] / 3600
            used = f"weight {weights[source]:.2f}" if source in weights else "not combined"
            print(f"  {source:22} {noise:8.2%} {'':19} {samples:9} {hours:6.2f}  {used}")


def check(scene):
    """Prints ratios and z-scores between each two sources of a scene."""
    states = [(source, state) for source, state in scene.states().items() if state.pixels.count >= 2]
    for index, (first, a) in enumerate(states):
        for second, b in states[index + 1 :]:
            print(f"{scene.name}: {first} over {second}")
            check_pair(a, b)


def check_pair(a, b):
    """Whole image: ratio of means per channel with its standard error. Blocks: distribution of ratios and z-scores."""
    ratio = a.total.mean / b.total.mean
    error = ratio * np.sqrt(a.total.variance() / a.total.mean**2 + b.total.variance() / b.total.mean**2)
    print("  image: " + ", ".join(f"{r:.4f} ± {e:.4f}" for r, e in zip(ratio, error)))
    deviation = np.sqrt(a.blocks.variance() + b.blocks.variance())
    z = (a.blocks.mean - b.blocks.mean) / np.maximum(deviation, 1e-30)
    ratios = (a.blocks.mean / np.maximum(b.blocks.mean, 1e-30)).ravel()
    low, median, high = np.quantile(ratios, [0.05, 0.5, 0.95])
    outside = np.mean(np.abs(z) > 3)
    # Student's distribution has heavy tails for few batches: the quartiles tell more than the extremes.
    middle = np.quantile(np.abs(z), 0.5)
    print(f"  blocks: ratio {median:.4f} (5 % to 95 %: {low:.3f} to {high:.3f}); median |z| {middle:.2f} (0.67 for noise), beyond 3: {outside:.1%}")


if __name__ == "__main__":
    main()
