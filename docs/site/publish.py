"""Store the results that pages show, and renew the tables that the package ships.

    make publish STUDY=results/size
    python docs/site/publish.py build/benchmarks growth

The first is the folder of a run's results, complete; the second the run (docs/site/stored.py has
them all), unless the folder is called like it. What was stored of the run before is replaced.
"""

import datetime
import itertools
import json
import shutil
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd
from stored import ORIGIN, ROOT, RUNS, Run, StoredError, folder_of

from jointclosure.inputs import InputError
from jointclosure.storage.files import atomically
from jointclosure.storage.netcdf import reading_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import read_csv, write_csv
from studies.frame.config.configuration import merged_study
from studies.frame.jobs.seals import check_folder

_PLACES = ("tables", "figures", "")
"""Folders of a run's results in which files are looked for."""


def regions(results: Path) -> pd.DataFrame:
    """Change of the closure without each effect at random conditions, by stress over strength."""
    table = read_csv(_path(results, "effects_auto", "effects_auto.csv")).drop_duplicates("scene")
    ratio = table.max_normal_stress / table.compressive_strength
    rows = []
    for low, high in itertools.pairwise(BANDS):
        part = table[(ratio > low) & (ratio <= high)]
        row = {"from": low, "to": high, "conditions": len(part)}
        for effect in ("interaction", "soft_peaks", "gouge", "breakage", "substrate"):
            changes = part[f"without_{effect}_percent"].replace(np.inf, np.nan)
            row |= {f"{effect}_failed": int(changes.isna().sum()), effect: changes.median()}
            row |= {f"{effect}_least": changes.min(), f"{effect}_largest": changes.max()}
            row[f"{effect}_time"] = part[f"without_{effect}_time"].median()
        rows.append(row)
    return pd.DataFrame(rows)


BANDS = (0.0, 0.001, 0.01, 0.1, 1.0)
"""Ratios of the maximum stress to the strength that limit the rows of the table of regions."""
SUMMARIES = {
    "effects_regions": (regions, "effects_auto"),
}
"""Tables that are made of larger ones when they are stored: how, and of which."""


def publish(results: Path, run: str) -> Path:
    """Store a run; `StoredError` where a file lacks or is not as it was written.

    Returns
    -------
    Path
        The folder of the stored run.
    """
    if run not in RUNS:
        raise StoredError(f"{run}: is none of the runs that pages show: {', '.join(sorted(RUNS))}")
    kept = RUNS[run]
    sources = {name: _path(results, run, name) for name in _wanted(kept)}
    try:
        check_folder(results)
    except InputError as error:
        raise StoredError(str(error)) from None
    # before a tracked file changes, which would mark the commit as edited
    origin = _origin(results, run, max(sources.values(), key=_time))
    folder = folder_of(run)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in kept.figures:
        shutil.copyfile(sources[f"{name}.png"], folder / f"{name}.png")
    for name in kept.tables:
        if name in SUMMARIES:
            write_csv(SUMMARIES[name][0](results), folder / f"{name}.csv")
        else:
            shutil.copyfile(sources[f"{name}.csv"], folder / f"{name}.csv")
    text = json.dumps(origin, indent=1) + "\n"
    atomically(folder / ORIGIN, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    return folder


def _wanted(kept: Run) -> Iterator[str]:
    """Names of the files of results that are stored, or of which something is."""
    for name in kept.tables:
        yield f"{SUMMARIES[name][1] if name in SUMMARIES else name}.csv"
    yield from (f"{name}.png" for name in kept.figures)


def _path(results: Path, run: str, name: str) -> Path:
    paths = [results / place / name for place in _PLACES]
    for path in paths:
        if path.is_file():
            return path
    raise StoredError(f"{results}: is not complete, {name} lacks, which pages need of {run}")


def _time(path: Path) -> float:
    return path.stat().st_mtime


def _origin(results: Path, run: str, newest: Path) -> dict:
    """Return the origin of results from the first netCDF file; else the commit is not known."""
    made = _provenance(results)
    keys = json.loads(made["configuration"]) if made else _configuration(run)
    now = provenance(keys or merged_study())["provenance_commit"]
    date = datetime.datetime.fromtimestamp(_time(newest), datetime.UTC)
    minutes = sum(
        pd.read_csv(path, sep="\t", na_values=["-"]).cpu_time.sum()
        for path in (results / "benchmarks").rglob("*.tsv")
    )
    return {
        "run": run,
        "commit": made["provenance_commit"] if made else None,
        "stored_at": now,
        "version": json.loads(made["provenance_versions"])["jointclosure"] if made
        else version("jointclosure"),
        "root_seed": keys["study"]["root_seed"] if keys else None,
        "date": date.date().isoformat(),
        "configuration": {"file": _file(keys), "differs": _differences(keys)} if keys else None,
        "cpu_minutes": round(minutes / 60.0, 2),
    }  # fmt: skip


def _provenance(results: Path) -> dict[str, str] | None:
    """Attributes of the first netCDF file of a run that says what made it."""
    for path in sorted(results.glob("*.nc")):
        with reading_netcdf(path) as dataset:
            if "provenance_commit" in dataset.attrs:
                stated = results / "tables/configuration.json"  # of a study: all of its keys
                whole = {"configuration": stated.read_text("utf-8")} if stated.is_file() else {}
                return dataset.attrs | whole
    return None


def _configuration(run: str) -> dict | None:
    """Configuration of the study that is called like a run; None where there is none."""
    path = next(ROOT.glob(f"studies/*/{run}.yaml"), ROOT / f"config/{run}.yaml")
    keys = merged_study(path) if path.is_file() else None
    return keys if keys and keys["study"]["name"] == run else None


def _file(keys: dict) -> str:
    name = keys["study"]["name"]
    path = next(ROOT.glob(f"studies/*/{name}.yaml"), ROOT / f"config/{name}.yaml")
    return str(path.relative_to(ROOT)) if path.is_file() else "config/default.yaml"


def _differences(keys: dict) -> dict[str, object]:
    """Keys in which a configuration differs from the default, by their paths."""
    flat, default = dict(_flat(keys)), dict(_flat(merged_study()))
    return {
        path: value for path, value in flat.items() if path not in default or default[path] != value
    }


def _flat(keys: dict, above: str = "") -> Iterator[tuple[str, object]]:
    for name, value in keys.items():
        if isinstance(value, dict) and value:
            yield from _flat(value, f"{above}{name}.")
        else:
            yield f"{above}{name}", value


def main(words: list[str]) -> None:
    """Store a run, and say where."""
    if len(words) not in (1, 2) or not words[0]:
        raise SystemExit("make publish STUDY=results/<run>: which results are to be stored?")
    results = Path(words[0])
    try:
        folder = publish(results, words[-1] if len(words) == 2 else results.resolve().name)
    except StoredError as error:
        raise SystemExit(str(error)) from None
    print(f"stored in {folder.relative_to(ROOT)}")


if __name__ == "__main__":
    main(sys.argv[1:])
