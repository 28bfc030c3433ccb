"""Files of FRFs and of foundations: round trips, and each way in which a file can be wrong."""

import pickle
import re
from pathlib import Path

import numpy as np
import pytest
from samples import FREQUENCY, Harmful, foundation

import rbfound as rb
from rbfound.files.text import COLUMNS

# table 2: sets driven at y1, x1, y2, x2; responses x1, y1, x2, y2 in each, numbered through
NAMES = [
    f"frf{4 * s + r + 1:02d}_{response}_from_{force}.txt"
    for s, force in enumerate(("y1", "x1", "y2", "x2"))
    for r, response in enumerate(("x1", "y1", "x2", "y2"))
]


@pytest.fixture
def folder(tmp_path):
    """Sixteen good files."""
    rb.save_frf(foundation().frf(FREQUENCY), tmp_path / "set")
    return tmp_path / "set"


def rewrite(path, line, change):
    """Change one line (1 is the heading) of a file: `change` gets the cells and returns them."""
    lines = path.read_text().splitlines()
    lines[line - 1] = "\t".join(change(lines[line - 1].split("\t")))
    path.write_text("\n".join(lines) + "\n")


def put(column, value):
    return lambda cells: [*cells[:column], value, *cells[column + 1 :]]


def error_of(folder):
    with pytest.raises(ValueError) as caught:
        rb.load_frf(folder)
    return str(caught.value)


# --- round trips ---


def test_sixteen_files_bear_the_numbers_and_names_of_table_2(folder):
    assert sorted(path.name for path in folder.iterdir()) == NAMES


def test_a_file_has_one_heading_and_five_tab_separated_columns(folder):
    heading, first, *rest = (folder / NAMES[0]).read_text().splitlines()
    assert tuple(heading.split("\t")) == COLUMNS
    assert len(first.split("\t")) == 5
    assert len(rest) == len(FREQUENCY) - 1


def test_frf_7_is_the_response_at_x2_to_a_force_at_x1(folder):
    # table 2: set 2 is driven at x1, its third FRF is bearing 2 along X
    values = np.loadtxt(folder / "frf07_x2_from_x1.txt", skiprows=1)
    H = foundation().frf(FREQUENCY).H[:, 2, 0]
    np.testing.assert_allclose(values[:, 1], np.abs(H), rtol=5e-9)
    np.testing.assert_allclose(values[:, 2], np.degrees(np.angle(H)), rtol=5e-9)
    np.testing.assert_allclose(values[:, 3] + 1j * values[:, 4], H, rtol=5e-9)


def test_a_set_comes_back_to_the_printed_digits(folder):
    # nine digits: each part within 0.5e-8 of itself; frequencies within 0.5e-9
    frf, back = foundation().frf(FREQUENCY), rb.load_frf(folder)
    assert back.labels == frf.labels
    np.testing.assert_allclose(back.frequency, frf.frequency, rtol=5e-10)
    np.testing.assert_allclose(back.H.real, frf.H.real, rtol=5e-9)
    np.testing.assert_allclose(back.H.imag, frf.H.imag, rtol=5e-9)


def test_what_was_loaded_is_saved_and_loaded_again_to_the_last_bit(folder, tmp_path):
    once = rb.load_frf(folder)
    rb.save_frf(once, tmp_path / "again")
    again = rb.load_frf(tmp_path / "again")
    np.testing.assert_array_equal(again.frequency, once.frequency)
    np.testing.assert_array_equal(again.H, once.H)
    for name in NAMES:
        real = [row.split("\t")[3:] for row in (folder / name).read_text().splitlines()]
        assert real == [row.split("\t")[3:] for row in (tmp_path / "again" / name).read_text().splitlines()]


