"""The only place that reads and writes netCDF and CSV files.

A file is written under a temporary name in its folder and then renamed: it
is whole or absent, whatever happens meanwhile.
"""

import importlib.metadata
import json
import os
import platform
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import xarray as xr

from jointclosure.compilation import PACKAGE, source_digest


def atomically(path: str | Path, write: Callable[[Path], None]) -> None:
    """Call ``write`` with a temporary path, then rename it to ``path``."""
    path = Path(path)
    handle, temporary = tempfile.mkstemp(
        dir=path.parent, prefix=f".{path.stem}.", suffix=path.suffix
    )
    os.close(handle)
    try:
        write(Path(temporary))
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    finally:
        Path(temporary).unlink(missing_ok=True)


def write_netcdf(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset, compressed, whole or not at all."""
    encoding = {
        name: {"zlib": True, "complevel": 1}
        for name, variable in dataset.variables.items()
        if variable.dtype.kind in "fiu" and variable.ndim > 0
    }
    atomically(
        path,
        lambda temporary: dataset.to_netcdf(temporary, engine="netcdf4", encoding=encoding),
    )


def read_netcdf(path: str | Path) -> xr.Dataset:
    """All of a dataset, the file closed again."""
    with xr.open_dataset(path, engine="netcdf4") as dataset:
        return dataset.load()


def write_csv(frame: pd.DataFrame, path: str | Path) -> None:
    """Write a table, whole or not at all; numbers as short as they read back."""
    atomically(path, lambda temporary: frame.to_csv(temporary, index=False))


def read_csv(path: str | Path) -> pd.DataFrame:
    """A table written by `write_csv`, or an input in the same form."""
    return pd.read_csv(path, comment="#")


def write_text(text: str, path: str | Path) -> None:
    """Write a text, whole or not at all."""
    atomically(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def provenance(configuration: dict) -> dict[str, str]:
    """Attributes that say where a dataset comes from.

    Those with the prefix ``provenance_`` may differ between two runs of the
    same study; the configuration and the digest of the sources may not.
    """
    packages = ("jointclosure", "numpy", "numba", "scipy", "xarray", "netCDF4", "snakemake")
    versions = {name: importlib.metadata.version(name) for name in packages}
    return {
        "Conventions": "CF-1.11",
        "configuration": json.dumps(configuration, sort_keys=True),
        "root_seed": str(configuration["study"]["root_seed"]),
        "source_digest": source_digest(),
        "provenance_versions": json.dumps({"python": platform.python_version()} | versions),
        "provenance_commit": _commit(),
        "provenance_machine": f"{platform.system()} {platform.machine()}",
    }


def _commit() -> str:
    """Commit of the sources, with a mark where they were edited since."""
    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return "unknown (no git)"
    return answer.stdout.strip() or "unknown (not a git checkout)"


def _umask() -> int:
    current = os.umask(0)
    os.umask(current)
    return current
