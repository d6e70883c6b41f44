import shutil

import pytest

from jointclosure import compilation


def test_the_digest_follows_the_content_of_the_named_parts(tmp_path, monkeypatch):
    copy = tmp_path / "jointclosure"
    shutil.copytree(compilation.PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(compilation, "PACKAGE", copy)
    whole, physics, tables = (
        compilation.source_digest(*parts) for parts in ((), ("mechanics",), ("tables",))
    )
    (copy / "mechanics/contact.py").touch()
    assert compilation.source_digest() == whole
    with open(copy / "mechanics/contact.py", "a") as file:
        file.write("# a word\n")
    assert compilation.source_digest() != whole
    assert compilation.source_digest("mechanics") != physics
    assert compilation.source_digest("tables") == tables


def test_an_unknown_part_is_an_error():
    with pytest.raises(FileNotFoundError, match="mechanic"):
        compilation.source_digest("mechanic")


def test_the_cache_folder_is_named_by_the_sources():
    assert compilation.cache_folder().name.endswith(compilation.source_digest())