@pytest.mark.parametrize("seats", [2, 6])
def test_one_and_three_bearings_make_the_round_trip_too(seats, tmp_path):
    frf = foundation(seats).frf(FREQUENCY)
    rb.save_frf(frf, tmp_path)
    assert len(list(tmp_path.iterdir())) == seats**2
    back = rb.load_frf(tmp_path)
    assert back.labels == frf.labels
    np.testing.assert_allclose(back.H, frf.H, rtol=1e-8)


def test_an_asymmetric_set_keeps_response_and_force_apart(tmp_path):
    H = np.random.default_rng(0).standard_normal((5, 4, 4)) + 0j
    rb.save_frf(rb.FRF(FREQUENCY, H), tmp_path)
    np.testing.assert_allclose(rb.load_frf(tmp_path).H, H, rtol=5e-9, atol=1e-15)


def test_a_folder_may_be_a_string_and_hold_other_files(folder):
    (folder / "README.md").write_text("not an FRF")
    (folder / "notes.txt").write_text("not an FRF either")
    assert len(rb.load_frf(str(folder)).frequency) == len(FREQUENCY)


def test_a_heading_of_several_lines_a_byte_order_mark_and_windows_line_ends_are_read(folder):
    path = folder / NAMES[0]
    expected = rb.load_frf(folder).H
    rows = path.read_text().splitlines()[1:]
    text = "Harmonic response\r\n\r\n" + "\t".join(COLUMNS) + "\r\n" + "\r\n".join(rows) + "\r\n\r\n"
    path.write_bytes(b"\xef\xbb\xbf" + text.encode())
    np.testing.assert_array_equal(rb.load_frf(folder).H, expected)


def test_phases_may_be_given_from_0_to_360_degrees(folder):
    path = folder / NAMES[4]
    rows = np.loadtxt(path, skiprows=1)
    for line, row in enumerate(rows, start=2):
        rewrite(path, line, put(2, f"{row[2] % 360:.6f}"))
    assert np.isfinite(rb.load_frf(folder).H).all()


# --- bad input: each a ValueError that says which file and line ---


def test_a_missing_file_of_the_sixteen_is_named_by_its_seats(folder):
    (folder / "frf07_x2_from_x1.txt").unlink()
    assert re.search(r"set holds 15 of the 16 FRFs.*Missing: x2 from x1\.", error_of(folder))


def test_a_three_by_four_set_lists_all_that_is_missing(folder):
    for response in ("x1", "y1", "x2", "y2"):
        next(folder.glob(f"*_{response}_from_y2.txt")).unlink()
    assert re.search(
        r"holds 12 of the 16 FRFs.*Missing: x1 from y2, y1 from y2, x2 from y2, y2 from y2\.", error_of(folder)
    )


def test_a_misspelt_name_is_shown_beside_what_is_missing(folder):
    (folder / NAMES[0]).rename(folder / "frf01_x1_by_y1.txt")
    assert re.search(r"Missing: x1 from y1.*frf01_x1_by_y1\.txt", error_of(folder))


def test_two_files_for_one_pair_are_both_named(folder):
    (folder / "old_x1_from_y1.txt").write_bytes((folder / NAMES[0]).read_bytes())
    assert re.search(r"frf01_x1_from_y1\.txt and old_x1_from_y1\.txt.*both hold x1 from y1", error_of(folder))


def test_a_folder_that_is_not_there_or_empty_is_an_error(tmp_path):
    assert "nowhere is not a folder" in error_of(tmp_path / "nowhere")
    assert "holds no FRFs: expected text files with names like frf01_x1_from_y1.txt" in error_of(tmp_path)


def test_another_frequency_on_one_line_is_named_with_both_files_and_lines(folder):
    rewrite(folder / NAMES[9], 4, put(0, "51"))
    message = error_of(folder)
    assert re.search(rf"{NAMES[9]}, line 4: 51 Hz where frf05_x1_from_x1\.txt, line 4, has 50 Hz", message)


