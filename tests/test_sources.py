"""Digests follow what code does, through its imports."""

import shutil

import pytest

from jointclosure import sources


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of the package that may be edited."""
    folder = tmp_path / "jointclosure"
    shutil.copytree(sources.PACKAGE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(sources, "PACKAGE", folder)
    return folder


def digest(*names):
    for cached in (sources._imports, sources._tree, sources._code):
        cached.cache_clear()
    return sources.code_digest(*names)


def edit(file, old, new):
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")


def test_an_edit_moves_the_digest_of_all_that_import_the_module(copy):
    names = ("solvers.fast", "protocol", "statistics.indifference")
    before = [digest(name) for name in names]
    edit(copy / "mechanics/contact.py", "3.0 * substrate", "3.1 * substrate")
    after = [digest(name) for name in names]
    assert [a == b for a, b in zip(before, after, strict=True)] == [False, False, True]


def test_comments_docstrings_and_layout_do_not_count(copy):
    before = digest("mechanics")
    file = copy / "mechanics/contact.py"
    text = file.read_text(encoding="utf-8")
    file.write_text('"""Another text."""\n# a comment\n\n\n' + text.split('"""', 2)[2])
    assert digest("mechanics") == before


def test_an_import_inside_of_a_function_counts(copy, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("def main():\n    from jointclosure.statistics import bootstrap\n")
    before = digest(str(script))
    edit(copy / "statistics/bootstrap.py", "import numpy as np", "import numpy as numpy_")
    assert digest(str(script)) != before


def test_a_script_counts_itself(copy, tmp_path):
    script = tmp_path / "script.py"
    script.write_text("print(1)\n")
    before = digest(str(script))
    script.write_text("print(2)\n")
    assert digest(str(script)) != before


def test_an_unknown_module_is_an_error():
    with pytest.raises(FileNotFoundError, match="mechanic"):
        sources.code_digest("mechanic")
