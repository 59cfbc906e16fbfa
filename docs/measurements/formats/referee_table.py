"""What the comparisons with other renderers share: the outcome of a case, and the table of all cases."""

import argparse
import fnmatch
import sys
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

#: Differences of means below this fraction are none, and neither are those below so many standard errors.
TOLERANCE, MAX_Z = 0.01, 3.5
#: Parts of the picture that are darker than this fraction of its mean are compared relative to that.
DARK = 0.1
#: A difference is rendered again with so many times the samples.
MORE = 4

#: Patterns of case names, the kind of the cause of their differences, and the cause.
Known = list[tuple[tuple[str, ...], str, str]]


@dataclass
class Picture:
    """Means over the picture and over parts of it, by channel, and their variances."""

    means: np.ndarray
    variances: np.ndarray


@dataclass
class Outcome:
    """What the two programs make of a case."""

    case: str
    #: `agrees`, `differs`, `warns`, or which of them refuses it.
    verdict: str
    #: Where they differ most, or a message.
    detail: str = ""
    ours: float = float("nan")
    theirs: float = float("nan")
    z: float = float("nan")
    warnings: int = 0

    @property
    def agrees(self) -> bool:
        return self.verdict in ("agrees", "both refuse")

    def row(self, cause: str) -> str:
        ratio = self.ours / self.theirs if self.theirs else float("nan")
        cells = [
            "" if np.isnan(x) else form.format(x)
            for form, x in (("{:.4g}", self.ours), ("{:.4g}", self.theirs), ("{:.3f}", ratio), ("{:+.1f}", self.z))
        ]
        return f"| {self.case} | {self.verdict} | {self.detail} | {' | '.join(cells)} | {cause} |"


def arguments(description: str | None, example: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("manylight", help="the program, as `cargo build --release` makes it")
    parser.add_argument("--only", default="*", metavar="PATTERN", help=f"cases whose names match, such as `{example}`")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="leaves files and pictures there")
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time")
    parser.add_argument("--all", action="store_true", help="prints the cases that agree, too")
    return parser.parse_args()


def cause_of(outcome: Outcome, known: Known) -> tuple[str, str]:
    """Kind and cause of the difference; empty if it has none."""
    for patterns, kind, cause in known:
        if any(fnmatch.fnmatchcase(outcome.case, pattern) for pattern in patterns):
            silent = kind == "unsupported" and outcome.verdict == "differs" and outcome.warnings != 1
            return ("", "not supported, but without one warning") if silent else (kind, cause)
    return "", ""


def report(outcomes: Iterable[Outcome], known: Known, agreeing: bool) -> None:
    """Prints the differences, or all cases if `agreeing`, and ends with status 1 if one has no named cause."""
    counts: Counter[str] = Counter()
    print("| case | verdict | where | ours | theirs | ratio | z | cause |\n|---|---|---|---|---|---|---|---|")
    for outcome in outcomes:
        kind, cause = cause_of(outcome, known)
        counts["cases"] += 1
        counts["agree" if outcome.agrees else kind or "unnamed"] += 1
        counts["named, but agree"] += outcome.agrees and bool(kind)
        if not outcome.agrees or kind or agreeing:
            unnamed = "" if outcome.agrees else "UNNAMED"
            print(outcome.row(f"{kind}: {cause}" if kind else cause or unnamed), flush=True)
    print(f"\n{counts.pop('cases')} cases: " + ", ".join(f"{count} {kind}" for kind, count in counts.most_common() if count))
    sys.exit(1 if counts["unnamed"] else 0)
