"""Rendering of the page of a study."""

import hashlib
from importlib import resources

from jointclosure.cli import page

_TONES = {
    "reproduced": "good",
    "stands": "good",
    "falls": "bad",
    "undecided": "unsure",
    "holds": "good",
    "passed": "good",
    "not reproduced": "bad",
    "does not hold": "bad",
    "FAILED": "bad",
    "cannot be judged": "unsure",
}


def render(content: dict) -> str:
    """Render the content of `studies.paper.report.content.content` as HTML."""
    return page.render(content, "page.html.j2", _TONES, "studies.paper.report")


def template_digest() -> str:
    """Return the digest of the templates, which a page depends on besides the package's Python."""
    digest = hashlib.sha256()
    for package in (page.LIBRARY, "studies.paper.report"):
        templates = resources.files(package).joinpath("templates")
        for file in sorted(templates.iterdir(), key=lambda file: file.name):
            digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
