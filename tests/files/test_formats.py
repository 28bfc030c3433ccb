"""FRFs in the ways that other programs write them: each format, each quirk, and what is refused."""

import re
import struct
import zipfile
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from samples import FREQUENCY, Harmful, foundation
from scipy import io as scipy_io
from written import table, universal

import rbfound as rb
from rbfound.files import arrays as arrays_module
from rbfound.units import from_hertz

LINES = FREQUENCY[1:]  # without 0 Hz, where an acceleration says nothing
FRFS = foundation().frf(LINES)
LABELS = FRFS.labels


def error_of(path, **options):
    with pytest.raises(ValueError) as caught:
        rb.load_frf(path, **options)
    return str(caught.value)


def write(folder, heading, cells, separator="\t", name="h_{i}_from_{j}.txt", encoding="utf-8", comma=False):
    """One file a pair, as another program would: `cells` makes the columns behind the frequency from H (n,)."""
    folder.mkdir(exist_ok=True)
    for i, response in enumerate(LABELS):
        for j, force in enumerate(LABELS):
            columns = [LINES, *cells(FRFS.H[:, i, j])]
            rows = [separator.join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True)]
            text = "\n".join(
                [*([heading] if heading else []), *(row.replace(".", ",") if comma else row for row in rows)]
            )
            (folder / name.format(i=response, j=force)).write_bytes(text.encode(encoding))
    return folder


def polar(scale=1.0, wrap=False):
    def cells(H):
        phase = np.degrees(np.angle(H))
        return scale * np.abs(H), phase % 360 if wrap else phase

    return cells


def parts(scale=1.0):
    return lambda H: (scale * H.real, scale * H.imag)


def same(frf, rtol=1e-10):
    np.testing.assert_allclose(frf.H, FRFS.H, rtol=rtol, atol=1e-11 * np.abs(FRFS.H).max())
    assert frf.labels == LABELS


# --- text files ---

POLAR, PARTS = "Frequency [Hz]\tAmplitude [mm]\tPhase Angle [°]", "Frequency [Hz]\tReal [mm]\tImaginary [mm]"


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_amplitude_in_mm_and_phase_of_either_range_are_read_in_four_encodings(tmp_path, wrap, encoding):
    same(rb.load_frf(write(tmp_path / "set", POLAR, polar(1e3, wrap), encoding=encoding)))


@pytest.mark.parametrize(
    ("separator", "comma"),
    [*((mark, False) for mark in ("\t", " ", "   ", ";", ",", ", ")), *((mark, True) for mark in ("\t", " ", ";"))],
)
def test_any_separator_and_decimal_sign_gives_the_same(tmp_path, separator, comma):
    heading = PARTS.replace("\t", separator)
    same(rb.load_frf(write(tmp_path / "set", heading, parts(1e3), separator, comma=comma)))


def test_without_a_heading_the_columns_are_asked_for_and_then_read(tmp_path):
    folder = write(tmp_path / "set", "", polar(1e3))
    assert "no heading says what its 3 columns are and in which unit. Say it with columns=" in error_of(folder)
    same(rb.load_frf(folder, columns="frequency [Hz], amplitude [mm], phase [deg]"))
    assert "the phase is in None: its heading must say deg or rad" in error_of(
        folder, columns="frequency [Hz], amplitude [mm], phase"
    )


def test_a_phase_in_radians_is_read_where_the_heading_says_so(tmp_path):
    same(
        rb.load_frf(write(tmp_path / "s", "Frequency\tAmplitude [m]\tPhase [rad]", lambda H: (np.abs(H), np.angle(H))))
    )


def test_a_force_of_250_newtons_is_divided_out(tmp_path):
    folder = write(tmp_path / "set", POLAR, polar(250e3))
    same(rb.load_frf(folder, force=250.0))
    assert "force is 0" in error_of(folder, force=0.0)


def test_a_unit_for_a_unit_force_and_another_force_contradict(tmp_path):
    folder = write(tmp_path / "set", "Frequency [Hz]\tReal [mm/kN]\tImag [mm/kN]", parts(1e6))
    same(rb.load_frf(folder))
    assert "is for a unit force already, and force= says 10 N" in error_of(folder, force=10.0)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("m/s", 1j), ("mm/s", 1e3j), ("m/s²", -1), ("(m/s^2)/N", -1), ("mm/s2", -1e3), ("g", -1 / 9.80665), ("µm", 1e6)],
)
def test_mobility_accelerance_and_their_units_become_receptances(tmp_path, unit, factor):
    order = 0 if unit == "µm" else 1 if np.iscomplex(factor) else 2
    omega = from_hertz(LINES)
    scaled = lambda H: ((H * factor * omega**order).real, (H * factor * omega**order).imag)  # noqa: E731
    same(rb.load_frf(write(tmp_path / "set", f"Frequency [Hz]\tReal [{unit}]\tImaginary [{unit}]", scaled)))


