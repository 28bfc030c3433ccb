"""Which file holds which FRF: by the names in a folder, by an index, or by the heading of one table."""

import re
from pathlib import Path

from rbfound.gathering import Pair
from rbfound.rows import decoded, listed
from rbfound.textfiles import Curve, curves_of

NAME = re.compile(r"(?P<response>[xy]\d+)_from_(?P<force>[xy]\d+)\.(?:txt|csv|dat)$", re.IGNORECASE)
# Sixty-four bearings would have four times as many.
MOST_FILES = 4096
# Stands in a folder while `rbfound.files.save_frf` puts the files of a new set in the place of an old one.
MIXED = "half-written"


def curves_of_folder(folder: Path, columns: str | None, pattern: str | None) -> tuple[dict[Pair, Curve], str]:
    """The FRF of each text file of a folder, and a hint at files whose names say no seats."""
    if (folder / MIXED).exists():
        raise ValueError(
            f"{folder} was being written when that was interrupted, and may hold files of two sets: save it again. "
            f"(If you know that its files belong together, remove the file {MIXED}.)"
        )
    name = NAME if pattern is None else _pattern(pattern)
    numbered = "number" in name.groupindex
    matches = [
        (path, match) for path in sorted(folder.iterdir()) if path.is_file() and (match := name.search(path.name))
    ]
    if not matches:
        raise ValueError(
            f"{folder} holds no FRFs: expected text files with names like {pattern or 'frf01_x1_from_y1.txt'}."
        )
    if len(matches) > MOST_FILES:
        raise ValueError(f"{folder} holds {len(matches)} files: at most {MOST_FILES} are read.")
    order = _table_2(folder, len(matches)) if numbered else []
    paths: dict[Pair, Path] = {}
    for path, match in matches:
        if numbered:
            if not 1 <= int(match["number"]) <= len(order):
                raise ValueError(f"{path}: the numbers of {len(order)} FRFs go from 1 to {len(order)}.")
            pair = order[int(match["number"]) - 1]
        else:
            pair = match["response"].lower(), match["force"].lower()
        if pair in paths:
            raise ValueError(f"{paths[pair].name} and {path.name} in {folder} both hold {pair[0]} from {pair[1]}.")
        paths[pair] = path
    texts = [p.name for p in sorted(folder.iterdir()) if p.suffix.lower() == ".txt" and not name.search(p.name)]
    hint = f" Files whose names say no pair of seats: {listed(texts)}." if texts else ""
    return {pair: _single(path, columns) for pair, path in paths.items()}, hint


def _pattern(pattern: str) -> re.Pattern[str]:
    """A regular expression for names such as "H_{response}_{force}.csv"."""
    parts = re.split(r"(\{\w*\})", pattern)
    fields = [part for part in parts if part.startswith("{")]
    if sorted(fields) not in (["{force}", "{response}"], ["{number}"]):
        raise ValueError(f"pattern is {pattern!r}: it must hold {{response}} and {{force}}, or {{number}}.")
    groups = {
        "{response}": r"(?P<response>[xy]\d{1,3})",
        "{force}": r"(?P<force>[xy]\d{1,3})",
        "{number}": r"(?P<number>\d{1,4})",
    }
    return re.compile("^" + "".join(groups.get(part, re.escape(part)) for part in parts) + "$", re.IGNORECASE)


def _table_2(folder: Path, count: int) -> list[Pair]:
    """The pairs in the order of table 2: forces y1, x1, y2, x2, responses x1, y1, x2, y2."""
    bearings = round(count**0.5 / 2)
    if 4 * bearings**2 != count:
        raise ValueError(f"{folder} holds {count} numbered files: it must be 4, 16, 36, ..., all pairs of seats.")
    labels = [f"{axis}{k + 1}" for k in range(bearings) for axis in "xy"]
    forces = [f"{axis}{k + 1}" for k in range(bearings) for axis in "yx"]
    return [(response, driven) for driven in forces for response in labels]


def _single(path: Path, columns: str | None) -> Curve:
    """The one FRF of a file, whatever its heading says of seats: its name says them."""
    curves = curves_of(path, columns)
    if len(curves) > 1:
        raise ValueError(f"{path} holds {len(curves)} FRFs where its name says one.")
    return next(iter(curves.values()))


def curves_of_file(path: Path, columns: str | None) -> dict[Pair, Curve]:
    """The FRFs of a table whose heading names the seats, or of the files that an index names."""
    text = decoded(path)
    heading = re.split(r"\s*[;,\t]\s*", text.lstrip()[:1000].split("\n")[0].strip().lower())
    if {"file", "response", "force"} <= set(heading):
        lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
        return _indexed(path, heading, lines[1:], columns)
    curves = curves_of(path, columns)
    if None in curves:
        raise ValueError(
            f"{path}: its heading does not say of which seats its columns are: name them 'x1 from y1 real [m/N]' and "
            "so on, or give the folder of all files, or an index with the heading 'file, response, force'."
        )
    return {pair: curve for pair, curve in curves.items() if pair is not None}


def _indexed(path: Path, heading: list[str], lines: list[tuple[int, str]], columns: str | None) -> dict[Pair, Curve]:
    """The FRFs of the files that an index names, relative to its own folder."""
    if len(lines) > MOST_FILES:
        raise ValueError(f"{path} names {len(lines)} files: at most {MOST_FILES} are read.")
    out: dict[Pair, Curve] = {}
    for number, line in lines:
        cells = re.split(r"\s*[;,\t]\s*", line.strip())
        if len(cells) != len(heading):
            raise ValueError(f"{path}, line {number}: {len(cells)} cells where there should be {len(heading)}.")
        row = dict(zip(heading, cells, strict=True))
        pair = row["response"].lower(), row["force"].lower()
        if not all(re.fullmatch(r"[xy]\d{1,3}", seat) for seat in pair):
            raise ValueError(f"{path}, line {number}: {pair[0]!r} from {pair[1]!r}: seats are x1, y1, x2, y2, ...")
        if pair in out:
            raise ValueError(f"{path}, line {number}: {pair[0]} from {pair[1]} was named before.")
        if not row["file"] or "\0" in row["file"]:
            raise ValueError(f"{path}, line {number}: no file is named.")
        out[pair] = _single(path.parent / row["file"], columns)
    if not out:
        raise ValueError(f"{path} is an index without files.")
    return out
