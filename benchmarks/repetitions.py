"""Processor time of the tables that redraw a study, on a finished study of the paper.

    python benchmarks/repetitions.py results/paper --repetitions 4000

It prints the processor time of each part. With ``--tables FOLDER`` the tables are written, to be
compared with those of another version. Other work on the machine lengthens the processor time:
compare versions in turn, within the same minutes.
"""

import argparse
import sys
import time
from pathlib import Path

import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1]))

from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv, write_csv
from studies.frame.yaml_files import PAPER_TABLE_3
from studies.paper.judged_claims import Evidence, judge_claims
from studies.paper.predictive import joint_table, predictive, predictive_table

ROOT_SEED = 20200827
SIGNIFICANCE = 0.05


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="folder with study.nc and pool.nc")
    parser.add_argument("--repetitions", type=int, default=4000, help="of the study")
    parser.add_argument("--tables", type=Path, help="folder to which the tables are written")
    options = parser.parse_args()
    study = xr.load_dataset(options.results / "study.nc")
    pool = xr.load_dataset(options.results / "pool.nc")
    paper = read_csv(PAPER_TABLE_3)
    design = Design(study.sizes["realization"], SIGNIFICANCE)
    seconds = {}

    start = time.process_time()
    lengths = predictive(pool, design, options.repetitions, ROOT_SEED)
    seconds["lengths of repetitions"] = time.process_time() - start

    start = time.process_time()
    tables = {"table_3_predictive": predictive_table(lengths, paper)}
    tables["table_3_joint_tests"] = joint_table(lengths, paper)
    seconds["tables of repetitions"] = time.process_time() - start

    start = time.process_time()
    evidence = Evidence(study, pool, design, options.repetitions, ROOT_SEED)
    tables["claims"], tables["claim_margins"] = judge_claims(evidence, paper)
    seconds["claims"] = time.process_time() - start

    for name, each in seconds.items():
        print(f"{name:24} {each:7.2f} s")
    print(f"{'together':24} {sum(seconds.values()):7.2f} s")
    if options.tables:
        options.tables.mkdir(parents=True, exist_ok=True)
        for name, table in tables.items():
            write_csv(table, options.tables / f"{name}.csv")


if __name__ == "__main__":
    main()
