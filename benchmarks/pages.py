"""How soon the live page answers in headless Chromium: seconds to start, milliseconds from pointer to curves.

    make latency

Promised on an idle machine of two cores: ready in 12 s, a line with the next frame of 16 ms, curves within 100 ms.
The tests count what is drawn; only this measures time, and nothing fails by it.
"""

import os
import sys
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tools")]

from browser import served  # noqa: E402
from browsing import launched, pyodide_folder  # noqa: E402
from test_live_page import HTML, Stage, dragged  # noqa: E402

ROUNDS, STEPS = 3, 40


def main() -> None:
    """Print one line for each live thing."""
    with launched("The measurements") as browser, served(HTML.parent) as url:
        stage = Stage(browser, f"{url}/{HTML.name}/book/live.html", pyodide_folder())
        for name in ("oscillator", "campbell", "unbalance", "peak_picker"):
            stage.run(name)
            place = stage.thing(name)
            if name == "peak_picker":
                place, part = place.locator(".rbp-handle").nth(1), 0.5
            else:
                place, part = place.locator("input[type=range]").first, 0.4
            whole, line = [], []
            for _ in range(ROUNDS):
                dragged(stage, place, part, STEPS, 40.0)
                stage.settle(name)
                whole.append(median(stage.page.evaluate("window.latencies")))
                line += stage.page.evaluate("window.moved")
            ready = float(stage.thing(name).get_attribute("data-ready"))
            moved = f", line {median(line):.1f} ms" if line else ""
            medians = ", ".join(f"{time:.1f}" for time in sorted(whole))
            print(f"{name:12} ready after {ready:.1f} s; medians of {ROUNDS} rounds {medians} ms{moved}", flush=True)
        stage.context.close()
    print(f"{os.getloadavg()[0] / (os.cpu_count() or 1):.1f} processes a core")


if __name__ == "__main__":
    main()
