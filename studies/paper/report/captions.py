"""Captions of figures, in the form that Snakemake's report reads too.

A caption is a page of reStructuredText, with Jinja expressions for values of the configuration.
Title and alternative text are comments in it, which readers of the text do not see: ``.. title:
...`` and ``.. alt: ...``.
"""

import docutils.core
import docutils.nodes
import jinja2

from jointclosure.cli.page import Caption

_SETTINGS = {
    "file_insertion_enabled": False,
    "raw_enabled": False,
    "strip_comments": False,
    "halt_level": 2,  # of docutils: a warning is an error
    "report_level": 5,
}


def read_caption(text: str, configuration: dict) -> Caption:
    """Return a caption for a study with this configuration."""
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
