"""What code a result depends on: found from the imports, and told by a digest.

Comments, docstrings and layout do not count: the digest is that of the syntax tree
without them. Nor do descriptions of keys and titles, where nothing shows them (`SHOWN_BY`).
A module that is imported inside of a function counts as any other. The modules that a
package's ``__init__`` imports count where something is imported from the package itself, and
not where one of its modules is.
"""

import ast
import hashlib
from functools import lru_cache
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
NAME = PACKAGE.name
SHOWN_BY = {"entry": "report/settings.py", "Property": "config/properties.py"}
"""Calls whose first argument is a text for readers, the description of a key and the title of a
property, and the module by which it reaches results: the text counts where that is imported."""
UNCOUNTED = ("jobs/job.py", "jobs/logbook.py", "jobs/progress.py", "storage/seals.py")
"""Modules that say how a job goes and guard what it reads: they change no result."""


def code_digest(*names: str) -> str:
    """Digest of modules and of all modules of the package that they import.

    Parameters
    ----------
    *names : str
        Modules of the package by their dotted names below it (``"solvers.fast"``,
        ``"solvers"`` for all below it), or paths of scripts (ending in ``.py``).

    Returns
    -------
    str
        16 hexadecimal digits.

    Raises
    ------
    FileNotFoundError
        A module or script that does not exist.
    """
    files: set[Path] = set()
    for name in names:
        files |= {Path(name).resolve()} if name.endswith(".py") else _files_of(name)
    files = closure(files)
    unseen = frozenset(call for call, shows in SHOWN_BY.items() if PACKAGE / shows not in files)
    digest = hashlib.sha256()
    for file in sorted(files):
        digest.update(file.name.encode() + b"\0" + _code(file, unseen).encode() + b"\0")
    return digest.hexdigest()[:16]


def package_digest() -> str:
    """Digest of all code of the package."""
    return code_digest(*(_name(file) for file in PACKAGE.rglob("*.py")))


def raw_digest() -> str:
    """Digest of the bytes of all modules of the package: quick, and moved by a comment too."""
    digest = hashlib.sha256()
    for file in sorted(PACKAGE.rglob("*.py")):
        digest.update(file.relative_to(PACKAGE).as_posix().encode() + b"\0")
        digest.update(file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def closure(files: set[Path]) -> set[Path]:
    """Files and all files of the package that they import, and those that these import."""
    found: set[Path] = set()
    waiting = set(files)
    while waiting:
        file = waiting.pop()
        found.add(file)
        waiting |= _imports(file) - found
    return found


def _files_of(name: str) -> set[Path]:
    base = PACKAGE.joinpath(*name.split(".")) if name else PACKAGE
    if base.with_suffix(".py").is_file():
        return {base.with_suffix(".py")}
    if (base / "__init__.py").is_file():
        return {base / "__init__.py"} if base == PACKAGE else set(base.rglob("*.py"))
    raise FileNotFoundError(f"{NAME} has no module {name!r}")


def _name(file: Path) -> str:
    parts = file.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@lru_cache(maxsize=None)
def _imports(file: Path) -> frozenset[Path]:
    """Files of the package that a file imports itself."""
    found: set[Path] = set()
    for node in ast.walk(_tree(file)):
        if isinstance(node, ast.Import):
            found |= {f for alias in node.names for f in _module(alias.name)}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                inner = _module(f"{node.module}.{alias.name}")
                found |= inner or _module(node.module)
    return frozenset(found - {PACKAGE / name for name in UNCOUNTED})


def _module(name: str) -> set[Path]:
    """The file of a module of the package, by its full dotted name; none for another's."""
    top, *parts = name.split(".")
    if top != NAME:
        return set()
    base = PACKAGE.joinpath(*parts)
    for file in (base.with_suffix(".py") if parts else base / "__init__.py", base / "__init__.py"):
        if file.is_file():
            return {file}
    return set()


@lru_cache(maxsize=None)
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"), filename=str(file))


@lru_cache(maxsize=None)
def _code(file: Path, unseen: frozenset[str]) -> str:
    """The syntax of a file without comments, docstrings, places and some texts, as text.

    ``unseen`` are the calls of `SHOWN_BY` whose texts do not count.
    """
    tree = ast.parse(file.read_text(encoding="utf-8"), filename=str(file))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            # bare texts have no effect: docstrings, and those that describe a constant
            node.body = [  # type: ignore[attr-defined]
                each
                for each in body
                if not (isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant))
            ]
        if isinstance(node, ast.Call) and getattr(node.func, "id", None) in unseen and node.args:
            node.args[0] = ast.Constant("")
    return ast.dump(tree)
