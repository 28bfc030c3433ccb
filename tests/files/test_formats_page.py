"""The page of formats names tests that there are, and all tests that read a format of another program."""

import re
from pathlib import Path

TESTS = Path(__file__).parents[1]
FILES = {path.name: path for path in TESTS.rglob("*.py")}
PAGE = (TESTS.parent / "book" / "formats.md").read_text(encoding="utf-8")


def named_in(*names):
    return {test for name in names for test in re.findall(r"^def (test_\w+)", FILES[name].read_text(), re.MULTILINE)}


def test_every_test_that_the_page_names_is_there():
    named = set(re.findall(r"`(test_\w+)`", PAGE))
    files = set(re.findall(r"`((?:test|fuzz)_\w+\.py)`", PAGE))
    assert len(named) > 25
    assert named <= named_in(*(name for name in FILES if name.startswith("test_")))
    assert files <= set(FILES)


def test_the_page_lists_what_other_programs_wrote():
    for path in (TESTS / "files" / "octave").glob("*.mat"):
        assert f'"{path.name}"' in path.with_name("octave.m").read_text()
    octave = {test for test in named_in("test_formats.py") if "octave" in test or "universal_file" in test}
    assert octave <= set(re.findall(r"`(test_\w+)`", PAGE))
