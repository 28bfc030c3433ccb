"""One machine plays several kinds of processors: which it can play, and that it plays the one that it was asked for."""

import platform
import re
import subprocess
import sys
from pathlib import Path

import kernels
import pytest
from kernels import Kind, disagreement, environment, kinds, table

OLD = ["SSE", "SSE2", "SSE3", "SSSE3", "SSE41", "SSE42"]
WIDE = [*OLD, "AVX", "AVX2", "FMA3"]


@pytest.mark.parametrize(
    ("features", "expected"),
    [
        (OLD[:3], ["Prescott"]),
        (OLD, ["Prescott", "Nehalem"]),
        ([*OLD, "AVX"], ["Prescott", "Nehalem", "Sandybridge"]),
        (WIDE, ["Prescott", "Nehalem", "Sandybridge", "Haswell"]),
        # the first processors with 512 bits had not all of it
        ([*WIDE, "AVX512F"], ["Prescott", "Nehalem", "Sandybridge", "Haswell"]),
        ([*WIDE, *kernels.CORES["SkylakeX"]], list(kernels.CORES)),
        (["NEON", "ASIMD"], ["own"]),
    ],
)
def test_a_processor_plays_what_it_has_the_instructions_for(features: list[str], expected: list[str]) -> None:
    assert [kind.name for kind in kinds(features, [])] == expected


def test_numpy_without_wide_registers_is_a_kind_of_its_own() -> None:
    *_, narrow = kinds(WIDE, ["AVX2", "FMA3"])
    assert narrow == Kind("numpy-narrow", {"OPENBLAS_CORETYPE": "Nehalem", "NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3"})
    assert {kind.name for kind in kinds(WIDE, ["AVX2"])} < set(kernels.KINDS)


def test_nothing_around_a_command_chooses_another_kind() -> None:
    around = {"PATH": "/bin", "OPENBLAS_L2_SIZE": "1", "NPY_DISABLE_CPU_FEATURES": "AVX2", "OPENBLAS_NUM_THREADS": "8"}
    haswell = {"PATH": "/bin", **kernels.ONE_THREAD, "OPENBLAS_CORETYPE": "Haswell"}
    assert environment(Kind("Haswell", {"OPENBLAS_CORETYPE": "Haswell"}), around) == haswell
    assert environment(Kind("own", {}), {"OPENBLAS_CORETYPE": "Haswell"}) == kernels.ONE_THREAD


def test_a_library_that_plays_another_kind_is_named() -> None:
    skylake, prescott = (Kind(name, {"OPENBLAS_CORETYPE": name}) for name in ("SkylakeX", "Prescott"))
    told = "asked for SkylakeX, and scipy plays Haswell"
    assert disagreement(skylake, {"numpy": "skylakex", "scipy": "Haswell"}) == told
    assert disagreement(skylake, {"numpy": "SkylakeX", "scipy": "SkylakeX"}) == ""
    assert disagreement(prescott, {"numpy": "Katmai", "scipy": "Prescott"}) == ""
    assert disagreement(Kind("own", {}), {"numpy": "neoversen1"}) == ""


def test_the_table_has_kinds_down_and_parts_across() -> None:
    told = table({"Prescott": {"unit": "passed", "nbval": "FAILED"}, "Haswell": {"unit": "passed", "nbval": "passed"}})
    assert told.splitlines() == ["          unit    nbval", "Prescott  passed  FAILED", "Haswell   passed  passed"]


def test_the_workflow_has_a_job_for_each_kind() -> None:
    workflow = (Path(kernels.__file__).parent.parent / ".github" / "workflows" / "book.yml").read_text(encoding="utf-8")
    (jobs,) = re.findall(r"kernel: \[(.+)\]", workflow)
    assert {*jobs.split(", "), kernels.OWN} == set(kernels.KINDS)


@pytest.mark.skipif(
    platform.machine().lower() not in ("x86_64", "amd64"), reason="only x86-64 plays several processors"
)
def test_a_command_runs_as_the_kind_that_was_asked_for_and_its_failure_is_told() -> None:
    def run(code: str) -> "subprocess.CompletedProcess[str]":
        command = [sys.executable, kernels.__file__, "--only", "Prescott", "--", sys.executable, "-c", code]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    # an exit code of 0 says that the environment was there
    done = run("import os, sys; sys.exit(os.environ['OPENBLAS_CORETYPE'] != 'Prescott')")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.splitlines()[-1] == "Prescott  passed"
    done = run("import sys; print('why it failed'); sys.exit(3)")
    assert done.returncode == 1
    assert "    why it failed" in done.stdout.splitlines()
    assert done.stdout.splitlines()[-1] == "Prescott  FAILED"
