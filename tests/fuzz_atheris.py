"""Coverage-guided fuzzing of every reader, with atheris: `make fuzz` runs it after tests/files/test_fuzz.py.

    python tests/fuzz_atheris.py [runs] [name ...]

Each name of `fuzzing.NAMES` gets a process of its own, which mutates good files towards code that no case has reached.
Any exception but a ValueError ends it, as does a case that takes more than a second or more than a gigabyte.
"""

import re
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

ONE = "--one"
if sys.argv[1:2] == [ONE]:
    import atheris

    with atheris.instrument_imports(include=["rbfound", "pyuff", "tomllib", "zipfile"]):
        import fuzzing

        import rbfound.files.uff  # noqa: F401  the loader imports it only when it meets such a file
else:
    import fuzzing

RUNS = 10_000
# Seconds of CPU for one case of at most this many bytes; it takes some hundredths, as counting what was reached slows
# Python down several times.
SLOW, LONGEST = 1.0, 20_000
LIMITS = ["-rss_limit_mb=1000", "-timeout=20", f"-max_len={LONGEST}", "-print_final_stats=1", "-seed=1"]


def fuzz(name: str, runs: int) -> None:
    """Fuzz the reader of one name; ends the process. No warning may escape a reader."""
    warnings.simplefilter("error")
    with tempfile.TemporaryDirectory() as kept:
        good, corpus = Path(kept) / "good", Path(kept) / "corpus"
        good.mkdir()
        corpus.mkdir()
        for k, content in enumerate(fuzzing.good_files(good)[name]):
            fuzzing.outcome(good, name, content)
            (corpus / f"{k}").write_bytes(content)
        with fuzzing.beside(good) as folder:

            def case(content: bytes) -> None:
                start = time.process_time()
                try:
                    fuzzing.outcome(folder, name, content)
                except Exception as error:
                    raise RuntimeError(f"{name}: {content!r}") from error
                seconds = time.process_time() - start
                if seconds > SLOW:
                    raise RuntimeError(f"{name} of {len(content)} bytes took {seconds:.2f} s: {content!r}")

            atheris.Setup([sys.argv[0], *LIMITS, f"-artifact_prefix={kept}/", f"-runs={runs}", str(corpus)], case)
            atheris.Fuzz()


def main(runs: int, names: list[str]) -> int:
    """Fuzz each name in a process of its own and print what was reached; the number of names that failed."""
    failed, total = 0, 0
    for name in names or fuzzing.NAMES:
        done = subprocess.run([sys.executable, __file__, ONE, name, str(runs)], capture_output=True, text=True)
        count = re.search(r"number_of_executed_units: (\d+)", done.stderr)
        reached = re.findall(r"cov: (\d+)", done.stderr)
        memory = re.search(r"peak_rss_mb: +(\d+)", done.stderr)
        total += int(count[1]) if count else 0
        if done.returncode or not count or not memory:
            failed += 1
            print(f"{name}: FAILED\n{done.stdout}{done.stderr[-6000:]}", flush=True)
        else:
            reach = f"{reached[0]} to {reached[-1]} places in the code reached"
            print(f"{name:>12}: {count[1]} cases, {reach}, {memory[1]} MB at most", flush=True)
    print(f"{total} cases; {failed} of the readers failed.")
    return failed


if __name__ == "__main__":
    if sys.argv[1:2] == [ONE]:
        fuzz(sys.argv[2], int(sys.argv[3]))
    else:
        sys.exit(min(main(int(sys.argv[1]) if sys.argv[1:] else RUNS, sys.argv[2:]), 1))