def test_a_file_with_fewer_lines_is_named_with_both_numbers(folder):
    path = folder / NAMES[9]
    path.write_text("\n".join(path.read_text().splitlines()[:-1]))
    assert re.search(rf"{NAMES[9]} has 4 frequencies, frf05_x1_from_x1\.txt has 5", error_of(folder))


@pytest.mark.parametrize("word", ["nan", "NaN", "inf", "-inf"])
@pytest.mark.parametrize("column", range(5))
def test_a_number_that_is_not_finite_is_named_with_file_line_and_column(folder, word, column):
    rewrite(folder / NAMES[5], 3, put(column, word))
    assert re.search(rf"{NAMES[5]}, line 3: {re.escape(COLUMNS[column])} is -?(nan|inf)", error_of(folder))


def test_a_file_with_its_heading_only_is_named(folder):
    (folder / NAMES[12]).write_text("\t".join(COLUMNS) + "\n")
    assert re.search(rf"{NAMES[12]}: no row of numbers, only text", error_of(folder))


def test_an_empty_file_is_named(folder):
    (folder / NAMES[12]).write_text("")
    assert re.search(rf"{NAMES[12]}: no row of numbers", error_of(folder))


def test_phase_in_the_wrong_column_contradicts_real_and_imaginary_part(folder):
    path = folder / NAMES[6]
    for line in range(2, 7):
        rewrite(path, line, lambda c: [c[0], c[1], c[3], c[2], c[4]])
    message = error_of(folder)
    # at 0 Hz everything is in or against phase: the first line that can tell may be the first row or the second
    assert re.search(rf"{NAMES[6]}, line [23]: amplitude .* at phase .* but real and imaginary part say", message)
    assert "The columns must be Frequency [Hz], Amplitude [m], Phase [deg]" in message


def test_a_phase_in_radians_contradicts_real_and_imaginary_part(folder):
    path = folder / NAMES[6]
    for line in range(2, 7):
        rewrite(path, line, lambda c: [c[0], c[1], str(np.radians(float(c[2]))), *c[3:]])
    assert re.search(rf"{NAMES[6]}, line [23]: amplitude", error_of(folder))


def test_a_phase_of_the_wrong_sign_contradicts_real_and_imaginary_part(folder):
    rewrite(folder / NAMES[5], 4, lambda c: [c[0], c[1], str(-float(c[2])), *c[3:]])
    assert re.search(rf"{NAMES[5]}, line 4: amplitude", error_of(folder))


def test_four_printed_digits_do_not_count_as_a_contradiction(folder):
    # an export with four digits: amplitude and parts within 5e-5, a phase such as 123.4 deg within 0.05 deg = 9e-4 rad
    for path in folder.iterdir():
        for line in range(2, 7):
            rewrite(path, line, lambda c: [c[0], *(f"{float(v):.3e}" for v in c[1:])])
    assert np.isfinite(rb.load_frf(folder).H).all()


def test_an_unsorted_frequency_is_named_with_file_and_line(folder):
    path = folder / NAMES[3]
    lines = path.read_text().splitlines()
    lines[3], lines[4] = lines[4], lines[3]
    path.write_text("\n".join(lines))
    assert re.search(rf"{NAMES[3]}, line 5: frequency\[3\] = 50 Hz follows 75 Hz: .*must ascend", error_of(folder))


def test_a_doubled_frequency_is_named_with_file_and_line(folder):
    rewrite(folder / NAMES[3], 5, put(0, "50"))
    assert re.search(rf"{NAMES[3]}, line 5: .*follows 50 Hz", error_of(folder))


def test_a_negative_frequency_is_named_with_file_and_line(folder):
    rewrite(folder / NAMES[3], 2, put(0, "-1"))
    assert re.search(rf"{NAMES[3]}, line 2: .*-1", error_of(folder))


