"""What `import rbfound` costs beside `import numpy, scipy.linalg`, and how large the wheel is: writes startup.md.

`make bench` runs it with the others. CPU time of whole interpreters, each measured many times, by turns.
"""

import os
import platform
import subprocess
import sys
import tempfile
import zipfile
from importlib.metadata import version
from pathlib import Path
from statistics import median

REPEATS = 15
NOTHING, FLOOR = "pass", "import numpy, scipy.linalg"
# by what a program does with rbfound
CODES = {
    "Python alone": NOTHING,
    "`import numpy, scipy.linalg`": FLOOR,
    "`import rbfound`": "import rbfound",
    "the same, and the names of a machine": "from rbfound import Bearing, Disk, Rotor, Shaft, campbell, mount",
    "the same, and the names of an identification": "from rbfound import identify, load_frf",
    "`from rbfound import *`": "from rbfound import *",
}


def cpu(code: str) -> float:
    """CPU time of an interpreter that does this [s]."""
    before = os.times()
    subprocess.run([sys.executable, "-c", code], check=True)
    after = os.times()
    return sum(after[2:4]) - sum(before[2:4])


def wheel_size() -> int:
    """Bytes of the wheel that this folder makes, without the scripts and styles of the widgets."""
    root = Path(__file__).parents[1]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, str(root)]
        subprocess.run(command, check=True)
        (wheel,) = Path(folder).glob("*.whl")
        with zipfile.ZipFile(wheel) as archive:
            return wheel.stat().st_size - sum(
                entry.compress_size for entry in archive.infolist() if entry.filename.endswith((".js", ".css"))
            )


def main() -> None:
    spent: dict[str, list[float]] = {name: [] for name in CODES}
    for _ in range(REPEATS + 1):
        for name, code in CODES.items():
            spent[name].append(cpu(code))
    # the first round warms the disk's cache
    seconds = {name: median(times[1:]) for name, times in spent.items()}
    floor = seconds["`import numpy, scipy.linalg`"]
    rows = "\n".join(f"| {name} | {value:.3f} | {value / floor:.2f} |" for name, value in seconds.items())
    text = f"""# Start-up

Written by `make bench` (`benchmarks/startup.py`): do not edit by hand.

Python {platform.python_version()}, numpy {version("numpy")}, scipy {version("scipy")}, {platform.system()}.
CPU time of a whole interpreter, the median of {REPEATS}, by turns. A name's module is loaded when the name is first
used, so what a program pays depends on what it uses.

| what | CPU [s] | ratio |
| --- | ---: | ---: |
{rows}

The package that the live pages load, a wheel without scripts and styles: {wheel_size() / 1e3:.0f} kB.
"""
    (Path(__file__).parent / "startup.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
