"""What a finished study cost, by rule, and what a million of its simulations would.

python benchmarks/cost_of_study.py results/many_realizations

Reads the benchmarks that Snakemake left in the folder and the sizes of its files; nothing is run.
"""

import argparse
from pathlib import Path

import pandas as pd

from jointclosure.storage.netcdf import reading_netcdf


def costs(results: Path, simulations: int) -> pd.DataFrame:
    """CPU seconds, largest memory [MB], jobs and CPU hours a million of every rule."""
    rows = []
    folder = results / "benchmarks"
    for rule in sorted({path.relative_to(folder).parts[0] for path in folder.rglob("*.tsv")}):
        files = [folder / rule] if rule.endswith(".tsv") else sorted((folder / rule).rglob("*.tsv"))
        jobs = pd.concat([pd.read_csv(file, sep="\t") for file in files])
        row = {"rule": rule.removesuffix(".tsv"), "jobs": len(jobs), "CPU s": jobs.cpu_time.sum()}
        row |= {"most memory MB": jobs.max_rss.max(), "longest s": jobs.s.max()}
        rows.append(row | {"CPU h a million": 1e6 / simulations * row["CPU s"] / 3600.0})
    return pd.DataFrame(rows)


def main(results: Path) -> None:
    """Print the costs of rules, and the bytes of files a simulation."""
    simulations, datasets = 0, [results / "study.nc", results / "pool.nc"]
    datasets = [file for file in datasets if file.exists()]
    for file in datasets:
        with reading_netcdf(file) as study:
            simulations += int(study.sizes["case"] * study.sizes["realization"])
    print(f"{results}: {simulations} simulations")
    print(costs(results, simulations).round(3).to_string(index=False, na_rep=""))
    blocks = [file for part in ("cases", "pool") for file in (results / part).glob("*.nc")]
    for kind, files in (("blocks", blocks), ("study.nc, pool.nc", datasets)):
        size = sum(file.stat().st_size for file in files) / simulations
        print(f"{kind}: {size:.0f} bytes a simulation")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="results folder, such as results/paper")
    main(parser.parse_args().results)