@pytest.mark.parametrize("cells", [["50", "1e-9", "0", "1e-9"], ["50", "1e-9", "0", "1e-9", "0", "0"], ["50"]])
def test_a_row_of_four_or_six_numbers_is_named_with_file_and_line(folder, cells):
    rewrite(folder / NAMES[8], 4, lambda _: cells)
    assert re.search(rf"{NAMES[8]}, line 4: {len(cells)} columns where there should be 5", error_of(folder))


def test_text_between_the_numbers_is_named_with_file_and_line(folder):
    rewrite(folder / NAMES[8], 4, put(3, "*****"))
    assert re.search(rf"{NAMES[8]}, line 4: .*is not a row of numbers", error_of(folder))


def test_decimal_commas_are_read_and_a_file_with_commas_and_points_is_refused(folder):
    path, expected = folder / NAMES[8], rb.load_frf(folder).H
    path.write_text(path.read_text().replace(".", ","))
    np.testing.assert_array_equal(rb.load_frf(folder).H, expected)
    rewrite(path, 4, put(3, "1.5"))
    assert re.search(rf"{NAMES[8]}, line 4: a decimal comma and a decimal point", error_of(folder))


def test_a_damaged_first_row_is_not_taken_for_a_heading(folder):
    # the same damage in every file: nothing else would tell that a line was lost
    for name in NAMES:
        rewrite(folder / name, 2, put(3, "*****"))
    assert re.search(r"frf\d\d_\w+\.txt, line 2", error_of(folder))


def test_binary_garbage_is_named_with_its_first_bad_byte(folder):
    (folder / NAMES[10]).write_bytes(b"Frequency\n\xff\xfe\x00\x81")
    assert re.search(rf"{NAMES[10]}: byte 10 is not UTF-8", error_of(folder))


def test_garbage_that_happens_to_be_text_is_named(folder):
    (folder / NAMES[10]).write_bytes(bytes(range(128)))
    assert NAMES[10] in error_of(folder)


# --- writing ---


def test_a_failing_write_leaves_the_old_files_whole(folder, monkeypatch):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    write, calls = Path.write_text, []

    def full_disk(self, *args, **kwargs):
        calls.append(self)
        if len(calls) == 9:
            raise OSError("No space left on device")
        return write(self, *args, **kwargs)

    monkeypatch.setattr(Path, "write_text", full_disk)
    with pytest.raises(OSError, match="No space left"):
        rb.save_frf(foundation().frf(2 * FREQUENCY), folder)
    assert len(calls) == 9
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_saving_leaves_nothing_but_the_files(folder):
    rb.save_frf(foundation().frf(FREQUENCY), folder)
    assert sorted(path.name for path in folder.iterdir()) == NAMES


@pytest.mark.parametrize("labels", [("x1",), ("a", "b"), ("x1", "x2")])
def test_seats_that_a_file_name_cannot_tell_are_refused_before_writing(labels, tmp_path):
    # load_frf finds its way by names like x1_from_y1 and needs x and y of each bearing
    frf = rb.FRF([1.0, 2.0], np.ones((2, len(labels), len(labels))), labels)
    with pytest.raises(ValueError, match=labels[-1]):
        rb.save_frf(frf, tmp_path / "set")
    assert not list(tmp_path.rglob("*.txt"))


# --- foundations ---


def test_a_foundation_comes_back_from_npz_to_the_last_bit(tmp_path):
    kept = rb.thesis.unrounded_foundation()
    rb.save_foundation(kept, tmp_path / "deep" / "kept.npz")
    back = rb.load_foundation(str(tmp_path / "deep" / "kept.npz"))
    for name in "MCKB":
        np.testing.assert_array_equal(getattr(back, name), getattr(kept, name))
    assert back.labels == kept.labels
    assert back.notes == kept.notes
    assert len(back.notes) == 3  # the condition number and two warnings: notes travel with the model
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["kept.npz"]