def test_a_unit_that_nobody_says_is_asked_for_never_guessed(tmp_path):
    folder = write(tmp_path / "set", "Frequency\tReal\tImaginary", parts())
    assert "does not say in which unit its responses are. Say it with unit=" in error_of(folder)
    assert "does not say in which unit" in error_of(folder, quantity="receptance")
    same(rb.load_frf(folder, unit="m"))
    assert "the unit 'm' is that of receptance, not of accelerance" in error_of(
        folder, unit="m", quantity="accelerance"
    )
    assert "The unit 'furlong' is not known" in error_of(folder, unit="furlong")
    assert "quantity is 'speed'" in error_of(folder, unit="m", quantity="speed")


def test_a_caller_who_contradicts_the_file_is_told(tmp_path):
    folder = write(tmp_path / "set", PARTS, parts(1e3))
    same(rb.load_frf(folder, unit="mm"))
    assert "says that its unit is 'mm', unit= says 'm': only one can be right" in error_of(folder, unit="m")


def test_the_line_at_0_hz_of_an_accelerance_is_left_out_and_said(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        "frequency [Hz],x1 from x1 real [m/s2],x1 from x1 imag [m/s2],x1 from y1 real [m/s2],x1 from y1 im [m/s2],"
        "y1 from x1 real [m/s2],y1 from x1 im [m/s2],y1:y1 re [m/s2],y1/y1 imag [m/s2]\n"
        "0,0,0,0,0,0,0,0,0\n2,1,0,0,0,0,0,1,0\n"
    )
    frf = rb.load_frf(path)
    assert frf.frequency.tolist() == [2.0]
    np.testing.assert_allclose(frf.H[0], -np.eye(2) / from_hertz(2.0) ** 2, atol=1e-15)
    assert "0 Hz was left out" in frf.notes[0]


def test_a_latin_1_heading_with_control_codes_is_refused(tmp_path):
    folder = write(tmp_path / "set", POLAR, polar(1e3))
    (folder / "h_x1_from_x1.txt").write_bytes(b"Frequency [Hz]\tAmplitude [mm]\tPhase [\x99]\n1\t2\t3\n")
    assert "h_x1_from_x1.txt: byte 37 is not UTF-8 text" in error_of(folder)


# --- which file is which ---


def test_a_pattern_tells_seats_or_the_numbers_of_table_2(tmp_path):
    same(
        rb.load_frf(write(tmp_path / "a", PARTS, parts(1e3), name="H-{i}-{j}.dat"), pattern="H-{response}-{force}.dat")
    )
    rb.save_frf(FRFS, tmp_path / "b")
    for path in list((tmp_path / "b").iterdir()):
        path.rename(path.with_name(f"FRF {int(path.name[3:5])}.txt"))
    same(rb.load_frf(tmp_path / "b", pattern="FRF {number}.txt"), rtol=1e-8)
    assert "it must hold {response} and {force}, or {number}" in error_of(tmp_path / "b", pattern="*.txt")
    (tmp_path / "b" / "FRF 16.txt").unlink()
    assert "holds 15 numbered files" in error_of(tmp_path / "b", pattern="FRF {number}.txt")


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_an_index_names_the_files(tmp_path, separator):
    write(tmp_path / "set", PARTS, parts(1e3), name="{i}{j}.asc")
    rows = [f"set/{i}{j}.asc{separator}{i}{separator}{j}" for i in LABELS for j in LABELS]
    index = tmp_path / "index.csv"
    index.write_text("\n".join([separator.join(("File", "Response", "Force")), *rows]))
    same(rb.load_frf(index))
    index.write_text("\n".join([separator.join(("File", "Response", "Force")), rows[0], rows[0]]))
    assert "index.csv, line 3: x1 from x1 was named before" in error_of(index)
    index.write_text(separator.join(("File", "Response", "Force")) + f"\nnone.txt{separator}x1{separator}x1")
    assert "none.txt cannot be read: No such file" in error_of(index)


