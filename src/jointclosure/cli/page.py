"""Pages to read: a template with figures and tables, without external parts or scripts.

The page's content security policy forbids everything else, in particular the network.
"""

import base64
import hashlib
import json
from collections.abc import Mapping
from importlib import resources
from typing import Any

import jinja2

LIBRARY = "jointclosure.cli"
"""Package with the style and the frame of all pages."""


def source(png: bytes) -> str:
    """Return the bytes of a PNG as a data URL."""
    return "data:image/png;base64," + base64.b64encode(png).decode()


def render(content: dict, template: str, package: str = LIBRARY) -> str:
    """Render a page as HTML from its content and a template of the library or of a package."""
    loaders = [jinja2.PackageLoader(name) for name in dict.fromkeys((package, LIBRARY))]
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader(loaders),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    style = resources.files(LIBRARY).joinpath("templates/style.css").read_text(encoding="utf-8")
    return environment.get_template(template).render(content, style=style)


def provenance_rows(about: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return terms and values on the provenance of results, from the attributes of a dataset."""
    settings = about["configuration" if "configuration" in about else "settings"]
    digest = hashlib.sha256(settings.encode()).hexdigest()[:16]
    named = {
        "Model": about.get("references"),
        "Sources, commit": about["provenance_commit"],
        "Sources, digest": about["source_digest"],
        "Configuration, digest (SHA-256, first 16 digits)": digest,
        "Root seed, from which every random number follows": about.get("root_seed"),
        "Machine": about["provenance_machine"],
    }
    versions = json.loads(about["provenance_versions"])
    rows = [(term, value) for term, value in named.items() if value is not None]
    return rows + [(f"Version of {name}", version) for name, version in versions.items()]
