"""Check a built site: every link and anchor leads somewhere, and nothing is fetched from elsewhere.

    python docs/site/links.py build/docs

Links to other sites are not followed.
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

_LOADED = {("link", "href"), *((tag, "src") for tag in ("script", "img", "iframe", "source"))}
"""Attributes by which a page loads something, rather than leading to it."""


class Reference(NamedTuple):
    """A link of a page, and whether the page loads what it names."""

    target: str
    loaded: bool


class Contents(HTMLParser):
    """Links and anchors of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.references: list[Reference] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect what an element refers to and is called."""
        for name, value in attrs:
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value or "")
            elif name in ("href", "src") and value:
                self.references.append(Reference(value, (tag, name) in _LOADED))


def problems(site: Path) -> list[str]:
    """List errors in the links of a site, one per line."""
    pages = {path.resolve(): _contents(path) for path in sorted(site.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        for reference in page.references:
            wrong = _problem(path, reference, pages, site.resolve())
            if wrong:
                found.append(f"{path.relative_to(site.resolve())}: {reference.target}: {wrong}")
    return found


def _contents(path: Path) -> Contents:
    contents = Contents()
    contents.feed(path.read_text(encoding="utf-8"))
    return contents


def _problem(path: Path, reference: Reference, pages: dict[Path, Contents], site: Path) -> str:
    """Return the error in a reference, empty if there is none."""
    parts = urlsplit(reference.target)
    if parts.scheme in ("data", "mailto", "javascript"):
        return ""
    if parts.scheme or parts.netloc:
        return "is loaded from another site" if reference.loaded else ""
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    if not target.is_relative_to(site):
        return "" if path.name == "404.html" else "lies outside of the site"
    target = target / "index.html" if target.is_dir() else target
    if not target.is_file():
        return "does not exist"
    anchor = unquote(parts.fragment)
    if anchor and target in pages and anchor not in pages[target].anchors:
        return "has no such anchor"
    return ""


def main() -> int:
    """Print what is wrong; 1 where anything is."""
    site = Path(sys.argv[1])
    found = problems(site)
    print("\n".join(found) or f"{site}: all links lead somewhere")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
