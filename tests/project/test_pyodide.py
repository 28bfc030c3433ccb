"""Python for the pages: what is fetched is what Pyodide's list says, and a folder without the list is not complete."""

import hashlib
import json
from pathlib import Path

import offline
import pytest


@pytest.fixture
def given(tmp_path: Path) -> Path:
    """A folder with small files in the place of Pyodide's."""
    folder = tmp_path / "given"
    folder.mkdir()
    for name in (*offline.CORE, *(f"{wheel}.whl" for wheel in offline.WHEELS)):
        (folder / name).write_bytes(name.encode())
    listed = {
        wheel: {"file_name": f"{wheel}.whl", "sha256": hashlib.sha256(f"{wheel}.whl".encode()).hexdigest()}
        for wheel in offline.WHEELS
    }
    (folder / offline.LIST).write_text(json.dumps({"packages": listed}))
    return folder


def test_all_files_of_the_list_are_brought(given: Path, tmp_path: Path) -> None:
    offline.python_for_pages(tmp_path / "here", given, tmp_path)
    assert {path.name: path.read_bytes() for path in (tmp_path / "here").iterdir()} == {
        path.name: path.read_bytes() for path in given.iterdir()
    }


def test_a_file_that_is_not_the_listed_one_is_refused_and_the_folder_stays_incomplete(
    given: Path, tmp_path: Path
) -> None:
    offline.python_for_pages(tmp_path / "here", given, tmp_path)
    (given / "scipy.whl").write_bytes(b"another")
    with pytest.raises(SystemExit, match=r"scipy\.whl is not the file that Pyodide .* lists"):
        offline.python_for_pages(tmp_path / "here", given, tmp_path)
    # the tests in a browser take the list for a sign that all is there
    assert not (tmp_path / "here" / offline.LIST).exists()


def test_a_cdn_that_cannot_be_had_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(offline, "CDN", "http://127.0.0.1:1/")
    with pytest.raises(SystemExit, match=r"numpy\.whl cannot be fetched"):
        offline.fetched("numpy.whl")
