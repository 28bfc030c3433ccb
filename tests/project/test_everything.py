"""The one command that runs all checks: nothing after a failing part is hidden, and every skip is counted."""

import os
import subprocess
import sys
from pathlib import Path

import everything
import pytest
from everything import PARTS, judged, read_report

REPORT = """<testsuites><testsuite>
<testcase name="a"/>
<testcase name="b"><failure message="no">assert 0</failure></testcase>
<testcase name="c"><error message="no">set-up</error></testcase>
<testcase name="d"><skipped type="pytest.skip" message="There is&#10;no ccx."/></testcase>
<testcase name="e"><skipped type="pytest.skip" message="There is no ccx."/></testcase>
<testcase name="f"><skipped type="pytest.xfail" message="known"/></testcase>
</testsuite></testsuites>"""


def test_a_report_of_pytest_is_counted_with_the_reasons_of_its_skips() -> None:
    counts, skips = read_report(REPORT)
    assert counts == {"passed": 2, "failed": 2, "skipped": 2}
    assert skips == {"There is no ccx.": 2}


@pytest.mark.parametrize(
    ("code", "report", "failed", "counts"),
    [
        (0, None, False, {"passed": 1}),
        (2, None, True, {"failed": 1}),
        (0, REPORT, True, {"passed": 2, "failed": 2, "skipped": 2}),
        # all tests passed, and something else went wrong: a warning as an error at the end, a second command
        (1, "<testsuite><testcase/></testsuite>", True, {"passed": 1, "failed": 1}),
    ],
)
def test_a_part_fails_by_its_exit_code_or_by_a_test(code, report, failed, counts) -> None:
    result = judged("unit", code, 1.0, report)
    assert result.failed is failed
    assert +result.counts == counts


# Stands for make: its last argument is the part. pytest's own tests are real.
MAKE = """import os, subprocess, sys
part = sys.argv[-1]
print("in", part, flush=True)
if part == "unit":
    test = ["-c", os.devnull, "-p", "no:cacheprovider", "-q", os.environ["FAKE_TEST"]]
    sys.exit(subprocess.run([sys.executable, "-m", "pytest", *test]).returncode)
sys.exit(part == os.environ["FAKE_FAILS"])
"""
TEST = """import pytest
def test_one(): pass
@pytest.mark.parametrize("k", range(2))
def test_two(k): pytest.skip("There is no Chromium.")
"""


@pytest.mark.parametrize("fails", ["lint", "html", "none"])
def test_what_comes_after_a_failing_part_is_run_and_the_end_says_what_failed(fails: str, tmp_path: Path) -> None:
    folder = tmp_path / "a path with blanks"
    (folder / "tools").mkdir(parents=True)
    (folder / "tools" / "everything.py").write_text(Path(everything.__file__).read_text(encoding="utf-8"))
    (folder / "make.py").write_text(MAKE)
    (folder / "test_small.py").write_text(TEST)
    environment = {
        **{name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "COV"))},
        "MAKE": f"'{sys.executable}' make.py",
        "FAKE_TEST": "test_small.py",
        "FAKE_FAILS": fails,
    }
    command = [sys.executable, folder / "tools" / "everything.py", "--slow"]
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    ran = [line.removeprefix("in ") for line in lines if line.startswith("in ")]
    told = {line.split()[0]: " ".join(line.split()[1:]) for line in lines[lines.index("Parts:") + 1 :][: len(PARTS)]}
    assert done.returncode == int(fails != "none"), done.stdout + done.stderr
    assert ran == [part for part in PARTS if fails not in PARTS[part]]
    assert [part for part, said in told.items() if said.startswith("FAILED")] == [fails] * (fails != "none")
    assert [part for part, said in told.items() if said.startswith("not run")] == ["pages"] * (fails == "html")
    assert (fails == "html") == (told["pages"] == "not run: html failed")
    assert told["unit"].endswith("(2 skipped)")
    assert "     2  There is no Chromium." in lines
    # one test of pytest, and each part without tests as one check
    failed = {"none": 0, "lint": 1, "html": 2}[fails]
    assert lines[-1] == f"{len(PARTS) - failed} passed, {failed} failed, 2 skipped"


def test_a_part_that_is_not_there_is_refused() -> None:
    command = [sys.executable, everything.__file__, "units"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "no part is called 'units'" in done.stderr


def test_each_part_is_a_target_of_the_makefile() -> None:
    makefile = (Path(everything.__file__).parent.parent / "Makefile").read_text(encoding="utf-8")
    assert all(f"\n{part}:" in makefile for part in PARTS)
