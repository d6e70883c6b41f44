"""What a finished study cost, by rule, and what a million of its simulations would.

python benchmarks/cost_of_study.py results/many_realizations

Reads the benchmarks that Snakemake left in the folder and the sizes of its files; nothing is run.
"""

import argparse
from pathlib import Path

import pandas as pd

from jointclosure.storage.netcdf import reading_netcdf

PER_SIMULATION = {"cases", "pool", "close_study", "close_pool"}
"""Rules whose cost grows with the number of simulations; those of the tail are shown only."""


def costs(results: Path, simulations: int) -> pd.DataFrame:
    """CPU seconds, largest memory [MB] and number of jobs of every rule."""
    rows = []
    folder = results / "benchmarks"
    for rule in sorted({path.relative_to(folder).parts[0] for path in folder.rglob("*.tsv")}):
        files = [folder / rule] if rule.endswith(".tsv") else sorted((folder / rule).rglob("*.tsv"))
        jobs = pd.concat([pd.read_csv(file, sep="\t") for file in files])
        name = rule.removesuffix(".tsv")
        row = {"rule": name, "jobs": len(jobs), "CPU s": jobs.cpu_time.sum()}
        row |= {"most memory MB": jobs.max_rss.max(), "longest s": jobs.s.max()}
        million = 1e6 / simulations * row["CPU s"] / 3600.0
        rows.append(row | {"CPU h a million": million if name in PER_SIMULATION else float("nan")})
    return pd.DataFrame(rows)


def sizes(results: Path, simulations: int) -> pd.DataFrame:
    """Bytes on disk a simulation, and gigabytes a million."""
    of_cases = [file for part in ("cases", "pool") for file in (results / part).glob("*.nc")]
    surfaces = [file for file in of_cases if file.name.endswith(".surfaces.nc")]
    kinds = {
        "surfaces": surfaces,
        "closures": [file for file in of_cases if file not in surfaces],
        "study.nc, pool.nc": _datasets(results),
    }
    rows = []
    for kind, files in kinds.items():
        each = sum(file.stat().st_size for file in files) / simulations
        rows.append({"files": kind, "bytes a simulation": each, "GB a million": 1e-3 * each})
    return pd.DataFrame(rows)


def _datasets(results: Path) -> list[Path]:
    """Of the study, and of its pool where it has one."""
    return [file for file in (results / "study.nc", results / "pool.nc") if file.exists()]


def main(results: Path) -> None:
    """Print both tables."""
    simulations = 0
    for file in _datasets(results):
        with reading_netcdf(file) as study:
            simulations += int(study.sizes["case"] * study.sizes["realization"])
    print(f"{results}: {simulations} simulations")
    for table in (costs(results, simulations), sizes(results, simulations)):
        print(table.round(3).to_string(index=False, na_rep=""))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="results folder, such as results/paper")
    main(parser.parse_args().results)
