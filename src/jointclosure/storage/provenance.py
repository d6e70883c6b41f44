"""Provenance of results: commit and digest of the code, versions of packages, machine."""

import contextlib
import importlib.metadata
import json
import os
import platform
import re
import subprocess
from pathlib import Path
from typing import Any

from jointclosure.compilation.cache_folder import PACKAGE
from jointclosure.compilation.code_digests import package_digest
from jointclosure.storage.files import write_text


def origin() -> dict[str, str]:
    """Return attributes of a dataset on its provenance: code, versions of packages, machine.

    Those that begin with ``provenance_`` may differ between runs of the same code.
    """
    versions = versions_of(
        "jointclosure", "numpy", "numba", "scipy", "xarray", "netCDF4", "snakemake"
    )
    return {
        "Conventions": "CF-1.11",
        "source_digest": package_digest(),
        "provenance_versions": json.dumps({"python": platform.python_version()} | versions),
        "provenance_commit": commit(),
        "provenance_machine": f"{platform.system()} {platform.machine()}, {processor()}",
    }


def write_origin(folder: Path, note: str = "") -> None:
    """Write `origin.json`, with the provenance of results, to their folder.

    It has the name of the folder, the present commit, the digest of the code, versions of packages,
    the machine, and a ``note`` if there is one.
    """
    made = origin()
    about = {"run": folder.name, "commit": made.pop("provenance_commit")} | made
    about |= {"note": note} if note else {}
    write_text(json.dumps(about, indent=1) + "\n", folder / "origin.json")


def to_plain(value: Any) -> Any:
    """Convert a value for JSON: named tuples to mappings and tuples to lists, at every level."""
    if hasattr(value, "_asdict"):
        return {name: to_plain(part) for name, part in value._asdict().items()}
    if isinstance(value, dict):
        return {name: to_plain(part) for name, part in value.items()}
    if isinstance(value, tuple | list):
        return [to_plain(part) for part in value]
    return value


def versions_of(*packages: str) -> dict[str, str]:
    """Return the versions of ``packages`` by name; those that are not installed are left out."""
    versions = {}
    for name in packages:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):  # package of an extra
            versions[name] = importlib.metadata.version(name)
    return versions


def commit() -> str:
    """Return the commit of the sources, with "-dirty" if they were edited since.

    Without git, or outside of a clone, it is "unknown" with the reason.
    """
    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return "unknown (no git)"
    return answer.stdout.strip() or "unknown (not a git checkout)"


def processor() -> str:
    """Return the model of the processor, if the system states it, and the number of its cores."""
    path = Path("/proc/cpuinfo")
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    model = re.search(r"model name\s*: (.*)", text)
    return f"{model[1] if model else platform.processor()}, {os.cpu_count()} cores"
