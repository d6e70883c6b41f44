"""The only place that reads and writes netCDF and CSV files, and writes figures.

A file is written under a temporary name in its folder and then renamed: it
is whole or absent, whatever happens meanwhile.
"""

import importlib.metadata
import json
import os
import platform
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import netCDF4
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from jointclosure.compilation import PACKAGE, source_digest

_CHUNK_CACHE = 1_000_000
"""Bytes of a variable that netCDF keeps in memory while blocks are written, instead of 64 MB."""


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
    dataset = dataset.drop_encoding()
    atomically(
        path,
        lambda temporary: dataset.to_netcdf(
            temporary, engine="netcdf4", encoding=_compression(dataset)
        ),
    )


def write_netcdf_blocks(blocks: Iterable[xr.Dataset], dimension: str, path: str | Path) -> None:
    """Write datasets one behind the other, whole or not at all, one in memory at a time.

    Parameters
    ----------
    blocks : iterable of Dataset
        At least one. Variables that have the dimension have it first; all others
        are the first block's.
    dimension : str
        That along which the blocks follow each other, unlimited in the file.
    path : path
    """

    def write(temporary: Path) -> None:
        rest = iter(blocks)
        first = next(rest).drop_encoding()
        first.to_netcdf(
            temporary,
            engine="netcdf4",
            encoding=_compression(first),
            unlimited_dims=[dimension],
        )
        with netCDF4.Dataset(temporary, "a") as file:
            for variable in file.variables.values():
                variable.set_var_chunk_cache(_CHUNK_CACHE)
            start = first.sizes[dimension]
            for block in rest:
                stop = start + block.sizes[dimension]
                for name, variable in block.variables.items():
                    if dimension in variable.dims:
                        file[name][start:stop] = variable.values
                start = stop

    atomically(path, write)


def _compression(dataset: xr.Dataset) -> dict:
    return {
        name: {"zlib": True, "complevel": 1}
        for name, variable in dataset.variables.items()
        if variable.dtype.kind in "fiu" and variable.ndim > 0
    }


def read_netcdf(path: str | Path) -> xr.Dataset:
    """All of a dataset, the file closed again."""
    with reading_netcdf(path) as dataset:
        return dataset.load()


@contextmanager
def reading_netcdf(path: str | Path) -> Iterator[xr.Dataset]:
    """A dataset of which only what is asked for is read."""
    with xr.open_dataset(path, engine="netcdf4", cache=False) as dataset:
        yield dataset


def write_csv(frame: pd.DataFrame, path: str | Path) -> None:
    """Write a table, whole or not at all; numbers as short as they read back."""
    atomically(path, lambda temporary: frame.to_csv(temporary, index=False))


def read_csv(path: str | Path) -> pd.DataFrame:
    """A table written by `write_csv`, or an input in the same form."""
    return pd.read_csv(path, comment="#")


def write_text(text: str, path: str | Path) -> None:
    """Write a text, whole or not at all."""
    atomically(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure in the format of its path, without the time of day in it."""
    metadata = {"CreationDate": None} if Path(path).suffix == ".pdf" else None
    atomically(path, lambda temporary: figure.savefig(temporary, metadata=metadata))


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