def test_a_foundation_without_notes_comes_back_without_notes(tmp_path):
    rb.save_foundation(foundation(2, 3), tmp_path / "plain.npz")
    back = rb.load_foundation(tmp_path / "plain.npz")
    assert back.notes == ()
    assert back.labels == ("x1", "y1")


def test_another_ending_than_npz_is_an_error(tmp_path):
    with pytest.raises(ValueError, match=r"kept\.dat does not end in \.npz"):
        rb.save_foundation(foundation(), tmp_path / "kept.dat")


def test_a_pickled_object_is_refused_and_not_run(tmp_path):
    trace = tmp_path / "was_run"
    array = np.array([Harmful(trace)], dtype=object)
    np.savez(tmp_path / "bad.npz", M=array, C=1, K=1, B=1, labels=1, notes=1)
    with pytest.raises(ValueError, match=r"bad\.npz is not a readable \.npz file"):
        rb.load_foundation(tmp_path / "bad.npz")
    (tmp_path / "worse.npz").write_bytes(pickle.dumps(Harmful(trace)))
    with pytest.raises(ValueError, match=r"worse\.npz is not a readable \.npz file"):
        rb.load_foundation(tmp_path / "worse.npz")
    assert not trace.exists()


@pytest.mark.parametrize("part", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_a_truncated_npz_is_an_error_that_names_the_file(part, tmp_path):
    path = tmp_path / "cut.npz"
    rb.save_foundation(foundation(), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(ValueError, match=r"cut\.npz is not a readable \.npz file"):
        rb.load_foundation(path)


def test_flipped_bits_in_an_npz_are_an_error_that_names_the_file(tmp_path):
    path = tmp_path / "flipped.npz"
    rb.save_foundation(foundation(), path)
    damaged = bytearray(path.read_bytes())
    where = damaged.find(np.float64(foundation().B[0, 0]).tobytes())
    assert where > 0
    damaged[where] ^= 0xFF
    path.write_bytes(damaged)
    with pytest.raises(ValueError, match=r"flipped\.npz is not a readable \.npz file"):
        rb.load_foundation(path)


def test_an_npz_of_something_else_is_an_error_that_names_what_is_missing(tmp_path):
    np.savez(tmp_path / "other.npz", M=np.eye(2), C=np.eye(2))
    with pytest.raises(ValueError, match=r"other\.npz holds no foundation: .*K"):
        rb.load_foundation(tmp_path / "other.npz")


def test_a_single_array_is_no_foundation(tmp_path):
    with (tmp_path / "array.npz").open("wb") as file:
        np.save(file, np.eye(4))
    with pytest.raises(ValueError, match=r"array\.npz"):
        rb.load_foundation(tmp_path / "array.npz")


@pytest.mark.parametrize(
    "wrong",
    [{"labels": np.array("x1")}, {"M": np.array([["heavy"]])}, {"B": np.ones((2, 1))}, {"notes": np.array("n")}],
)
def test_parts_of_the_wrong_kind_are_an_error_that_names_the_file(wrong, tmp_path):
    good = {"M": np.eye(1), "C": np.eye(1), "K": np.eye(1), "B": np.eye(1), "labels": ["x1"], "notes": [""]}
    np.savez(tmp_path / "kinds.npz", **(good | wrong))
    with pytest.raises(ValueError, match=r"kinds\.npz"):
        rb.load_foundation(tmp_path / "kinds.npz")


def test_a_failing_write_leaves_the_old_foundation_whole(tmp_path, monkeypatch):
    path = tmp_path / "kept.npz"
    rb.save_foundation(foundation(), path)
    before = path.read_bytes()

    def full_disk(file, **arrays):
        Path(file).write_bytes(b"half a file")
        raise OSError("No space left on device")

    monkeypatch.setattr(np, "savez", full_disk)
    with pytest.raises(OSError, match="No space left"):
        rb.save_foundation(foundation(2), path)
    assert path.read_bytes() == before
    assert [item.name for item in tmp_path.iterdir()] == ["kept.npz"]
