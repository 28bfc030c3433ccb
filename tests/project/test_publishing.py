"""What a published copy has beside its pages: launch buttons, Colab copies, Binder files, pinned actions."""

import json
import os
import re
from pathlib import Path

import colab
import pdf
import publishing
import yaml

ROOT = Path(__file__).resolve().parents[2]
WORKFLOW = (ROOT / ".github" / "workflows" / "book.yml").read_text(encoding="utf-8")


def test_launch_buttons_lead_to_the_chapter_in_the_configured_repository() -> None:
    buttons = publishing.launchers("https://github.com/someone/fork.git", "main", "notebooks/01_sdof")
    binder, in_colab = (button["url"] for button in buttons)
    assert binder == "https://mybinder.org/v2/gh/someone/fork/main?urlpath=lab%2Ftree%2Fnotebooks%2F01_sdof.ipynb"
    assert in_colab == "https://colab.research.google.com/github/someone/fork/blob/colab/notebooks/01_sdof.ipynb"


def test_no_repository_is_written_down_and_the_workflow_finds_its_own() -> None:
    config = yaml.safe_load((ROOT / "_config.yml").read_text(encoding="utf-8"))
    assert config["repository"]["url"] == ""
    assert "BOOK_REPOSITORY: ${{ github.server_url }}/${{ github.repository }}" in WORKFLOW


def test_a_card_has_a_picture_only_where_its_address_is_known() -> None:
    here = publishing.card("4. A <title>", "Why?", "Book", "https://a.example/book/", "notebooks/x")
    assert 'content="https://a.example/book/_static/social.png"' in here
    assert 'content="https://a.example/book/notebooks/x.html"' in here
    assert "A &lt;title&gt;" in here
    assert "og:image" not in publishing.card("4. A", "Why?", "Book", "", "notebooks/x")


def test_the_social_card_has_the_size_that_is_asked_for() -> None:
    head = (ROOT / "book" / "static" / "social.png").read_bytes()[16:24]  # a PNG's width and height
    assert (int.from_bytes(head[:4], "big"), int.from_bytes(head[4:], "big")) == (1200, 630)


def test_every_action_is_pinned_to_a_commit() -> None:
    used = re.findall(r"uses: *(\S+)", WORKFLOW)
    assert used
    assert [action for action in used if not re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action)] == []


def test_the_workflow_builds_everywhere_and_publishes_from_the_default_branch_only() -> None:
    workflow = yaml.safe_load(WORKFLOW)
    assert workflow["permissions"] == {"contents": "read"}
    for job in ("publish", "colab"):
        condition = workflow["jobs"][job]["if"]
        assert "github.event_name != 'pull_request'" in condition
        assert "github.event.repository.default_branch" in condition
    assert "if" not in workflow["jobs"]["build"]


def test_what_the_workflow_and_binder_call_is_there() -> None:
    for path in (".ci/run", "tools/colab.py", "binder/postBuild", "binder/environment.yml"):
        assert (ROOT / path).is_file()
    if os.name == "posix":
        # elsewhere a file says nothing of whether it can be run
        assert (ROOT / "binder" / "postBuild").stat().st_mode & 0o111
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert set(re.findall(r"\bmake ([a-z]+)", WORKFLOW)) <= targets


def test_a_copy_for_colab_fetches_the_repository_first_and_is_the_notebook_otherwise() -> None:
    original = ROOT / "notebooks" / "01_sdof.ipynb"
    copy = json.loads(colab.with_fetch(original, "https://github.com/someone/fork"))
    first, *rest = copy["cells"]
    assert "git clone --quiet --depth 1 https://github.com/someone/fork " in "".join(first["source"])
    assert rest == json.loads(original.read_text(encoding="utf-8"))["cells"]


def test_the_door_of_the_book_is_a_page_that_leads_to_its_first_chapter() -> None:
    there = publishing.DOOR.format(title="A book", first="notebooks/00_intro")
    assert there.startswith("<!DOCTYPE html>")
    assert there.count("notebooks/00_intro.html") == 2  # for those who are sent on, and for those who are not


def test_links_of_the_pdf_lead_into_it_where_the_page_is_in_the_book() -> None:
    known = {"notebooks/a.html", "book/b.html"}
    assert pdf.target("notebooks/a.html", "../book/b.html#place", known) == "#book-b--place"
    assert pdf.target("notebooks/a.html", "#place", known) == "#notebooks-a--place"
    assert pdf.target("notebooks/a.html", "https://doi.org/10.1", known) == "https://doi.org/10.1"
    assert pdf.target("notebooks/a.html", "../_modules/x.html", known) == ""


def test_the_parts_of_the_pdf_are_those_of_the_contents() -> None:
    captions = re.findall(r"caption: (.+)", (ROOT / "_toc.yml").read_text(encoding="utf-8"))
    assert list(pdf.parts(ROOT / "_toc.yml").values()) == captions


def test_the_pdf_has_each_chapters_title_on_its_pages() -> None:
    style = pdf.running_head("notebooks-x", '4 The "mystery"')
    assert '@page notebooks-x { @top-right { content: "4 The \\"mystery\\"";' in style
    assert "#notebooks-x { page: notebooks-x; }" in style
