"""Build the wheel, install it into an empty environment, and use it there.

What works in the work tree may still be missing from the package: a module, `py.typed`, a dependency.
"""

import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

USE = """
import sys
import rbfound
optional = {"matplotlib", "skfem", "ipywidgets", "anywidget"} & set(sys.modules)
assert not optional, f"import rbfound loads {optional}"
print("rbfound", rbfound.__version__, "imports from", rbfound.__file__)
"""


def build_wheel(folder: Path) -> Path:
    """The wheel of this work tree, in `folder`."""
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--outdir", folder, ROOT], check=True, stdout=subprocess.DEVNULL
    )
    (wheel,) = folder.glob("*.whl")
    return wheel


def check_contents(wheel: Path) -> None:
    """The package, the whole package and nothing but the package."""
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    files = [path for path in (ROOT / "rbfound").rglob("*") if path.suffix in {".py", ".pyi", ".typed", ".js", ".css"}]
    wanted = {path.relative_to(ROOT).as_posix() for path in files}
    if names != wanted:
        raise SystemExit(f"the wheel lacks {sorted(wanted - names)} and should not have {sorted(names - wanted)}")


def main() -> None:
    """Build, look inside, install, import."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        wheel = build_wheel(folder)
        check_contents(wheel)
        venv.create(folder / "empty", with_pip=True)
        python = folder / "empty" / "bin" / "python"
        subprocess.run([python, "-m", "pip", "install", "--quiet", wheel], check=True)
        subprocess.run([python, "-c", USE], check=True, cwd=folder)


if __name__ == "__main__":
    main()
