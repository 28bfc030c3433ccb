"""Run every check there is, one part after the other, and say at the end which of them failed.

    python tools/everything.py [--slow] [PART ...]

Each part is a target of the Makefile. A part that fails does not hide the ones after it, unless it makes what they
open. pytest writes what its tests came to into _build/reports; the counts and the reasons of skipped tests at the end
are from there. A part without tests counts as one check. Exit code 1 if anything failed.
"""

import argparse
import os
import shlex
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
REPORTS = Path("_build") / "reports"
# Each part, and the parts that make what it opens.
PARTS: dict[str, tuple[str, ...]] = {
    "lint": (),
    "unit": (),
    "slow": (),
    "wheel": (),
    "html": (),
    "nbval": (),
    "pages": ("html",),
}


@dataclass
class Result:
    """What came of one part: its time [s], how many checks passed and failed, and why tests were skipped."""

    name: str
    failed: bool = False
    seconds: float = 0.0
    counts: Counter[str] = field(default_factory=Counter)
    skips: Counter[str] = field(default_factory=Counter)
    without: str = ""  # the part it needs, where that failed


def read_report(text: str) -> tuple[Counter[str], Counter[str]]:
    """Of a report in JUnit's XML: how many tests passed, failed and were skipped, and how often each reason was given.

    An error while a test is set up or ends is a failure; a failure that the test expects is none.
    """
    counts: Counter[str] = Counter()
    skips: Counter[str] = Counter()
    for case in ET.fromstring(text).iter("testcase"):
        skipped = case.find("skipped")
        if case.find("failure") is not None or case.find("error") is not None:
            counts["failed"] += 1
        elif skipped is not None and skipped.get("type") != "pytest.xfail":
            counts["skipped"] += 1
            skips[" ".join(skipped.get("message", "no reason given").split())] += 1
        else:
            counts["passed"] += 1
    return counts, skips


def judged(name: str, code: int, seconds: float, report: str | None) -> Result:
    """The result of a part that ended with an exit code, and wrote a report or none."""
    counts, skips = read_report(report) if report else (Counter[str](), Counter[str]())
    failed = code != 0 or counts["failed"] > 0
    if failed and not counts["failed"]:
        counts["failed"] += 1
    elif not counts:
        counts["passed"] += 1
    return Result(name, failed, seconds, counts, skips)


def run(name: str, make: list[str]) -> Result:
    """Run one part; what it prints goes to the terminal as it comes."""
    report = ROOT / REPORTS / f"{name}.xml"
    report.unlink(missing_ok=True)
    # the path is relative, as pytest would split one with blanks; make runs in the root
    options = f"{os.environ.get('PYTEST_ADDOPTS', '')} --junitxml={(REPORTS / report.name).as_posix()}".strip()
    start = time.monotonic()
    # make hands its jobs' pipe down to a make below it
    done = subprocess.run(
        [*make, name], cwd=ROOT, env={**os.environ, "PYTEST_ADDOPTS": options}, check=False, close_fds=False
    )
    seconds = time.monotonic() - start
    return judged(name, done.returncode, seconds, report.read_text(encoding="utf-8") if report.exists() else None)


def summary(results: list[Result]) -> str:
    """One line for each part, why tests were skipped, and the counts of all."""
    wide = max((len(result.name) for result in results), default=0)
    lines = ["", "Parts:"]
    for result in results:
        verdict = "FAILED" if result.failed else "passed"
        told = f"{verdict}  {result.seconds:6.1f} s" if not result.without else f"not run: {result.without} failed"
        if result.skips:
            told += f"  ({sum(result.skips.values())} skipped)"
        lines.append(f"  {result.name:{wide}}  {told}")
    skips = sum((result.skips for result in results), Counter[str]())
    if skips:
        lines += ["", "Skipped, and why:", *(f"  {number:4d}  {reason}" for reason, number in skips.most_common())]
    counts = sum((result.counts for result in results), Counter[str]())
    total = f"{counts['passed']} passed, {counts['failed']} failed"
    if counts["skipped"]:
        total += f", {counts['skipped']} skipped"
    return "\n".join([*lines, "", total])


def main() -> int:
    """Run the parts in turn."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", nargs="*", help=f"of {', '.join(PARTS)}; without one, all but slow")
    parser.add_argument("--slow", action="store_true", help="the long tests, too")
    args = parser.parse_args()
    names = args.part or [name for name in PARTS if args.slow or name != "slow"]
    if unknown := sorted(set(names) - set(PARTS)):
        parser.error(f"no part is called {unknown[0]!r}: there are {', '.join(PARTS)}")
    make = [*shlex.split(os.environ.get("MAKE", "make")), "--no-print-directory"]
    results: list[Result] = []
    try:
        for name in names:
            print(f"\n=== {name}", flush=True)
            missing = [result.name for result in results if result.failed and result.name in PARTS[name]]
            if missing:
                results.append(Result(name, failed=True, counts=Counter(failed=1), without=missing[0]))
            else:
                results.append(run(name, make))
    except KeyboardInterrupt:
        print(summary(results), "interrupted", sep="\n")
        return 130
    print(summary(results))
    return int(any(result.failed for result in results))


if __name__ == "__main__":
    sys.exit(main())