def test_missing_frfs_are_filled_by_reciprocity_only_when_asked_and_said(tmp_path):
    folder = write(tmp_path / "set", PARTS, parts(1e3))
    for pair in ("x1_from_y2", "x2_from_y1"):
        (folder / f"h_{pair}.txt").unlink()
    assert re.search(r"Missing: x2 from y1, x1 from y2\. fill=True takes", error_of(folder))
    frf = rb.load_frf(folder, fill=True)
    assert frf.notes == ("Filled by reciprocity, not measured: x2 from y1, x1 from y2.",)
    assert frf.between(40, 80).notes == frf.notes
    same(frf)
    (folder / "h_y2_from_x1.txt").unlink()
    assert "Missing: y2 from x1, x1 from y2." in error_of(folder, fill=True)


def test_a_table_with_all_pairs_in_one_file_is_read(tmp_path):
    path = table(tmp_path / "all.csv", FRFS)
    np.testing.assert_array_equal(rb.load_frf(path).H, FRFS.H)
    path.write_text(path.read_text().replace("x1 from x1", "somewhere"))
    assert "does not say of which seats" in error_of(path)


# --- arrays ---


@pytest.mark.parametrize("ending", ["npz", "mat"])
def test_what_is_saved_as_arrays_comes_back_to_the_last_bit(tmp_path, ending):
    kept = rb.FRF(FRFS.frequency, FRFS.H, LABELS, ("A note.",))
    rb.save_frf(kept, tmp_path / f"all.{ending}")
    back = rb.load_frf(tmp_path / f"all.{ending}")
    np.testing.assert_array_equal(back.H, kept.H)
    np.testing.assert_array_equal(back.frequency, kept.frequency)
    assert (back.labels, back.notes) == (kept.labels, kept.notes)
    assert [path.name for path in tmp_path.iterdir()] == [f"all.{ending}"]


@pytest.mark.parametrize("options", [{}, {"do_compression": True}, {"oned_as": "column"}])
def test_a_mat_file_of_another_writer_needs_its_unit_said(tmp_path, options):
    path = tmp_path / "rig.mat"
    scipy_io.savemat(path, {"frequency": LINES, "H": 9.81 * FRFS.H, "other": {"a": [1, "b"]}}, **options)
    assert "does not say in which unit" in error_of(path)
    same(rb.load_frf(path, unit="m", force=9.81))


def test_letters_that_are_stored_as_fractions_are_refused(tmp_path):
    path = tmp_path / "rig.mat"
    scipy_io.savemat(path, {"labels": np.arange(4.0)})
    # an array of doubles whose class says letters
    path.write_bytes(path.read_bytes().replace(b"\x06\0\0\0\x08\0\0\0\x06", b"\x06\0\0\0\x08\0\0\0\x04", 1))
    assert "does not appear to be char" in error_of(path)


WRITTEN = Path(__file__).parent / "octave"


@pytest.mark.parametrize("version", ["v6", "v7"])
def test_a_mat_file_that_octave_wrote_is_read(version):
    frf = rb.load_frf(WRITTEN / f"octave_{version}.mat")
    k, i, j = np.meshgrid(np.arange(1, 6), np.arange(1, 5), np.arange(1, 5), indexing="ij")
    np.testing.assert_allclose(frf.H, 1e-3 * (1e-9 * (k + 10 * i + 100 * j) + 1e-12j * (i + j)), rtol=1e-14)
    assert frf.frequency.tolist() == [2.5, 5.0, 7.5, 10.0, 12.5]
    assert frf.labels == LABELS


def test_a_foundation_that_octave_wrote_is_read():
    body = rb.load_foundation(WRITTEN / "octave_foundation.mat")
    assert body.K.tolist() == [[1e6, -2e5], [-2e5, 3e6]]
    assert body.B.tolist() == [[1.0, 0.1], [0.2, 1.0]]
    assert (body.labels, body.notes) == (("x1", "y1"), ("written by Octave",))


def test_a_mat_file_of_version_4_is_refused_for_it_has_no_third_dimension(tmp_path):
    scipy_io.savemat(tmp_path / "rig.mat", {"frequency": LINES, "H": FRFS.H[:, :, 0]}, format="4")
    assert "not of version 5 to 7: save it with -v7" in error_of(tmp_path / "rig.mat", unit="m")


