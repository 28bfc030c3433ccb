"""The commands of a terminal, from files to critical speeds, and what they say when something is wrong."""

import re

import numpy as np
import pytest
from samples import MACHINE, foundation

import rbfound as rb
from rbfound.cli import main
from rbfound.files import load_machine

F = np.arange(5.0, 320.0, 0.5)


@pytest.fixture
def rig(tmp_path):
    """A folder of FRFs with six modes at 48, 95, ... 286 Hz, and a machine file beside it."""
    rb.save_frf(foundation().frf(F), tmp_path / "measured")
    rb.save_foundation(foundation(), tmp_path / "foundation.json")
    (tmp_path / "machine.toml").write_text(MACHINE)
    return tmp_path


def test_check_prints_the_report_and_its_exit_code_says_whether_it_warns(rig, capsys):
    frf = rb.load_frf(rig / "measured")
    assert main(["check", str(rig / "measured")]) == (1 if rb.check(frf).warnings else 0)
    assert capsys.readouterr().out == f"{rb.check(frf)}\n"
    rb.save_frf(rb.FRF(F, -frf.H), rig / "flipped.npz")
    assert main(["check", str(rig / "flipped.npz")]) == 1
    assert "a flipped" in capsys.readouterr().out


def test_check_explains_first_what_it_understood_of_each_file(rig, capsys):
    main(["check", str(rig / "measured"), "--explain"])
    told, report = capsys.readouterr().out.split("\n\n", 1)
    assert len(told.splitlines()) == 17
    assert re.search(r"frf01_x1_from_y1.txt +x1 +y1 +receptance +m +exp\(i w t\)", told)
    assert report == f"{rb.check(rb.load_frf(rig / 'measured'))}\n"


def test_identify_writes_a_foundation_and_a_page_that_needs_nothing_else(rig, capsys):
    out, page = rig / "found.json", rig / "deep" / "report.html"
    words = ["identify", str(rig / "measured"), "--band", "20", "200", "-o", str(out), "--report", str(page)]
    assert main(words) in (0, 1)
    found = rb.load_foundation(out)
    modes = found.modes().frequency
    for f in (47.7465, 95.493, 143.24, 190.986):
        assert np.abs(modes - f).min() < 1e-3 * f
    text = page.read_text(encoding="utf-8")
    assert text.count("data:image/png;base64,") == 3
    assert "Foundation with" in text
    assert not re.search(r'(src|href)="(?!data:)', text)
    assert f"written: {out}" in capsys.readouterr().out
    assert not [path.name for path in rig.iterdir() if path.name.startswith("tmp")]


def test_campbell_gives_what_the_same_machine_gives_in_python(rig, capsys):
    assert main(["campbell", str(rig / "machine.toml"), "--steps", "21", "--count", "4"]) == 0
    out = capsys.readouterr().out
    rotor = rb.Rotor(rb.Shaft([0.5, 0.5], [0.05, 0.04]), {0.5: rb.Disk(10.0, 0.03, 0.05)})
    bearings = {0.0: rb.Bearing(1e8, 1e8, cxx=1e3, cyy=1e3), 1.0: rb.Bearing(1e8, 1e8)}
    machine = rb.mount(rotor, bearings, on=foundation())
    diagram = rb.campbell(machine, np.linspace(0, rb.from_rpm(6000), 21), 4)
    for f in diagram.frequency[0]:
        assert f"{f:.4g}" in out
    for speed in diagram.critical_speeds().speed:
        assert f"{rb.rpm(speed):.0f}" in out
    assert len(diagram.critical_speeds().speed)


