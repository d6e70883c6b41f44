"""Rendering of the page of a study, and captions of its figures.

A caption is a page of reStructuredText that Snakemake's report reads too, with Jinja expressions
for values of the configuration; its title and alternative text are comments: ``.. title: ...`` and
``.. alt: ...``.
"""

import hashlib
from importlib import resources

import jinja2

from jointclosure.cli import page
from studies.paper.report.sheets import Caption

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
    return page.render(content | {"tones": _TONES}, "page.html.j2", "studies.paper.report")


def template_digest() -> str:
    """Return the digest of the templates, which a page depends on besides the package's Python."""
    digest = hashlib.sha256()
    for package in (page.LIBRARY, "studies.paper.report"):
        templates = resources.files(package).joinpath("templates")
        for file in sorted(templates.iterdir(), key=lambda file: file.name):
            digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


_SETTINGS = {
    "file_insertion_enabled": False,
    "raw_enabled": False,
    "strip_comments": False,
    "halt_level": 2,  # of docutils: a warning is an error
    "report_level": 5,
}


def read_caption(text: str, configuration: dict) -> Caption:
    """Return a caption for a study with this configuration."""
    import docutils.core
    import docutils.nodes

    environment = jinja2.Environment(undefined=jinja2.StrictUndefined)
    filled = environment.from_string(text).render(snakemake={"config": configuration})
    document = docutils.core.publish_doctree(filled, settings_overrides=_SETTINGS)
    comments = {}
    for comment in document.findall(docutils.nodes.comment):
        key, _, value = comment.astext().partition(":")
        comments[key.strip()] = " ".join(value.split())
    paragraphs = [
        " ".join(node.astext().split()) for node in document.findall(docutils.nodes.paragraph)
    ]
    missing = [key for key in ("title", "alt") if not comments.get(key)]
    if missing or not paragraphs:
        raise ValueError(f"a caption lacks {', '.join(missing) or 'its text'}: {text[:60]!r}")
    return Caption(comments["title"], comments["alt"], paragraphs)
