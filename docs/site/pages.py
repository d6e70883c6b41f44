"""Pages of the site that are made when it is built: hooks of mkdocs (see mkdocs.yml).

- Documents that lie outside of docs/ become pages, and links to them are followed.
- A link to another file of the project leads to a copy of it.
- The modules of the package have a page each, from their docstrings.
- Notebooks (docs/notebooks/*.py, cells marked by ``# %%``) are run, and shown with what they
  put out.
- Equations become MathML, which browsers draw by themselves.
"""

import os
import re
from functools import cache
from pathlib import Path

import jupytext
import nbformat
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
    "README.md": "about.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
    "config/README.md": "keys.md",
}
"""Documents outside of docs/, and what their pages are called."""
SHOWN = ["image/svg+xml", "image/png", "text/markdown", "text/plain"]
"""Forms of a cell's value, in order of preference. HTML would bring scripts and styles."""
FIGURES = {"MPLBACKEND": "module://matplotlib_inline.backend_inline"}
"""Environment of a kernel whose figures become outputs of their cells; with Agg there are none."""
_LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(\))")
_EQUATION = re.compile(r'<(span|div) class="arithmatex">\\([\[(])(.*?)\\[\])]</\1>', re.S)


def on_config(config: MkDocsConfig) -> None:
    """Name the pages of the API and the decisions in the navigation."""
    sections = {title: entry for each in config.nav or [] for title, entry in each.items()}
    sections["API"] += [f"api/{name}.md" for name, _ in modules()]
    records = sorted((ROOT / "docs/decisions").glob("[0-9]*.md"))
    sections["Decisions"] += ["decisions/README.md", *(f"decisions/{r.name}" for r in records)]


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are not in docs/."""
    for path, name in OUTSIDE.items():
        files.append(File.generated(config, name, abs_src_path=str(ROOT / path)))
    for name, page in modules():
        files.append(File.generated(config, f"api/{name}.md", content=page))
    for source in sorted((ROOT / "docs/notebooks").glob("*.py")):
        for name, content in notebook(source).items():
            files.append(File.generated(config, f"notebooks/{name}", content=content))
    for path in sorted(linked_files(files)):
        copy = contents_of(ROOT / path)
        files.append(File.generated(config, f"files/{shown_as(path)}", content=copy))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Lead links to where their targets are in the site."""
    here = source_of(page.file)
    if here is None:
        return markdown

    def moved(link: re.Match) -> str:
        target = site_path(here, link[2])
        if target is None:
            return link[0]
        near = os.path.relpath(target, Path(page.file.src_uri).parent)
        return f"{link[1]}{near}{link[3] or ''}{link[4]}"

    return _LINK.sub(moved, markdown)


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Equations as MathML."""

    def drawn(found: re.Match) -> str:
        text = found[3].replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")
        return convert(text, display="block" if found[2] == "[" else "inline")

    return _EQUATION.sub(drawn, html)


@cache
def modules() -> tuple[tuple[str, str], ...]:
    """Modules and packages right below the package: their names, and their pages."""
    package = ROOT / "src/jointclosure"
    found = ["jointclosure"]
    for path in sorted(package.iterdir()):
        source = path / "__init__.py" if path.is_dir() else path
        if source.is_file() and source.suffix == ".py" and not path.name.startswith("__"):
            found.append(path.stem)
    return tuple((name, _api_page(name)) for name in found)


def _api_page(name: str) -> str:
    whole = name if name == "jointclosure" else f"jointclosure.{name}"
    title = f"---\ntitle: {name}\n---\n\n# {whole}\n\n"
    if name == "jointclosure":  # its names are defined elsewhere: those, and no module of it
        return f"{title}::: {whole}\n    options:\n      show_submodules: false\n"
    return f"{title}::: {whole}\n"


def notebook(source: Path) -> dict[str, str | bytes]:
    """A notebook that was run, as files: a page, its pictures, and itself for Jupyter."""
    book = executed(jupytext.read(source), source.name)
    shown = Config({"NbConvertBase": {"display_data_priority": SHOWN}})
    page, parts = MarkdownExporter(config=shown).from_notebook_node(book)
    files: dict[str, str | bytes] = {}
    for name, picture in parts["outputs"].items():
        own = f"{source.stem}_{name}"
        page = page.replace(f"]({name})", f"]({own})")
        files[own] = picture
    files[f"{source.stem}.ipynb"] = nbformat.writes(book)
    download = f"[download it]({source.stem}.ipynb)"
    files[f"{source.stem}.md"] = f"{page}\nA notebook, run when this site was built: {download}.\n"
    return files


def executed(book: NotebookNode, name: str) -> NotebookNode:
    """Run a notebook in place; `PluginError` where a cell shows a figure and has no image of it."""
    local = Config({"KernelManager": {"transport": "ipc"}})  # no port is opened
    where = {"metadata": {"path": str(ROOT)}}
    client = NotebookClient(book, kernel_name="python3", resources=where, config=local)
    client.execute(env=os.environ | FIGURES)
    for cell in book.cells:
        images = [kind for out in cell.get("outputs", []) for kind in out.get("data", {})]
        if "show()" in cell.source and not any(kind.startswith("image/") for kind in images):
            raise PluginError(f"{name}: a cell shows a figure and has no image:\n{cell.source}")
    return book


def source_of(file: File) -> Path | None:
    """Where a page's text is in the project; None for one that is made."""
    return Path(file.abs_src_path).resolve() if file.abs_src_path else None


def site_path(here: Path, link: str) -> str | None:
    """Where in the site a link of a document leads; None where mkdocs follows it by itself."""
    if "://" in link or link.startswith("mailto:"):
        return None
    target = (here.parent / link).resolve()
    if not target.is_relative_to(ROOT):
        return None
    path = target.relative_to(ROOT).as_posix()
    if path in OUTSIDE:
        return OUTSIDE[path]
    if target.is_relative_to(ROOT / "docs/notebooks"):
        return f"notebooks/{target.stem}.md"
    if target.is_relative_to(ROOT / "docs"):
        return target.relative_to(ROOT / "docs").as_posix()
    return f"files/{shown_as(path)}" if target.exists() else None


def linked_files(files: Files) -> set[str]:
    """Files of the project outside of docs/ that a document links to."""
    found = set()
    for file in files.documentation_pages():
        here = source_of(file)
        for link in _LINK.finditer(here.read_text(encoding="utf-8")) if here else ():
            target = (here.parent / link[2]).resolve()
            if (site_path(here, link[2]) or "").startswith("files/"):
                found.add(target.relative_to(ROOT).as_posix())
    return found


def contents_of(path: Path) -> bytes:
    """Return the content of a copy of a file; of a folder, that of each file in it."""
    if path.is_file():
        return path.read_bytes()
    parts = (f"# {each.name}\n".encode() + each.read_bytes() for each in sorted(path.iterdir()))
    return b"\n".join(parts)


def shown_as(path: str) -> str:
    """Name of a copied file: a browser shows text, whatever its language."""
    return path if Path(path).suffix in {".png", ".pdf", ".svg", ".npz"} else f"{path}.txt"
