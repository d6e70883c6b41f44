"""Cached joints of a study: those of its cases, pilots and experiments, and their datasets."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from jointclosure.engine.cache import Entry, make_missing
from jointclosure.engine.joints import Reading, Row, close_joint, read_joint, stacked
from jointclosure.engine.quantities import names_of_case
from jointclosure.engine.selection import MOST_PAIRS, Pilot, choose_among, possible_scenes
from jointclosure.joint.protocol import FAILURE
from jointclosure.joint.warmup import compile_all, kernels_of
from jointclosure.parameters import Effects, scene_name
from jointclosure.storage.logs import Logbook
from jointclosure.storage.netcdf import read_netcdf, reading_netcdf, write_netcdf
from jointclosure.walls import Walls
from studies.frame.cases import block_settings, blocks_of, cases_of, dataset_of, ensembles_of
from studies.frame.configuration import Configuration, resolved
from studies.frame.settings import BASE, SIDES, ClosureSettings, seeds_of, walls_of
from studies.frame.tables import join_cases, succeeded
from studies.frame.walls import cut_walls, described
from studies.frame.yaml_files import provenance

ROWS = 256
"""Realisations in memory at a time, and compressed together."""


def close_block(
    settings: ClosureSettings,
    walls: Path | Iterable[Walls] | None = None,
    *,
    report: Callable[[str], None] = lambda line: None,
    again: str = "",
    pilot: Path | None = None,
) -> xr.Dataset:
    """Close the joints of a case's block, over (realization, cycle, branch, stress).

    Walls are made from their seeds unless given, or cut out of the file of scanned ones. ``pilot``
    is the file of the choice of effects, with joints that are closed; ``again`` the command that
    repeats a realisation, without its number. A failed one has a status of 16 or more, and NaN.
    """
    reading, known = _reading(settings), {}
    rows: list[Row] = []
    if pilot is not None:
        closed = read_netcdf(pilot)
        if closed.attrs["case"] == settings.case.label:
            seeds = enumerate(closed.seed.values.tolist())
            known = {seed: closed.isel(realization=place) for place, seed in seeds}
    for pair, seed in zip(_pairs(settings, walls), _seeds(settings), strict=True):
        realization = settings.first_realization + len(rows)
        repeat = f"; to repeat it: {again} {realization}" if again else ""
        try:
            if seed in known:
                row = {str(name): array.values for name, array in known[seed].data_vars.items()}
            else:
                row = close_joint(pair, reading)
        except Exception as error:
            error.add_note(f"realisation {realization}{repeat}")
            raise
        what = f"failed{repeat}"
        if row["status"] < FAILURE:
            closures = ", ".join(f"{1e3 * value:.5f}" for value in row["max_closure"])
            what = f"maximum closure {closures} mm"
        seconds = f"{row['timing_simulation']:.2f} s"
        report(f"realisation {realization}: status {int(row['status'])}, {seconds}, {what}")
        rows.append(row)
    return _joined(rows, settings).assign_attrs(scene=scene_name(settings.conditions.effects))


def _reading(settings: ClosureSettings) -> Reading:
    """Return what is stored of the joints of a case."""
    stresses = np.linspace(0.0, settings.largest_stress, settings.stress_points)
    return Reading(settings.conditions, names_of_case(settings.conditions.flow), stresses)


def _seeds(settings: ClosureSettings) -> list[str]:
    return [f"{seed:032x}" for seed in seeds_of(settings)]


def _joined(rows: Sequence[Row], settings: ClosureSettings) -> xr.Dataset:
    """Join the rows of the first joints of a block, with their numbers and seeds."""
    numbers = settings.first_realization + np.arange(len(rows))
    seeds = np.array(_seeds(settings)[: len(rows)], dtype=object)
    return stacked(rows, numbers, seeds, _reading(settings))


def _pairs(settings: ClosureSettings, walls: Path | Iterable[Walls] | None) -> Iterable[Walls]:
    """Return the walls of a block: made from seeds, cut out of a file of scanned ones, or given."""
    if walls is None:
        return walls_of(settings)
    return cut_walls(read_netcdf(walls), settings) if isinstance(walls, Path) else walls


def choose_for_rock(
    settings: Mapping[str, ClosureSettings],
    *,
    report: Callable[[str], None] = lambda line: None,
    walls: Path | None = None,
) -> xr.Dataset:
    """Select effects for all cases of a rock (settings by label), where they matter most.

    Joints closed with these effects are returned, with attributes ``case`` and ``chosen`` (JSON).
    """

    def order(label: str) -> tuple[float, bool]:
        case = settings[label].case  # of the largest stress over the strength
        ratio = case.max_normal_stress / case.number("compressive_strength")
        return (-round(ratio, 12), case.parameter != BASE)

    label = min(settings, key=order)
    examined, joints = settings[label], sum(one.realizations for one in settings.values())
    report(f"{label}, for {len(settings)} cases of {joints} joints together:")
    pairs = list(islice(_pairs(examined, walls), MOST_PAIRS))
    pilot = Pilot(pairs, examined.conditions.checked(), joints)
    choice = choose_among(pilot, examined.effects_chosen_to or 0.0, report)
    reading = _reading(examined.under(effects=choice.effects))
    stored = (replace(closed, stresses=reading.stresses) for closed in choice.closed)
    closed = _joined([read_joint(one, reading.names) for one in stored], examined)
    about = {"effects": choice.effects._asdict(), "error": choice.error}
    details = {"reasons": choice.reasons, "changes": choice.changes.to_dict("records")}
    chosen = about | {"cases": {label: about | details}}
    return closed.assign_attrs(case=label, chosen=json.dumps(chosen))


class Ensemble:
    """Cases of a study, pool or finest numerics; without a ``folder`` no effects are chosen yet."""

    def __init__(self, study: Configuration, name: str = "cases", folder: Path | None = None):
        self._study, self.name, self._started = study, name, folder is not None
        self.folder = folder or Path()
        self.configuration = ensembles_of(study)[name]
        self.cases = {case.label: case for case in cases_of(self.configuration)}
        self.blocks = blocks_of(self.configuration.study)

    def settings(self, label: str, block: range) -> ClosureSettings:
        """Settings of a case and a block, with all effects that may be chosen."""
        return block_settings(self.configuration, self.cases[label], block)

    def pilots(self) -> dict[str, Entry]:
        """Choices of effects by rock, which are those of the study for its pool too."""
        if self.configuration.effects.auto is None:
            return {}
        whole, block = Ensemble(self._study), range(self._study.study.realizations)
        settings: dict[str, dict] = {rock: {} for rock in self._study.rocks}
        for label, case in whole.cases.items():
            settings[case.rock][label] = whole.settings(label, block)
        return {
            rock: Entry(f"effects_of/{rock}", choose_for_rock, (of_cases,), self._walls(rock))
            for rock, of_cases in settings.items()
        }

    def chosen(self) -> dict[str, dict]:
        """Choices by rock in the files of the pilots."""
        pilots = self.pilots().items() if self._started else ()
        files = {rock: entry.file(self.folder) for rock, entry in pilots}
        return {rock: json.loads(_attribute(file, "chosen")) for rock, file in files.items()}

    def _walls(self, rock: str) -> dict[str, Path]:
        """Option of entries of a rock: the file of its scanned walls, if it has them."""
        scanned = self.configuration.rocks[rock].walls
        return {"walls": self.folder / f"walls/{rock}.nc"} if scanned else {}

    def entries(self) -> list[Entry]:
        """Blocks of all cases; with the effects that the pilots chose, if any."""
        chosen = self.chosen()
        return [self._entry(label, block, chosen) for label in self.cases for block in self.blocks]

    def _entry(self, label: str, block: range, chosen: Mapping[str, dict]) -> Entry:
        rock, settings = self.cases[label].rock, self.settings(label, block)
        ensemble = "" if self.name == "cases" else f"--{self.name} "
        again = f"python -m studies repeat {ensemble}{self.folder} {label}"
        options: dict = {"again": again} | self._walls(rock)
        if rock in chosen:
            settings = settings.under(effects=Effects(**chosen[rock]["effects"]))
            if self.name == "cases":
                options["pilot"] = self.folder / f"effects_of/{rock}.nc"
        name = f"{self.name}/{label}.{block.start}"
        return Entry(name, close_block, (settings,), options, len(block))

    def firsts(self) -> list[Entry]:
        """First joint of each rock's base case, with all effects that may be chosen."""
        bases = [label for label, case in self.cases.items() if case.parameter == BASE]
        return [self._entry(label, range(1), {}) for label in bases]

    def kernels(self) -> list[list[str]]:
        """Kernels of all scenes that may be closed."""
        given = self.configuration
        return kernels_of(
            (scene, given.choices, given.numerics)
            for rock in given.rocks.values()
            for scene in possible_scenes(rock.effects, chosen=given.effects.auto is not None)
        )

    def join(self, attributes: dict, report: Callable[[str], None], output: Path) -> None:
        """Write all cases as one dataset (case, realization, ...), with few rows in memory."""
        files = [entry.file(self.folder) for entry in self.entries()]
        cases, rows = list(self.cases.values()), self.configuration.study.realizations
        with reading_netcdf(files[0]) as first:
            frame = join_cases(cases, [first.isel(realization=slice(0, 1)).load()] * len(cases))
        scenes = [_attribute(file, "scene") for file in files[:: len(self.blocks)]]
        about = {"long_name": "effects that were simulated"}
        frame = frame.assign_coords(scene=("case", np.array(scenes, dtype=object), about))
        frame.attrs = attributes
        chunks = {"case": 1, "realization": min(ROWS, rows)}
        write_netcdf(frame, output, self._regions(files, report), "realization", chunks)

    def _regions(
        self, files: Sequence[Path], report: Callable[[str], None]
    ) -> Iterator[tuple[dict, xr.Dataset]]:
        """Generate place and content of every case and block."""
        for place, file in enumerate(files):
            case, block = divmod(place, len(self.blocks))
            with reading_netcdf(file) as closed:
                used, count = int(succeeded(closed).sum()), closed.sizes["realization"]
                report(f"{file.stem}: {used} of {count} realisations are used")
                for start in range(0, count, ROWS):
                    part = closed.isel(realization=slice(start, start + ROWS)).load()
                    first = self.blocks[block].start + start
                    rows = slice(first, first + part.sizes["realization"])
                    yield {"case": case, "realization": rows}, part


