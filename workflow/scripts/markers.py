"""The parts of a document that are made from results, between its markers."""

import re
from pathlib import Path


def fill(path: Path, parts: dict[str, str]) -> None:
    """Put texts between ``<!-- name -->`` and the next ``<!-- end -->``; all, or an error."""
    text = path.read_text(encoding="utf-8")
    for name, content in parts.items():
        pattern = rf"(<!-- {name} -->\n).*?(<!-- end -->)"
        text, count = re.subn(pattern, lambda m, c=content: m[1] + c + m[2], text, flags=re.S)
        if count != 1:
            raise SystemExit(f"{path}: no place for {name}")
    path.write_text(text, encoding="utf-8")