def test_a_campbell_diagram_warns_of_what_is_unstable_and_of_nothing_else(tmp_path, capsys):
    # what stands on one bearing in the middle: every second bending mode is undamped, and none unstable
    one = MACHINE.replace('foundation = "foundation.json"\n', "").replace("0.05, 0.04]", "0.05, 0.05]")
    one = one[: one.index("[[disk]]")] + one[one.index("[[bearing]]") : one.rindex("[[bearing]]")]
    path = tmp_path / "machine.toml"
    path.write_text(one.replace("position = 0.0", "position = 0.5"))
    assert main(["campbell", str(path)]) == 0
    assert "Warning" not in capsys.readouterr().out
    path.write_text(one.replace("position = 0.0", "position = 0.5").replace("cxx = 1e3", "cxx = -1e3"))
    assert main(["campbell", str(path)]) == 1
    assert "Warning: unstable in this range: mode" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("command", "shown"),
    [
        ([], "exit codes: 0 all is well"),
        (["check"], "exit codes: 0 all is well"),
        (["identify"], "exit codes: 0 all is well"),
        (["campbell"], "[[bearing]]"),
    ],
)
def test_help_shows_examples_and_exit_codes(command, shown, capsys):
    with pytest.raises(SystemExit) as end:
        main([*command, "--help"])
    assert end.value.code == 0
    out = capsys.readouterr().out
    assert shown in out
    assert max(map(len, out.splitlines())) < 130


def test_wrong_words_and_wrong_input_have_exit_code_2(rig, capsys):
    with pytest.raises(SystemExit) as end:
        main(["measure"])
    assert end.value.code == 2
    assert main(["check", str(rig / "nowhere")]) == 2
    assert "nowhere is not a folder nor a file" in capsys.readouterr().err
    assert main(["identify", str(rig / "measured"), "-o", str(rig / "found.xls")]) == 2
    assert "does not end in .npz, .json or .mat" in capsys.readouterr().err
    assert main(["campbell", str(rig / "machine.toml"), "--steps", "1"]) == 2


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("speeds = [0, 6000]", "speeds = [6000, 0]", r"speeds is \[6000, 0\]"),
        ("speeds = [0, 6000]", "speeds = ['a', 'b']", r"speeds is .*: it must be a list of finite numbers"),
        ("speeds = [0, 6000]\n", "", "speeds is missing"),
        ('"foundation.json"', '"none.json"', "foundation: .*none.json is not a file"),
        ('"foundation.json"', "3", "foundation is 3: it must be a text"),
        ("[shaft]", "[schaft]", "schaft is not known"),
        ("length = [0.5, 0.5]", "length = [0.5]", "shaft: 1 lengths and 2 diameters"),
        ("length = [0.5, 0.5]", "length = 0.5", "shaft.length is 0.5: it must be a list"),
        ("mass = 10.0", 'mass = "10"', r"disk\[1\].mass is '10': it must be a number"),
        ("mass = 10.0", "mass = -1", r"disk\[1\]: mass = -1"),
        ("mass = 10.0", "mass = nan", r"disk\[1\].mass is nan"),
        ("mass = 10.0", "weight = 10.0", r"disk\[1\].weight is not known"),
        ("position = 1.0", "position = 1.1", "bearing: A bearing stands at 1.1 m"),
        ("position = 1.0\nkxx", "kxx", r"bearing\[2\].position is missing"),
        ("position = 1.0\nkxx", "position = 0\nkxx", r"bearing\[2\]: another bearing stands at 0 m"),
        ("cxx = 1e3", "czz = 1e3", r"bearing\[1\].czz is not known"),
    ],
)
def test_a_wrong_entry_of_a_machine_is_named(rig, old, new, told):
    assert old in MACHINE
    (rig / "machine.toml").write_text(MACHINE.replace(old, new, 1))
    with pytest.raises(ValueError, match=rf"machine\.toml: {told}"):
        load_machine(rig / "machine.toml")


def test_a_file_that_is_no_toml_is_named_with_its_line(rig):
    (rig / "machine.toml").write_text(MACHINE.replace("mass = 10.0", "mass = 10 kg"))
    with pytest.raises(ValueError, match=r"machine\.toml is no TOML: .*line 11"):
        load_machine(rig / "machine.toml")
