"""The only place that reads and writes netCDF and CSV files, and writes figures.

A file is whole or absent, whatever happens meanwhile. A netCDF file ends with a
digest of all before it (other readers skip it), see `jointclosure.files`. Files of
measured walls, which others wrote, are read by `jointclosure.scans`.
"""

import contextlib
import importlib.metadata
import json
import os
import platform
import re
import subprocess
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import netCDF4
import pandas as pd
import xarray as xr

from jointclosure.files import atomically, check_seal, seal
from jointclosure.inputs import InputError
from jointclosure.sources import PACKAGE, package_digest

if TYPE_CHECKING:  # a job that draws nothing does not load it
    from matplotlib.figure import Figure

_CHUNK_CACHE = 1_000_000
"""Bytes of a variable that netCDF keeps in memory while blocks are written, instead of 64 MB."""


@contextmanager
def _netcdf_errors() -> Iterator[None]:
    """What netCDF raises when it cannot write, a RuntimeError, as the OSError that it is."""
    try:
        yield
    except RuntimeError as error:
        raise OSError(str(error)) from error


def write_netcdf(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset, compressed, whole or not at all."""
    dataset = dataset.drop_encoding()

    def write(temporary: Path) -> None:
        with _netcdf_errors():
            dataset.to_netcdf(temporary, engine="netcdf4", encoding=_compression(dataset))
        seal(temporary)

    atomically(path, write)


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
        first = next(rest)
        with _growing_netcdf(first, dimension, {}, temporary) as file:
            start = first.sizes[dimension]
            for block in rest:
                stop = start + block.sizes[dimension]
                _put(file, block, {dimension: slice(start, stop)})
                start = stop
        seal(temporary)

    atomically(path, write)


def write_netcdf_regions(
    frame: xr.Dataset,
    regions: Iterable[tuple[dict[str, slice | int], xr.Dataset]],
    dimension: str,
    chunks: dict[str, int],
    path: str | Path,
) -> None:
    """Write a dataset region by region, whole or not at all, one in memory at a time.

    Parameters
    ----------
    frame : Dataset
        Names, types, attributes and all other sizes; one entry along ``dimension``.
    regions : iterable of (dict, Dataset)
        Where each goes, by dimension, and its variables without the dimensions
        whose place is a number. Together they cover the dataset.
    dimension : str
        Unlimited in the file.
    chunks : dict
        Entries along its dimensions that are compressed together.
    path : path
    """

    def write(temporary: Path) -> None:
        with _growing_netcdf(frame, dimension, chunks, temporary) as file:
            for place, region in regions:
                _put(file, region, place)
        seal(temporary)

    atomically(path, write)


@contextmanager
def _growing_netcdf(
    first: xr.Dataset, dimension: str, chunks: dict[str, int], path: Path
) -> Iterator[netCDF4.Dataset]:
    """A new file with a first dataset, open for more along a dimension."""
    first = first.drop_encoding()
    encoding = _compression(first)
    for name, variable in first.variables.items():
        if dimension in variable.dims:
            sizes = dict(first.sizes) | chunks
            encoding.setdefault(name, {})["chunksizes"] = [sizes[size] for size in variable.dims]
    with _netcdf_errors():
        first.to_netcdf(path, engine="netcdf4", encoding=encoding, unlimited_dims=[dimension])
        file = netCDF4.Dataset(path, "a")
    try:
        for stored in file.variables.values():
            stored.set_var_chunk_cache(_CHUNK_CACHE)
        yield file
    except BaseException:
        with contextlib.suppress(RuntimeError):  # the first error is the one to be told
            file.close()
        raise
    with _netcdf_errors():
        file.close()


def _put(file: netCDF4.Dataset, region: xr.Dataset, place: dict[str, slice | int]) -> None:
    """Write those variables of a dataset that have a dimension of its place."""
    for name, variable in region.variables.items():
        dimensions = file[str(name)].dimensions
        if set(dimensions) & set(place) & set(variable.dims):
            index = tuple(place.get(size, slice(None)) for size in dimensions)
            with _netcdf_errors():
                file[str(name)][index] = variable.values


def _compression(dataset: xr.Dataset) -> dict[Any, dict[str, Any]]:
    return {
        name: {"zlib": True, "complevel": 1}
        for name, variable in dataset.variables.items()
        if variable.dtype.kind in "fiu" and variable.ndim > 0
    }


def read_netcdf(path: str | Path, without: tuple[str, ...] = ()) -> xr.Dataset:
    """A dataset but for the variables left out, the file closed again.

    Raises
    ------
    DamagedFileError
        The file is not as it was written, in any bit.
    """
    with reading_netcdf(path) as dataset:
        return dataset.drop_vars(without).load()


@contextmanager
def reading_netcdf(path: str | Path) -> Iterator[xr.Dataset]:
    """A dataset of which only what is asked for is read; errors as for `read_netcdf`."""
    check_seal(Path(path))
    with xr.open_dataset(path, engine="netcdf4", cache=False) as dataset:
        yield dataset


def write_csv(frame: pd.DataFrame, path: str | Path) -> None:
    """Write a table, whole or not at all; numbers as short as they read back."""
    atomically(path, lambda temporary: frame.to_csv(temporary, index=False))


def read_csv(path: str | Path) -> pd.DataFrame:
    """A table written by `write_csv`, or an input in the same form."""
    return pd.read_csv(path, comment="#")


def read_benchmarks(folder: str | Path) -> pd.DataFrame:
    """What Snakemake measured of its jobs: all ``.tsv`` files below a folder, one row a job.

    Returns
    -------
    DataFrame
        Columns rule (file or first folder), job, s [s], max_rss [MB]; jobs too
        short to be measured have NaN.
    """
    rows = [
        pd.read_csv(path, sep="\t", na_values=["-"], usecols=["s", "max_rss"]).assign(
            rule=path.relative_to(folder).with_suffix("").parts[0], job=path.stem
        )
        for path in sorted(Path(folder).rglob("*.tsv"))
    ]
    columns = ["rule", "job", "s", "max_rss"]
    return pd.concat(rows)[columns] if rows else pd.DataFrame(columns=columns)


def read_text(path: str | Path) -> str:
    """A text, such as a log or a CSV; `InputError` where it is no UTF-8."""
    try:
        return Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no UTF-8 text ({error.reason} at {error.start})") from None


def write_text(text: str, path: str | Path) -> None:
    """Write a text, whole or not at all."""
    atomically(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def save_figure(figure: "Figure", path: str | Path) -> None:
    """Write a figure in the format of its path, without the time of day in it."""
    metadata = {"CreationDate": None} if Path(path).suffix == ".pdf" else None
    atomically(path, lambda temporary: figure.savefig(temporary, metadata=metadata))


def provenance(configuration: dict[str, Any]) -> dict[str, str]:
    """Attributes that say where a dataset comes from.

    Those with the prefix ``provenance_`` may differ between two runs of the
    same study; the configuration and the digest of the sources may not. How
    the work was split over jobs changes no result, and is one of the former.
    """
    study = dict(configuration["study"])
    split = study.pop("realizations_per_job", None)
    configuration = configuration | {"study": study}
    versions = versions_of(
        "jointclosure", "numpy", "numba", "scipy", "xarray", "netCDF4", "snakemake"
    )
    return {
        "Conventions": "CF-1.11",
        "configuration": json.dumps(configuration, sort_keys=True),
        "root_seed": str(configuration["study"]["root_seed"]),
        "source_digest": package_digest(),
        "provenance_versions": json.dumps({"python": platform.python_version()} | versions),
        "provenance_commit": _commit(),
        "provenance_realizations_per_job": str(split),
        "provenance_machine": f"{platform.system()} {platform.machine()}, {_processor()}",
    }


def versions_of(*packages: str) -> dict[str, str]:
    """Versions of those of some packages that are installed."""
    versions = {}
    for name in packages:
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):  # of an extra
            versions[name] = importlib.metadata.version(name)
    return versions


def _commit() -> str:
    """Commit of the sources, with a mark where they were edited since."""
    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
    except FileNotFoundError:
        return "unknown (no git)"
    return answer.stdout.strip() or "unknown (not a git checkout)"


def _processor() -> str:
    """Model and number of the processor's cores, the model where the system tells it."""
    path = Path("/proc/cpuinfo")
    told = path.read_text(encoding="utf-8") if path.is_file() else ""
    model = re.search(r"model name\s*: (.*)", told)
    return f"{model[1] if model else platform.processor()}, {os.cpu_count()} cores"
