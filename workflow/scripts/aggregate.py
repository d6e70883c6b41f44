"""Join all cases of a study in one dataset, by blocks of realisations."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from jointclosure.engine.aggregation import join_cases, succeeded
from jointclosure.engine.settings import check_settings
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf, write_netcdf_regions
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import read_text
from studies.frame.config.configuration import resolved
from studies.frame.config.typed import Configuration
from studies.frame.ensemble.cases import blocks_of, cases_of, ensembles_of
from studies.frame.ensemble.measured_walls import described
from studies.frame.ensemble.slices import block_settings
from studies.frame.jobs.job import job
from studies.frame.jobs.logbook import Logbook

ROWS = 256
"""Realisations in memory at a time, and compressed together."""


def main(
    inputs: list[str],
    choices: list[str],
    walls: list[str],
    keys: dict,
    stated: dict,
    ensemble: str,
    codes: tuple[str, str],
    output: str,
    log: Logbook,
):
    """Write the dataset of an ensemble, "cases" or "pool", with the keys ``stated`` of it."""
    configuration = ensembles_of(resolved(keys))[ensemble]
    cases, study = cases_of(configuration), configuration.study
    with reading_netcdf(inputs[0]) as first:
        frame = join_cases(cases, [first.isel(realization=slice(0, 1)).load()] * len(cases))
    scenes = [_scene(path) for path in inputs[:: len(blocks_of(study))]]
    about = {"long_name": "effects that were simulated"}
    frame = frame.assign_coords(scene=("case", np.array(scenes, dtype=object), about))
    frame.attrs = {
        "title": f"closure of rough joints, study {study.name}",
        "ensemble": ensemble,
        "references": "Rezaei Niya & Selvadurai, Modeling the Approach of Non-mated Rock Fracture "
        "Surfaces Under Quasi-static Normal Load Cycles",
    } | provenance(stated)
    if choices:
        frame.attrs["effects_chosen"] = json.dumps(
            {Path(path).stem: json.loads(read_text(path)) for path in choices}
        )
    if walls:
        frame.attrs["walls"] = described({Path(path).stem: read_netcdf(path) for path in walls})
    chunks = {"case": 1, "realization": min(ROWS, study.realizations)}
    regions = _regions(inputs, configuration, codes, log)
    write_netcdf_regions(frame, regions, "realization", chunks, output)
    log(f"wrote {output}: {len(cases)} cases")


def _regions(inputs: list[str], configuration: Configuration, codes: tuple[str, str], log: Logbook):
    """Place and content of every case and block, checked; the inputs are in that order."""
    cases = {case.label: case for case in cases_of(configuration)}
    blocks = blocks_of(configuration.study)
    paths = iter(inputs)
    for number, label in enumerate(cases):
        used = 0
        for block in blocks:
            path = next(paths)
            with reading_netcdf(path) as closed:
                expected = block_settings(configuration, cases, label, block, *codes)
                check_settings(path, closed.attrs, expected)
                used += int(succeeded(closed).sum())
                for rows, part in _slices(closed, block):
                    yield {"case": number, "realization": rows}, part
        total = configuration.study.realizations
        log(f"{label}: {used} of {total} realisations are used, {total - used} failed")


def _scene(path: str) -> str:
    with reading_netcdf(path) as closed:
        return closed.attrs["scene"]


def _slices(closed: xr.Dataset, block: range) -> Iterator[tuple[slice, xr.Dataset]]:
    for start in range(0, len(block), ROWS):
        part = closed.isel(realization=slice(start, start + ROWS)).load()
        first = block.start + start
        yield slice(first, first + part.sizes["realization"]), part


if __name__ == "__main__":
    with job(snakemake) as logbook:
        main(
            snakemake.input.cases,
            list(snakemake.input.effects),
            list(snakemake.input.walls),
            snakemake.config,
            snakemake.params.configuration,
            snakemake.params.ensemble,
            (snakemake.params.surface_code, snakemake.params.solver_code),
            snakemake.output[0],
            logbook,
        )
