"""Tables as CSV and texts, written completely or not at all."""

from pathlib import Path

import pandas as pd

from jointclosure.inputs import InputError
from jointclosure.storage.files import atomically


def csv_text(frame: pd.DataFrame, figures: int | None = None) -> str:
    """Return a table as CSV; numbers have all digits, or ``figures`` significant ones."""
    form = None if figures is None else f"%.{figures}g"
    return frame.to_csv(index=False, float_format=form)


def write_csv(frame: pd.DataFrame, path: str | Path, figures: int | None = None) -> None:
    """Write a table as `csv_text`."""
    write_text(csv_text(frame, figures), path)


def read_csv(path: str | Path) -> pd.DataFrame:
    """Read a table written by `write_csv`, or an input in the same form."""
    return pd.read_csv(path, comment="#")


def read_text(path: str | Path) -> str:
    """Read a text, such as a log or a CSV; raise `InputError` unless it is UTF-8."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: must be UTF-8 text ({error.reason} at {error.start})") from None


def write_text(text: str, path: str | Path) -> None:
    """Write a text, completely or not at all."""
    atomically(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
