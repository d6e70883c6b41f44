"""Datasets of a study: files of joints are checked, and joined over all cases of an ensemble."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from jointclosure.ensembles.quantities import QUANTITIES
from jointclosure.joint.status import FAILURE
from jointclosure.storage.files import digest
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf, write_netcdf
from studies.frame.checked_files import ForeignFileError, foreign, read_checked, reading_checked
from studies.frame.joint_tables import join_cases
from studies.frame.settings import Case, Point

ROWS = 256
"""Largest number of realisations that are in memory, and are compressed, together."""
CURVES = tuple(name for name, about in QUANTITIES.items() if "stress" in about.dims)
"""Curves over stress: nine tenths of the numbers of a study."""


def joints_key(point: Point, code: str) -> str:
    """Return the digest of all on which the joints of a point depend, except their realisations.

    ``code`` is the digest of the code that simulates the joints.
    """
    settings = point.settings._replace(first_realization=0, realizations=0)
    return digest(point._replace(settings=settings), code)


def case_in(path: str | Path, joints: xr.Dataset, keys: Mapping[str, str]) -> str:
    """Return the label of the case to which the joints in a file belong.

    ``keys`` has the `joints_key` of each case by its label.

    Raises
    ------
    ForeignFileError
        If the joints belong to no case of this study.
    """
    for label, key in keys.items():
        if joints.attrs.get("key") == key:
            return label
    raise foreign(path)


def check_complete(files: Mapping[str, str], realizations: Mapping[str, Sequence[int]]) -> int:
    """Check that each case has the same realisations, each in one file; return their number.

    Parameters
    ----------
    files : mapping
        Label of the case of each file, by the path of the file.
    realizations : mapping
        Numbers of the realisations in each file, from 0, by the path of the file.

    Raises
    ------
    ForeignFileError
        If a case lacks a realisation that others have, or has one in two files.
    """
    holders: dict[tuple[str, int], str] = {}
    for file, numbers in realizations.items():
        for number in numbers:
            other = holders.setdefault((files[file], number), file)
            if other != file:
                raise ForeignFileError(
                    f"{file}: has realisation {number} of {files[file]}, as {other} has: delete "
                    "both and start again; missing files are made again"
                )
    count = max(number for _, number in holders) + 1
    for label in set(files.values()):
        for number in range(count):
            if (label, number) not in holders:
                raise ForeignFileError(
                    f"{label}: no file of joints has its realisation {number}: delete its files "
                    "and start again; missing files are made again"
                )
    return count


def of_case(joints: xr.Dataset) -> xr.Dataset:
    """Return joints of one case along ``realization`` in place of ``joint``.

    The coordinates that name the case are dropped.
    """
    joints = joints.drop_vars(["case", "rock", "parameter", "level", "value", "cycles"])
    return joints.swap_dims(joint="realization")


def write_ensemble(
    files: Sequence[str],
    keys: Mapping[str, str],
    cases: Sequence[Case],
    attributes: Mapping[str, str],
    output: str | Path,
    report: Callable[[str], None],
) -> None:
    """Write all cases of an ensemble as one dataset (case, realization, ...), few rows at a time.

    Parameters
    ----------
    files : sequence of str
        Files of `close_joints`, of all cases and all blocks of their realisations.
    keys : mapping
        `joints_key` of each case, by its label.
    cases : sequence of Case
        Cases in the order of the dataset.
    attributes : mapping
        Attributes of the dataset.
    output : path
        File to write.
    report : callable
        Called with a line for each file.

    Raises
    ------
    ForeignFileError
        If a file is not of this study, or if the cases do not have the same realisations.
    DamagedFileError
        If a file is not as it was written.
    """
    places = {case.label: place for place, case in enumerate(cases)}
    scenes = [""] * len(cases)
    labels = {}
    realizations = {}
    for file in files:
        with reading_netcdf(file) as joints:
            labels[file] = case_in(file, joints, keys)
            scenes[places[labels[file]]] = joints.attrs["scene"]
            realizations[file] = joints.realization.values.tolist()
    count = check_complete(labels, realizations)
    with reading_checked(files[0], keys[labels[files[0]]]) as joints:
        row = of_case(joints.isel(joint=slice(0, 1)).load())
    frame = join_cases(list(cases), [row] * len(cases))
    about = {"long_name": "effects that were simulated"}
    frame = frame.assign_coords(scene=("case", np.array(scenes, dtype=object), about))
    frame.attrs = dict(attributes)

    def regions() -> Iterator[tuple[dict, xr.Dataset]]:
        for file in files:
            with reading_checked(file, keys[labels[file]]) as joints:
                used = int((joints.status < FAILURE).sum())
                rows = joints.sizes["joint"]
                report(f"{Path(file).stem}: {used} of {rows} realisations are used")
                for start in range(0, rows, ROWS):
                    part = of_case(joints.isel(joint=slice(start, start + ROWS)).load())
                    first, last = part.realization.values[[0, -1]].tolist()
                    at = {"case": places[labels[file]], "realization": slice(first, last + 1)}
                    yield at, part

    chunks = {"case": 1, "realization": min(ROWS, count)}
    write_netcdf(frame, output, regions(), "realization", chunks)


def chosen_effects(files: Iterable[str], keys: Mapping[str, str]) -> str:
    """Return as JSON the effects that were chosen for each rock.

    ``files`` have the datasets of `choose_rock_effects`, and the name of the rock as file name
    without its suffix. ``keys`` are their attributes ``key``, by rock. Errors are as for
    `read_checked`.
    """
    chosen = {}
    for file in files:
        rock = Path(file).stem
        chosen[rock] = json.loads(read_checked(file, keys[rock]).attrs["chosen"])
    return json.dumps(chosen)


def read_joints(files: Iterable[str], keys: Mapping[str, str], cases: Sequence[Case]) -> xr.Dataset:
    """Return the joints of all cases in files as one dataset (case, realization, ...), no curves.

    Arguments and errors are as for `write_ensemble`.
    """
    blocks: dict[str, list[xr.Dataset]] = {case.label: [] for case in cases}
    labels = {}
    realizations = {}
    for file in files:
        joints = read_netcdf(file, without=CURVES)
        labels[file] = case_in(file, joints, keys)
        blocks[labels[file]].append(of_case(joints))
        realizations[file] = joints.realization.values.tolist()
    check_complete(labels, realizations)
    joined = [xr.concat(parts, "realization") for parts in blocks.values()]
    return join_cases(list(cases), joined)
