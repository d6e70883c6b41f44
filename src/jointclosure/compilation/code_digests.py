"""Digests of the code that a result depends on, determined from imports.

Comments, docstrings and layout have no effect: the digest is that of the syntax tree without them.
Descriptions of keys have no effect if nothing shows them (`SHOWN_BY`). A module that is imported
inside of a function counts as any other. The modules that a package's ``__init__`` imports count if
something is imported from the package itself, but not if something is imported from one of the
package's modules.
"""

import ast
import contextlib
import copy
import hashlib
import json
import os
import sys
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import TypeGuard

from jointclosure.compilation.cache_folder import PACKAGE, cache_root

ROOTS = {PACKAGE.name: PACKAGE, "studies": PACKAGE.parents[1] / "studies"}
"""Folders of the packages whose code counts; the folder of studies exists in a clone only."""
SHOWN_BY = {"entry": "studies/paper/report/content.py"}
"""Calls whose first argument is a text for readers (description of a key), and the module through
which it reaches results. The text counts only if that module is imported."""
TITLED = ("Property", "Quantity", "_net", "_VARIABLES")
"""Calls whose first argument is the title of a number, and the table of titles of variables:
no numbers depend on them, so that stored joints and kernels stay when a title is reworded."""
UNCOUNTED = (
    "jointclosure/execution/progress.py",
    "jointclosure/storage/logs.py",
)
"""Modules that report on jobs and protect their inputs, and that change no result."""


def code_digest(*names: str, titles: bool = True) -> str:
    """Return the digest (16 hexadecimal digits) of modules and of all modules that they import.

    A name is that of a module below the package ("solvers.fast"), the full name of a module of
    studies, the path of a script (ending in .py), or a function of a module
    ("studies.paper.judged_claims:judge_claims"), of which only what the function uses counts.
    Without ``titles`` the texts of `TITLED` do not count. Raise `FileNotFoundError` for an unknown
    module, and `KeyError` for an unknown function. Digests are stored in `cache_root`, because
    reading the syntax takes most of the time of a start.
    """
    scripts = [Path(name).read_bytes() for name in names if name.endswith(".py")]
    files = [name.rpartition("/")[2] for name in names]
    key = hashlib.sha256(b"\0".join([repr((files, titles)).encode(), *scripts])).hexdigest()
    store = cache_root() / f"digests-{sys.implementation.cache_tag}-{raw_digest()}.json"
    known = {}
    with contextlib.suppress(OSError, ValueError):  # absent, or damaged: written again
        known = json.loads(store.read_text(encoding="utf-8"))
    if key not in known:
        known[key] = _code_digest(*names, titles=titles)
        with contextlib.suppress(OSError):  # without it only the next start takes longer
            store.parent.mkdir(parents=True, exist_ok=True)
            temporary = store.with_suffix(f".{os.getpid()}")
            temporary.write_text(json.dumps(known), encoding="utf-8")
            temporary.replace(store)
    return known[key]


def _code_digest(*names: str, titles: bool) -> str:
    """Compute the `code_digest` of names from the files, without the store."""
    files: set[Path] = set()
    functions: list[ast.AST] = []
    for name in names:
        module, _, function = name.partition(":")
        if function:
            (file,) = _files_of(module)
            used = _used_statements(file, function)
            functions += used
            files |= {file for part in used for file in _imported_files(part)}
        else:
            files |= {Path(name).resolve()} if name.endswith(".py") else _files_of(name)
    files = with_imports(files)
    unseen = frozenset(
        call for call, shows in SHOWN_BY.items() if _path_of_name(shows) not in files
    )
    unseen |= frozenset(() if titles else TITLED)
    digest = hashlib.sha256()
    for part in functions:
        digest.update(_reduced_text(part, unseen).encode() + b"\0")
    for file in sorted(files, key=_sort_key):
        digest.update(file.name.encode() + b"\0" + _code(file, unseen).encode() + b"\0")
    return digest.hexdigest()[:16]


def package_digest() -> str:
    """Return the `code_digest` of all modules of the package."""
    return code_digest(*(_module_name(file) for file in ROOTS["jointclosure"].rglob("*.py")))