def test_cells_and_structures_of_matlab_are_refused(tmp_path):
    path = tmp_path / "rig.mat"
    scipy_io.savemat(path, {"frequency": LINES, "H": {"data": FRFS.H}})
    assert "H is a struct: only arrays of numbers or letters" in error_of(path, unit="m")
    scipy_io.savemat(path, {"frequency": LINES, "H": np.array([1, "a"], dtype=object)})
    assert "H is a cell" in error_of(path, unit="m")
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64" + bytes(500))
    assert "save it with -v7" in error_of(path)


def test_a_pickle_in_npz_is_refused_and_not_run(tmp_path):
    path, trace = tmp_path / "bad.npz", tmp_path / "was_run"
    np.savez(path, frequency=LINES, H=np.array([Harmful(trace)], dtype=object))
    assert "pickled objects, which are not read" in error_of(path)
    assert not trace.exists()


def test_zip_bombs_are_refused_before_they_unpack(tmp_path, monkeypatch):
    monkeypatch.setattr(arrays_module, "LARGEST_UNPACKED", 6_000_000)
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("H.npy", "w") as member:
        for _ in range(7):
            member.write(bytes(10**6))
    assert path.stat().st_size < 10_000
    assert "bomb.npz is not a readable .npz file: it unpacks to 7 MB" in error_of(path)


def test_an_array_whose_heading_claims_more_than_there_is_is_refused(tmp_path):
    path = tmp_path / "claim.npz"
    rb.save_frf(FRFS, path)
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    content["H.npy"] = (
        content["H.npy"].replace(b"(4, 4, 4)", b"(4, 4, 4000000000)").replace(b" " * 10 + b"\n", b"\n", 1)
    )
    content["H.npy"] = (
        content["H.npy"][:8] + struct.pack("<H", content["H.npy"].index(b"\n") + 1 - 10) + content["H.npy"][10:]
    )
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    assert "which is not a (4, 4, 4000000000) of complex128" in error_of(path)


def test_a_mat_bomb_is_refused_before_it_unpacks(tmp_path, monkeypatch):
    monkeypatch.setattr(arrays_module, "LARGEST_UNPACKED", 6_000_000)
    packer = zlib.compressobj(9)
    data = b"".join([*(packer.compress(bytes(10**6)) for _ in range(7)), packer.flush()])
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"
    (tmp_path / "bomb.mat").write_bytes(head + struct.pack("<II", 15, len(data)) + data)
    assert "unpacks to more than 6 MB" in error_of(tmp_path / "bomb.mat")


# --- Universal Files, written by pyuff ---


@pytest.mark.parametrize("binary", [0, 1])
def test_universal_files_in_text_and_binary_are_read_with_their_signs(tmp_path, binary):
    # pyuff prints twelve digits of the values and six of unevenly spaced frequencies
    frf = rb.load_frf(universal(tmp_path / "rig.uff", FRFS, binary=binary, flip=(1, 2)))
    np.testing.assert_allclose(frf.frequency, LINES, rtol=1e-5)
    same(frf, rtol=1e-10)
    assert frf.notes == ("Bearings in the order of the file's nodes: node 7 is 1, node 12 is 2.",)


def test_a_universal_file_without_units_needs_them_said(tmp_path):
    path = universal(tmp_path / "rig.unv", rb.FRF(LINES, 1e3 * FRFS.H, FRFS.labels), unit=("NONE", "NONE"))
    assert "does not say in which unit" in error_of(path)
    same(rb.load_frf(path, unit="mm"))
    assert "the unit 'g' is that of accelerance, not of receptance" in error_of(path, unit="g")


def test_a_universal_file_that_contradicts_itself_or_points_along_z_is_refused(tmp_path):
    assert "the unit 'mm/(N)' is that of receptance, not of accelerance" in error_of(
        universal(tmp_path / "a.uff", FRFS, kind=12, unit=("mm", "N"))
    )
    (tmp_path / "b.uff").write_text(universal(tmp_path / "a.uff", FRFS).read_text().replace("  12   2 ", "  12   3 "))
    assert "in direction 3: seats move along X (1) and Y (2)" in error_of(tmp_path / "b.uff")
    (tmp_path / "c.uff").write_text("    -1\n   151\nnothing\n    -1\n")
    assert "c.uff" in error_of(tmp_path / "c.uff")
    backwards = SimpleNamespace(frequency=LINES[::-1], H=FRFS.H[::-1])
    assert "x1 from x1: frequency" in error_of(universal(tmp_path / "d.uff", backwards))
