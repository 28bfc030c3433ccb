"""Fetch what the book otherwise takes from CDNs, so that `make book OFFLINE=1` needs no network when it is read.

    python tools/offline.py FOLDER [--pyodide FOLDER] [--packages FOLDER]
    python tools/offline.py --only-pyodide FOLDER

FOLDER/static then holds MathJax, require.js and the manager of widgets, FOLDER/pyodide Python for the live pages. `npm`
fetches the packages, unless --packages names a folder that holds them as npm unpacks them; Pyodide's own CDN serves
what npm has not, unless --pyodide names a folder with the files of its version. The second form fetches Pyodide alone,
into FOLDER itself, where the tests in a browser look for it (`make pyodide`).
"""

import argparse
import hashlib
import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
import urllib.request
from pathlib import Path

PYODIDE = "0.27.7"
CDN = f"https://cdn.jsdelivr.net/pyodide/v{PYODIDE}/full/"
CORE = ("pyodide.js", "pyodide.asm.js", "pyodide.asm.wasm", "python_stdlib.zip")
LIST = "pyodide-lock.json"
WHEELS = ("numpy", "scipy", "openblas")
# npm's name and version, what is taken of it, and where that goes.
PACKAGES = {
    "mathjax@3.2.2": {
        "es5/tex-mml-chtml.js": "mathjax/tex-mml-chtml.js",
        "es5/output/chtml/fonts/woff-v2": "mathjax/output/chtml/fonts/woff-v2",
        "es5/a11y": "mathjax/a11y",
        "es5/sre": "mathjax/sre",
        "es5/ui": "mathjax/ui",
        "es5/input/tex/extensions": "mathjax/input/tex/extensions",
    },
    "requirejs@2.3.7": {"require.js": "require.js"},
    "@jupyter-widgets/html-manager@1.0.14": {"dist": "html-manager"},
}


def unpacked(package: str, own: Path | None, aside: Path) -> Path:
    """The folder of an npm package: from `own` where it has it, else fetched."""
    name = package.rpartition("@")[0]
    if own and (own / name).is_dir():
        return own / name
    if shutil.which("npm") is None:
        raise SystemExit(f"{package} is fetched with npm, which is not here: install it (Debian: apt-get install npm).")
    folder = aside / name.replace("/", "-")
    folder.mkdir(parents=True)
    subprocess.run(["npm", "pack", "--silent", package], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    (archive,) = folder.glob("*.tgz")
    with tarfile.open(archive) as tar:
        tar.extractall(folder, filter="data")
    return folder / "package"


def copied(source: Path, target: Path) -> None:
    """A file or a folder into its place."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if source.is_dir():
        shutil.copytree(
            source, target, dirs_exist_ok=True, ignore=shutil.ignore_patterns("*.map", "embed.js*", "*.eot")
        )
    else:
        shutil.copyfile(source, target)


def fetched(name: str) -> bytes:
    """A file of Pyodide's CDN."""
    try:
        with urllib.request.urlopen(CDN + name, timeout=120) as answer:
            return bytes(answer.read())
    except OSError as error:
        raise SystemExit(
            f"{CDN}{name} cannot be fetched ({error}): name a folder that has Pyodide {PYODIDE}'s files."
        ) from error


def python_for_pages(folder: Path, own: Path | None, aside: Path) -> None:
    """Pyodide's core, numpy and scipy, checked against Pyodide's list; the list comes last, once all is there."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / LIST).unlink(missing_ok=True)
    core = own or unpacked(f"pyodide@{PYODIDE}", None, aside)
    for name in CORE:
        copied(core / name, folder / name)
    known = json.loads((core / LIST).read_text(encoding="utf-8"))["packages"]
    for package in WHEELS:
        name, wanted = known[package]["file_name"], known[package]["sha256"]
        data = (own / name).read_bytes() if own else fetched(name)
        if hashlib.sha256(data).hexdigest() != wanted:
            raise SystemExit(f"{name} is not the file that Pyodide {PYODIDE} lists: its sha256 differs.")
        (folder / name).write_bytes(data)
    copied(core / LIST, folder / LIST)


def main() -> None:
    """Fill the folder."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only-pyodide", action="store_true")
    parser.add_argument("--pyodide", type=Path)
    parser.add_argument("--packages", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        if args.only_pyodide:
            python_for_pages(args.folder, args.pyodide, Path(name))
            return
        for package, parts in PACKAGES.items():
            source = unpacked(package, args.packages, Path(name))
            for part, place in parts.items():
                copied(source / part, args.folder / "static" / "offline" / place)
        python_for_pages(args.folder / "pyodide", args.pyodide, Path(name))
    size = sum(path.stat().st_size for path in args.folder.rglob("*") if path.is_file()) / 1e6
    print(f"{args.folder}: {size:.0f} MB for a book without network", file=sys.stderr)


if __name__ == "__main__":
    main()