@lru_cache(maxsize=None)
def raw_digest() -> str:
    """Return the digest of the bytes of all modules of the packages in `ROOTS`."""
    digest = hashlib.sha256()
    for root in ROOTS.values():
        for file in sorted([*root.rglob("*.py"), *root.rglob("*.pyi")]):
            digest.update(file.relative_to(root.parent).as_posix().encode() + b"\0")
            digest.update(file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def with_imports(files: set[Path]) -> set[Path]:
    """Return source files and all files of `ROOTS` that they import, directly or indirectly."""
    files_found: set[Path] = set()
    waiting = set(files)
    while waiting:
        file = waiting.pop()
        files_found.add(file)
        waiting |= _imports(file) - files_found
    return files_found


def _sort_key(file: Path) -> tuple[bool, Path]:
    """Return the place of a file in an order that does not depend on the folder of scripts."""
    return not any(root in file.parents for root in ROOTS.values()), file


def _path_of_name(name: str) -> Path:
    """Return the path of a file of `ROOTS` by its name below their common folder."""
    top, _, rest = name.partition("/")
    return ROOTS[top] / rest


def _files_of(name: str) -> set[Path]:
    """Return the files of a module or package by its name, full or below the package.

    Raise `FileNotFoundError` if there is none.
    """
    top, *parts = name.split(".")
    base = (
        ROOTS[top].joinpath(*parts)
        if top in ROOTS
        else ROOTS["jointclosure"].joinpath(*name.split("."))
    )
    if base.with_suffix(".py").is_file():
        return {base.with_suffix(".py")}
    if (base / "__init__.py").is_file():
        return _package() if base == ROOTS["jointclosure"] else set(base.rglob("*.py"))
    raise FileNotFoundError(f"jointclosure has no module {name!r}")


def _package() -> set[Path]:
    """Return the files of the package itself: its module, and the stub with its public names."""
    return {PACKAGE / "__init__.py", PACKAGE / "__init__.pyi"}


def _module_name(file: Path) -> str:
    """Return the name of a file's module below the package."""
    parts = file.relative_to(ROOTS["jointclosure"]).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@lru_cache(maxsize=None)
def _imports(file: Path) -> frozenset[Path]:
    """Return the files of `ROOTS` that a source file imports directly."""
    return _imported_files(_tree(file))


def _imported_files(tree: ast.AST) -> frozenset[Path]:
    """Return the files of `ROOTS` that a part of the syntax of a file imports."""
    imported: set[Path] = set()
    for node in _executed_nodes(tree):
        if isinstance(node, ast.Import):
            imported |= {f for alias in node.names for f in _module_files(alias.name)}
        elif isinstance(node, ast.ImportFrom):
            # only the stub of the public names has relative imports
            package = f"{PACKAGE.name}." if node.level else ""
            module = f"{package}{node.module or ''}".rstrip(".")
            for alias in node.names:
                imported |= _module_files(f"{module}.{alias.name}") or _module_files(module)
    return frozenset(imported - {_path_of_name(name) for name in UNCOUNTED})


def _executed_nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """Generate the parts of a syntax tree, without imports for type checkers alone."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        if not (isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"):
            waiting += ast.iter_child_nodes(node)


def _used_statements(file: Path, function: str) -> list[ast.AST]:
    """Return the statements of a module that a function uses, directly or by what it uses.

    They are imports, definitions and assignments of names at the top of the module, and the
    function itself. Raise `KeyError` if the module has no such function.
    """
    bound: dict[str, list[ast.AST]] = {}
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            for alias in node.names:
                one = copy.copy(node)
                one.names = [alias]
                bound.setdefault(alias.asname or alias.name.partition(".")[0], []).append(one)
        else:
            stored = {part.id for part in ast.walk(node) if _stores_name(part)}
            # names that a function or class stores are its own
            for name in {node.name} if hasattr(node, "name") else stored:
                bound.setdefault(name, []).append(node)
    if function not in bound:
        raise KeyError(f"{file}: no function {function!r}")
    used = {}
    waiting = [function]
    while waiting:
        name = waiting.pop()
        if name in bound and name not in used:
            used[name] = bound[name]
            parts = (part for node in bound[name] for part in ast.walk(node))
            waiting += [part.id for part in parts if isinstance(part, ast.Name)]
    return [node for name in sorted(used) for node in used[name]]


def _stores_name(part: ast.AST) -> TypeGuard[ast.Name]:
    """Return whether a part of the syntax is a name to which a value is assigned."""
    return isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store)


def _module_files(name: str) -> set[Path]:
    """Return the file of a module of `ROOTS` by its full dotted name; none for other modules."""
    top, *parts = name.split(".")
    if top not in ROOTS:
        return set()
    base = ROOTS[top].joinpath(*parts)
    if base == PACKAGE:
        return _package()
    for file in (base.with_suffix(".py") if parts else base / "__init__.py", base / "__init__.py"):
        if file.is_file():
            return {file}
    return set()


@lru_cache(maxsize=None)
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"), filename=str(file))


@lru_cache(maxsize=None)
def _code(file: Path, unseen: frozenset[str]) -> str:
    """Return the syntax of a source file as text, like `_reduced_text`."""
    return _reduced_text(ast.parse(file.read_text(encoding="utf-8"), filename=str(file)), unseen)


def _reduced_text(tree: ast.AST, unseen: frozenset[str]) -> str:
    """Return a part of the syntax as text, without docstrings, positions and unseen texts.

    ``unseen`` are the names of calls and variables whose texts are left out (`SHOWN_BY`, `TITLED`).
    The part of the syntax is changed in place.
    """
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            # bare texts have no effect: docstrings, and descriptions of constants
            node.body = [  # type: ignore[attr-defined]
                line
                for line in body
                if not (isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant))
            ]
        if isinstance(node, ast.Call) and getattr(node.func, "id", None) in unseen and node.args:
            node.args[0] = ast.Constant("")
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", None) in unseen:
            node.value = ast.Constant("")
    return ast.dump(tree)
