"""The documentation site: its check finds what is dead, and its notebooks have their figures."""

import html
import importlib
import re
import sys
from pathlib import Path

import pytest
from nbformat import v4

sys.path.insert(0, str(Path(__file__).parents[2] / "docs/site"))


@pytest.fixture(scope="module")
def links():
    return importlib.import_module("links")


@pytest.fixture
def site(tmp_path):
    (tmp_path / "other.html").write_text('<h1 id="top">x</h1>')
    return tmp_path


@pytest.mark.parametrize(
    ("bad", "printed"),
    [
        ('<a href="nowhere.html">x</a>', "does not exist"),
        ('<a href="other.html#bottom">x</a>', "has no such anchor"),
        ('<a href="../outside.html">x</a>', "lies outside of the site"),
        ('<script src="https://example.org/a.js"></script>', "is loaded from another site"),
    ],
)
def test_what_is_dead_or_fetched_is_named_with_its_page(links, site, bad, printed):
    (site / "index.html").write_text(bad)
    (problem,) = links.problems(site)
    assert problem.startswith("index.html: ")
    assert problem.endswith(printed)


def test_a_notebooks_cell_that_shows_has_an_image_whatever_the_environments_backend(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")  # as the Makefile sets it
    pages = importlib.import_module("pages")
    drawn = v4.new_code_cell("import matplotlib.pyplot as plt\nplt.plot([1, 2])\nplt.show()")
    book = pages.executed(v4.new_notebook(cells=[drawn]), "a.py")
    assert any("image/png" in output.get("data", {}) for output in book.cells[0].outputs)
    closed = v4.new_code_cell(drawn.source.replace("plt.show", "plt.close('all'); plt.show"))
    with pytest.raises(pages.PluginError, match=r"a\.py: a cell shows a figure and has no image"):
        pages.executed(v4.new_notebook(cells=[closed]), "a.py")


def test_the_diagrams_are_those_of_their_code_and_name_rules_that_exist():
    diagrams = importlib.import_module("diagrams")
    for name, boxes in {"solver": diagrams.SOLVER, "rules": diagrams.RULES}.items():
        drawn = html.unescape((diagrams.IMAGES / f"{name}.svg").read_text(encoding="utf-8"))
        lines = [line for box in boxes.values() for line in box.text.splitlines()]
        assert all(line in drawn for line in lines if "$" not in line)
    rules = diagrams.IMAGES.parents[1] / "workflow/rules"
    written = "".join(path.read_text(encoding="utf-8") for path in rules.glob("*.smk"))
    named = {name for box in diagrams.RULES.values() for name in re.findall(r"\w+_\w+", box.text)}
    assert named
    assert named <= set(re.findall(r"^ *rule (\w+):", written, re.M))