def close_ensemble(
    config: dict,
    name: str,
    stated: dict,
    walls: list[str],
    folder: Path,
    workers: int,
    log: Logbook,
) -> dict[str, Any]:
    """Close the joints of an ensemble that are missing, and join all, with the keys ``stated``."""
    log(f"configuration: {json.dumps(config)}")
    ensemble = Ensemble(resolved(config), name, folder)
    prepare, pilots = partial(compile_all, ensemble.kernels(), log), ensemble.pilots().values()
    make_missing(pilots, folder, workers, log.show, "effects chosen", prepare)
    entries = ensemble.entries()
    make_missing(entries, folder, workers, log.show, f"{name}: joints closed", prepare)
    attributes = {
        "title": f"closure of rough joints, study {ensemble.configuration.study.name}",
        "ensemble": name,
        "references": "Rezaei Niya & Selvadurai, Modeling the Approach of Non-mated Rock Fracture "
        "Surfaces Under Quasi-static Normal Load Cycles",
    } | provenance(stated)
    if chosen := ensemble.chosen():
        attributes["effects_chosen"] = json.dumps(chosen)
    if walls:
        attributes["walls"] = described({Path(path).stem: read_netcdf(path) for path in walls})
    (settings,), scanned = entries[0].settings, entries[0].options.get("walls")
    about = {"units": "m", "long_name": "height towards the other wall"}
    pair = zip(SIDES, next(iter(_pairs(settings, scanned))), strict=True)
    first = xr.Dataset({side: (("y", "x"), wall, about) for side, wall in pair})
    return {
        dataset_of(name): partial(ensemble.join, attributes, log),
        "first_walls.nc": first.assign_attrs(spacing_m=settings.grid.spacing),
    }


def _attribute(file: Path, name: str) -> str:
    with reading_netcdf(file) as closed:
        return closed.attrs[name]
