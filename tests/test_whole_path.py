"""From files to critical speeds and on to other programs, for machines of one bearing to eight."""

import numpy as np
import pytest

import rbfound as rb
from rbfound.command import main
from rbfound.exports import dmig, matrix27
from rbfound.machinefile import load_machine

F = np.arange(10.0, 180.0, 2.0)


def foundation(bearings):
    """Three modes at 45, 80 and 130 Hz with smooth shapes along the bearings, X and Y each with its own mix."""
    z = np.linspace(0, 1, 2 * bearings + 1)[1::2]
    shapes = np.array([np.ones(bearings), z - 0.4, np.cos(3 * z)])
    Phi = 0.1 * np.stack([shapes, shapes[[1, 2, 0]]], axis=2).transpose(1, 2, 0).reshape(2 * bearings, 3)
    labels = tuple(f"{axis}{k + 1}" for k in range(bearings) for axis in "xy")
    return rb.modal_foundation(Phi, rb.radians(np.array([45.0, 80.0, 130.0])), [0.02, 0.025, 0.02], labels)


def machine(places):
    shaft = "speeds = [0, 9000]\nfoundation = 'found.json'\n[shaft]\nlength = [2.0]\ndiameter = [0.1]\nelement = 0.25\n"
    return shaft + "".join(f"[[bearing]]\nposition = {z}\nkxx = 1e8\nkyy = 1e8\ncxx = 1e4\ncyy = 1e4\n" for z in places)


@pytest.mark.parametrize("bearings", [1, 2, 4, pytest.param(8, marks=pytest.mark.slow)])
def test_the_whole_path_holds_for_any_number_of_bearings(bearings, tmp_path, monkeypatch, capsys):
    truth = foundation(bearings)
    rb.save_frf(truth.frf(F), tmp_path / "set")
    assert len(list((tmp_path / "set").iterdir())) == (2 * bearings) ** 2
    frf = rb.load_frf(tmp_path / "set")
    assert frf.labels == truth.labels
    assert rb.check(frf).gaining.shape == (2 * bearings,)
    monkeypatch.chdir(tmp_path)
    assert main(["check", "set"]) in (0, 1)
    # the same as `rbfound identify` does, whose report page is tested with two bearings
    found = rb.identify(frf)
    rb.save_foundation(found, "found.json")
    modes = found.modes().frequency
    np.testing.assert_allclose(
        [modes[np.abs(modes - f).argmin()] for f in truth.modes().frequency], truth.modes().frequency, rtol=1e-4
    )
    places = np.round(np.linspace(0.1, 1.7, bearings), 3)
    (tmp_path / "machine.toml").write_text(machine(places))
    said = load_machine("machine.toml")
    assert len(said.machine.bearings) == bearings
    true = rb.mount(rb.Rotor(rb.Shaft([2.0], [0.1]), element=0.25), said.machine.bearings, on=truth)
    expected, got = (m.at(300.0).modes().above(20).below(180).frequency for m in (true, said.machine))
    for f in expected:
        assert np.abs(got / f - 1).min() < 1e-3
    assert main(["campbell", "machine.toml", "--steps", "5"]) == 0
    assert "rev/min" in capsys.readouterr().out
    # on to the other programs: every seat is tied there
    nodes = list(range(1, bearings + 1))
    assert matrix27(found, nodes).count("CE,NEXT") == 2 * bearings
    assert dmig(found, nodes).count(f"MPC*    {9001:16d}") == 2 * bearings
    for ending in ("npz", "mat"):
        rb.save_foundation(found, tmp_path / f"kept.{ending}")
        np.testing.assert_array_equal(rb.load_foundation(tmp_path / f"kept.{ending}").B, found.B)
