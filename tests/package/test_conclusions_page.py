"""docs/conclusions.md: a text whose numbers a program puts there, and says where from."""

import importlib.util
import re
import sys
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/conclusions.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def publish():
    folder = ROOT / "workflow/scripts"
    sys.path.insert(0, str(folder))
    spec = importlib.util.spec_from_file_location("publish", folder / "publish_conclusions.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    sys.path.remove(str(folder))


def test_every_number_of_the_text_is_the_one_whose_origin_is_told():
    numbers = dict(re.findall(r"<!-- n:(.+?) -->(.*?)<!-- /n -->", PAGE))
    told = PAGE.split("<!-- origins -->")[1].split("<!-- end -->")[0]
    rows = [[cell.strip() for cell in row.split("|")[1:-1]] for row in told.strip().splitlines()]
    assert numbers
    assert numbers == {name: value for name, value, *_ in rows[2:]}


def test_no_measured_number_of_the_text_was_typed():
    """Outside of markers, tables and links a number has no decimal place but settings have."""
    text = re.sub(
        r"<!-- n:.+? -->.*?<!-- /n -->|<!-- (\w+) -->.*?<!-- end -->", "", PAGE, flags=re.S
    )
    assert set(re.findall(r"\d+\.\d+|± ?\d+", text)) == {
        "0.8",  # Hurst exponent
        "±2",  # half-width
        "0.1",  # elasticities alike
    }


def test_a_number_that_there_is_not_is_no_blank(publish):
    page = "a <!-- n:steps 1 -->2 ± 1<!-- /n --> b"
    assert publish.filled(page, {"steps 1": "3 ± 1"}) == page.replace("2 ± 1", "3 ± 1")
    assert publish.filled(page, {}) == page  # of an earlier run
    with pytest.raises(SystemExit, match="no number 'mean'"):
        publish.filled(page.replace("steps 1", "mean"), {})


def test_a_number_is_the_span_of_the_rows_that_are_named(publish):
    table = pd.DataFrame(
        {"cycle": [1, 1, 2, 2], "n": [8, 9, 8, 9], "v": [1.0, 2.0, 3.0, 5.0], "e": [0.1] * 4}
    )
    for rows, text in (
        ({"cycle": 1}, "1.00 ± 0.10 to 2.00 ± 0.10"),
        ({"cycle": 2, "n": publish.MOST}, "5.00 ± 0.10"),
    ):
        number = publish.span("", "v", "e", **rows)
        assert number.text(publish.chosen(table, number.rows)) == text
    with pytest.raises(SystemExit, match="no row has"):
        publish.chosen(table, {"cycle": 3})
