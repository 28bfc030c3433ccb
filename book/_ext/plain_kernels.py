"""Kernels that run notebooks alike wherever the book is built, with `make book` or with `jupyter-book build .` alone.

One thread, so that results are the same to the last printed digit; nothing from the reader's home folder; and no line
on stderr, which would be an error in a cell: a kernel says at each start that it talks without encryption, and
matplotlib that it builds its list of fonts.
"""

import os
from pathlib import Path
from typing import Any

import matplotlib.font_manager  # noqa: F401, builds the list of fonts once, here
from sphinx.application import Sphinx


def settle(app: Sphinx, config: Any) -> None:
    """Sphinx's hook once the configuration is read: the environment that kernels inherit."""
    for library in ("OPENBLAS", "OMP", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    os.environ.setdefault("JUPYTER_PREFER_ENV_PATH", "1")
    os.environ.pop("MPLBACKEND", None)
    home = Path(app.outdir).parent / ".ipython"
    settings = home / "profile_default" / "ipython_kernel_config.py"
    settings.parent.mkdir(parents=True, exist_ok=True)
    settings.write_text('get_config().IPKernelApp.log_level = "ERROR"\n', encoding="utf-8")
    os.environ["IPYTHONDIR"] = str(home)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the hook; before kept_runs, which reads the number of threads."""
    app.connect("config-inited", settle, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
