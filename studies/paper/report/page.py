"""Rendering of the page: sections and figures in the template, without external parts or scripts.

The page's content security policy forbids everything else, in particular the network.
"""

import base64
import hashlib
from importlib import resources
from typing import NamedTuple

import jinja2

from studies.paper.report.captions import Caption

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


class Picture(NamedTuple):
    """Figure: its name, the bytes of its PNG, and its caption."""

    name: str
    png: bytes
    caption: Caption

    @property
    def source(self) -> str:
        """Figure as a data URL."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels, from the first chunk of the PNG."""
        return int.from_bytes(self.png[16:20]), int.from_bytes(self.png[20:24])


def render(content: dict, template: str = "page.html.j2") -> str:
    """Render a page as HTML: that of a study, or "joint.html.j2".

    The content is that of `studies.paper.report.content.content`, or
    `studies.paper.report.joint.joint_content`.
    """
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("studies.paper.report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(
        content,
        style=_text("style.css"),
        tones=_TONES,
    )


def template_digest() -> str:
    """Return the digest of the templates, which a page depends on besides the package's Python."""
    digest = hashlib.sha256()
    templates = resources.files("studies.paper.report").joinpath("templates")
    for file in sorted(templates.iterdir(), key=lambda file: file.name):
        digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _text(name: str) -> str:
    folder = resources.files("studies.paper.report").joinpath("templates")
    return folder.joinpath(name).read_text(encoding="utf-8")
