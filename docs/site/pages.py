"""Hooks of mkdocs: pages from outside of docs/, notebooks that are run, equations as MathML."""

import os
import re
from pathlib import Path

import jupytext
from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from nbclient import NotebookClient
from nbconvert import MarkdownExporter
from nbformat import NotebookNode
from traitlets.config import Config

ROOT = Path(__file__).parents[2]
OUTSIDE = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
    "config/README.md": "keys.md",
}
"""Documents outside of docs/, and their pages."""
PICTURES = {".png", ".pdf", ".svg", ".npz"}
_LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(\))")
_EQUATION = re.compile(r'<(span|div) class="arithmatex">\\([\[(])(.*?)\\[\])]</\1>', re.S)


def on_config(config: MkDocsConfig) -> None:
    """Add the pages of the API to the navigation."""
    config.nav.append({"API": [f"api/{name}.md" for name in modules()]})


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are not in docs/, and copies of the files that pages link to."""
    for path, name in OUTSIDE.items():
        files.append(File.generated(config, name, abs_src_path=str(ROOT / path)))
    for name, page in modules().items():
        files.append(File.generated(config, f"api/{name}.md", content=page))
    for source in sorted((ROOT / "docs/notebooks").glob("*.py")):
        for name, content in notebook(source).items():
            files.append(File.generated(config, f"notebooks/{name}", content=content))
    linked = {
        link[2]: (here.parent / link[2]).resolve()
        for here in map(source_of, files.documentation_pages())
        if here
        for link in _LINK.finditer(here.read_text(encoding="utf-8"))
        if (site_path(here, link[2]) or "").startswith("files/")
    }
    for path in sorted(set(linked.values())):
        name = f"files/{shown_as(path)}"
        files.append(File.generated(config, name, content=path.read_bytes()))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Replace targets of links by their places in the site."""
    here = source_of(page.file)

    def moved(link: re.Match) -> str:
        target = site_path(here, link[2]) if here else None
        if target is None:
            return link[0]
        near = os.path.relpath(target, Path(page.file.src_uri).parent)
        return f"{link[1]}{near}{link[3] or ''}{link[4]}"

    return _LINK.sub(moved, markdown)


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Convert equations to MathML, which browsers draw without a script."""

    def drawn(found: re.Match) -> str:
        text = found[3].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
        return convert(text, display="block" if found[2] == "[" else "inline")

    return _EQUATION.sub(drawn, html)


def modules() -> dict[str, str]:
    """Return the API pages of the package and of its subpackages by name."""
    package = ROOT / "src/jointclosure"
    names = [path.parent.name for path in sorted(package.glob("*/__init__.py"))]
    pages = {name: f"# jointclosure.{name}\n\n::: jointclosure.{name}\n" for name in names}
    own = "# jointclosure\n\n::: jointclosure\n    options:\n      show_submodules: false\n"
    return {"jointclosure": own} | pages


def notebook(source: Path) -> dict[str, str | bytes]:
    """Run a notebook, and return its page and pictures by the names of their files."""
    book = executed(jupytext.read(source), source.name)
    shown = ["image/png", "text/markdown", "text/plain"]  # no HTML, as it would contain scripts
    exporter = MarkdownExporter(config=Config({"NbConvertBase": {"display_data_priority": shown}}))
    page, parts = exporter.from_notebook_node(book)
    renamed = {name: f"{source.stem}_{name}" for name in parts["outputs"]}
    for name, other in renamed.items():
        page = page.replace(f"]({name})", f"]({other})")
    pictures = {renamed[name]: picture for name, picture in parts["outputs"].items()}
    return pictures | {f"{source.stem}.md": page}


def executed(book: NotebookNode, name: str) -> NotebookNode:
    """Run a notebook in place; raise `PluginError` if a cell that shows a figure has no image."""
    client = NotebookClient(
        book,
        kernel_name="python3",
        resources={"metadata": {"path": str(ROOT)}},
        config=Config({"KernelManager": {"transport": "ipc"}}),  # no port is opened
    )
    # figures become outputs of their cells; with Agg there are none
    client.execute(env=os.environ | {"MPLBACKEND": "module://matplotlib_inline.backend_inline"})
    for cell in book.cells:
        images = [kind for out in cell.get("outputs", []) for kind in out.get("data", {})]
        if "show()" in cell.source and not any(kind.startswith("image/") for kind in images):
            raise PluginError(f"{name}: a cell shows a figure and has no image:\n{cell.source}")
    return book


def source_of(file: File) -> Path | None:
    """Return the path of a page's source in the project; None for a generated page."""
    return Path(file.abs_src_path).resolve() if file.abs_src_path else None


def site_path(here: Path, link: str) -> str | None:
    """Return the place in the site to which a link leads; None if mkdocs follows it by itself."""
    target = (here.parent / link).resolve()
    if "://" in link or link.startswith("mailto:") or not target.is_relative_to(ROOT):
        return None
    path = target.relative_to(ROOT).as_posix()
    if path in OUTSIDE:
        return OUTSIDE[path]
    if target.is_relative_to(ROOT / "docs"):
        return path.removeprefix("docs/").replace(".py", ".md")
    return f"files/{shown_as(target)}" if target.is_file() else None


def shown_as(path: Path) -> str:
    """Return the name of a copied file; texts get ``.txt``, so that a browser shows them."""
    name = path.relative_to(ROOT).as_posix()
    return name if path.suffix in PICTURES else f"{name}.txt"
