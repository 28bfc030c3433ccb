"""The map of the thesis: nothing that it numbers is without a place, and the places are what the map says."""

import re

import citation
import numpy as np
import thesis_map as tm

from rbfound import thesis

EQUATIONS = tm.equations()


def test_the_map_counts_79_equations_18_tables_and_27_figures() -> None:
    assert [p.number for p in EQUATIONS] == list(range(1, 80))
    assert [p.number for p in tm.mentioned("tables")] == list(range(1, 19))
    assert [p.number for p in tm.mentioned("figures")] == list(range(1, 28))


def test_every_equation_is_written_out_in_exactly_one_chapter() -> None:
    assert [p.number for p in EQUATIONS if len(p.labels) != 1] == []


def test_every_equation_has_a_function_whose_docstring_names_it() -> None:
    assert [p.number for p in EQUATIONS if not p.functions] == []


def test_every_equation_that_is_no_definition_has_a_test() -> None:
    assert [p.number for p in EQUATIONS if not p.remark and not p.tests] == []


def test_every_table_has_a_chapter_and_a_test() -> None:
    assert [p.number for p in tm.mentioned("tables") if not p.pages or not p.tests] == []


def test_every_figure_is_made_by_a_chapter_or_has_a_line_that_says_why_not() -> None:
    # and not both: the line would be stale
    assert [p.number for p in tm.mentioned("figures") if bool(p.pages) == bool(p.remark)] == []


def test_every_figure_but_the_count_of_publications_is_made() -> None:
    assert [p.number for p in tm.mentioned("figures") if not p.pages] == [1]


def test_the_map_s_markers_are_all_filled_in() -> None:
    page = (tm.ROOT / "book" / "map.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^% generated: (\w+)$", page, re.MULTILINE)) == set(tm.generated())
    source = [page]
    tm.process(None, tm.PAGE, source)  # type: ignore[arg-type]
    assert "generated:" not in source[0]
    assert source[0].count("\n| (") == 79


def test_no_chapter_has_a_label_for_a_number_that_the_thesis_does_not_have() -> None:
    labels = {n for text in tm.pages().values() for label in tm.LABEL.findall(text) for n in tm.spans(label)}
    assert labels <= set(range(1, 80))


def test_numbers_are_read_out_of_sentences() -> None:
    assert tm.spans("7, 50-52 and 54") == {7, 50, 51, 52, 54}
    assert tm.named("tables 3 to 5, and Table 9 and 11.", "table") == {3, 4, 5, 9, 11}
    assert tm.named("the stable 4, equation (3), equations 1–2 of 7 pages", "equation") == {1, 2}
    assert tm.named("the stable 4", "table") == set()


def test_a_test_is_found_through_the_helpers_of_its_file() -> None:
    # one test uses the helper below, though several stand in this file
    using = {test for test, names in tm.uses()["test_map"].items() if "printed_matrix" in names}
    assert using == {"test_the_matrices_that_chapter_4_shows_are_those_of_the_package"}


def printed_matrix(label: str) -> np.ndarray:
    """The numbers in the matrix that stands above a label in chapter 4."""
    block = tm.pages()["notebooks/04_mystery_118"].split(f"$$ ({label})")[0].split("$$\n")[-1]
    rows = block.split("{bmatrix}")[1].split("\\end")[0].split("\\\\")
    return np.array([[float(entry) for entry in row.split("&")] for row in rows])


def test_the_matrices_that_chapter_4_shows_are_those_of_the_package() -> None:
    # equations 75, 77-79, with the powers of ten that stand beside them
    printed = {"eq-75": thesis.PHI, "eq-77": thesis.KE / 1e8, "eq-78": thesis.CE / 1e3, "eq-79": thesis.ME}
    for label, matrix in printed.items():
        np.testing.assert_allclose(printed_matrix(label), matrix, rtol=0, atol=1e-9)


def test_the_page_on_citing_says_what_the_citation_file_says() -> None:
    text = citation.generated()
    cff = (citation.ROOT / "CITATION.cff").read_text(encoding="utf-8")
    (version,) = re.findall(r"^version: (.+)$", cff, re.MULTILINE)
    (title,) = re.findall(r'^title: "(.+)"$', cff, re.MULTILINE)
    assert f"version = {{{version}}}" in text
    assert title in text


def test_a_person_is_cited_by_surname_and_a_group_by_its_name() -> None:
    authors = [{"family-names": "Doe", "given-names": "J."}, {"name": "Some Group"}]
    cff = {"authors": authors, "title": "a: b", "version": "1", "license": "MIT", "date-released": "2026-11-22"}
    text = citation.entry(cff)
    assert text.startswith("@software{a,")
    assert "author = {Doe, J. and {Some Group}}" in text
    assert "year = {2026}" in text
