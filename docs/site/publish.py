"""Store results that pages show: make publish STUDY=results/size

    python docs/site/publish.py build/benchmarks growth [NAME ...]

The first word is the folder of a run's results, the second the run (by default the folder's name).
Files that are stored of the run are replaced; NAME, such as size.csv, stores further ones.
"""

import datetime
import json
import shutil
import sys
from pathlib import Path

import pandas as pd
from templates import ROOT, folder_of

from jointclosure.inputs import InputError
from jointclosure.storage.netcdf import reading_netcdf
from studies.frame.configuration import merged_study
from studies.frame.yaml_files import provenance


def publish(results: Path, run: str, *further: str) -> Path:
    """Store files of a run and its origin; return their folder.

    ``further`` are names of files besides those that are stored already.

    Raises
    ------
    InputError
        If no file is to be stored, or if one is missing or damaged.
    """
    folder = folder_of(run)
    names = {path.name for path in folder.glob("*.*")} - {"origin.json"} | set(further)
    if not names:
        raise InputError(
            f"{run}: nothing is stored of it yet: name the files that pages show, such as "
            f"{sys.executable} docs/site/publish.py {results} {run} {run}.csv {run}.png"
        )

    places = [results / "tables", results / "figures", results]
    sources = {name: [p / name for p in places if (p / name).is_file()] for name in sorted(names)}
    for name, found in sources.items():
        if not found:
            raise InputError(f"{results}: is not complete, {name} lacks")
    origin = _origin(results, run)  # now, as a changed file would mark the commit
    folder.mkdir(parents=True, exist_ok=True)
    for name, (source, *_) in sources.items():
        shutil.copyfile(source, folder / name)
    (folder / "origin.json").write_text(json.dumps(origin, indent=1) + "\n", encoding="utf-8")
    return folder


def _origin(results: Path, run: str) -> dict:
    """Return the origin of results: that in a file of joints, or else the present commit."""
    keys, made = merged_study(), None
    for path in (*sorted(results.glob("*.nc")), *sorted(results.glob("*/*.nc"))):
        with reading_netcdf(path) as dataset:
            if "configuration" in dataset.attrs:
                made = dataset.attrs
                break
    stated = results / "tables/configuration.json"  # all keys of a study
    if made:
        keys = json.loads(stated.read_text("utf-8") if stated.is_file() else made["configuration"])
    now = provenance(keys)
    newest = max(path.stat().st_mtime for path in results.rglob("*.*"))
    tables = (pd.read_csv(path, sep="\t", na_values=["-"]) for path in results.rglob("*.tsv"))
    default = pd.json_normalize(merged_study()).iloc[0].to_dict()
    flat = pd.json_normalize(keys).iloc[0].to_dict()
    name = keys["study"]["name"]
    files = (*ROOT.glob(f"studies/*/{name}.yaml"), ROOT / f"config/{name}.yaml")
    file = next((path for path in files if path.is_file()), ROOT / "config/default.yaml")
    differs = {key: value for key, value in flat.items() if str(default.get(key)) != str(value)}
    stated_in = {"file": str(file.relative_to(ROOT)), "differs": differs}
    return {
        "run": run,
        "commit": (made or now)["provenance_commit"],
        "stored_at": now["provenance_commit"],
        "root_seed": keys["study"]["root_seed"] if made else None,
        "date": datetime.datetime.fromtimestamp(newest, datetime.UTC).date().isoformat(),
        "configuration": stated_in if made else None,
        "cpu_minutes": round(sum(table.cpu_time.sum() for table in tables) / 60.0, 2),
    }


if __name__ == "__main__":
    if len(sys.argv) < 2 or not sys.argv[1]:
        raise SystemExit("make publish STUDY=results/<run>: which results are to be stored?")
    given = Path(sys.argv[1])
    try:
        stored = publish(given, *(sys.argv[2:] or [given.resolve().name]))
    except InputError as error:
        raise SystemExit(str(error)) from None
    print(f"stored in {stored.relative_to(ROOT)}")
