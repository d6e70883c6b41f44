"""The check of the documentation site finds what is dead, and what a reader offline would lack."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def links():
    spec = importlib.util.spec_from_file_location("links", ROOT / "docs/site/links.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def site(tmp_path):
    (tmp_path / "other.html").write_text('<h1 id="top">x</h1>')
    return tmp_path


@pytest.mark.parametrize(
    "good",
    [
        '<a href="other.html">x</a>',
        '<a href="other.html#top">x</a>',
        '<p id="here"></p><a href="#here">x</a>',
        '<a href="https://example.org/nowhere">x</a>',
        '<img src="data:image/png;base64,AA==">',
    ],
)
def test_a_link_that_leads_somewhere_is_no_problem(links, site, good):
    (site / "index.html").write_text(good)
    assert links.problems(site) == []


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        ('<a href="nowhere.html">x</a>', "does not exist"),
        ('<a href="other.html#bottom">x</a>', "has no such anchor"),
        ('<a href="#there">x</a>', "has no such anchor"),
        ('<img src="nowhere.png">', "does not exist"),
        ('<a href="../outside.html">x</a>', "lies outside of the site"),
        ('<script src="https://example.org/a.js"></script>', "is loaded from another site"),
        ('<link rel="stylesheet" href="//example.org/a.css">', "is loaded from another site"),
    ],
)
def test_what_is_dead_or_fetched_is_named_with_its_page(links, site, bad, said):
    (site / "index.html").write_text(bad)
    (problem,) = links.problems(site)
    assert problem.startswith("index.html: ")
    assert problem.endswith(said)
