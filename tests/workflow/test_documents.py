"""What the documents say, held against the project."""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), ROOT / "config/README.md"]


def test_the_key_table_is_that_of_the_schema():
    path = ROOT / "workflow/scripts/key_table.py"
    spec = importlib.util.spec_from_file_location("key_table", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert (ROOT / "config/README.md").read_text(encoding="utf-8") == module.main()


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_links_within_the_project_lead_somewhere(document):
    for target in re.findall(r"\]\(([^)#]+)\)", document.read_text(encoding="utf-8")):
        if "://" not in target:
            assert (document.parent / target).exists(), target


def test_decisions_named_in_docstrings_exist():
    for source in (ROOT / "src").rglob("*.py"):
        for named in re.findall(r"docs/[\w/-]+\.md", source.read_text(encoding="utf-8")):
            assert (ROOT / named).exists(), f"{source}: {named}"


def test_the_python_of_the_readme_runs():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    samples = re.findall(r"```python\n(.*?)```", text, re.S)
    assert samples
    for sample in samples:
        namespace = {}
        exec(compile(sample, "README.md", "exec"), namespace)
    assert float(namespace["joint"].max_closure[0]) > 0.0
