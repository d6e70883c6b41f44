"""Mean closures, indifference intervals and verdicts of two studies. Surfaces with the same seeds
are compared in pairs.
"""

import argparse
from pathlib import Path

import pandas as pd

from jointclosure.storage.netcdf import read_netcdf
from jointclosure.storage.text import read_csv
from studies.commands.finished import existing, study_of
from studies.frame.ensemble import comparison


def declare(command: argparse.ArgumentParser) -> None:
    command.add_argument("first", type=Path, help="results folder, such as results/paper")
    command.add_argument("second", type=Path, help="results folder of the other study")
    what = "list all differences except in provenance and timing; fails if there is one"
    command.add_argument("--exact", action="store_true", help=what)


def run(arguments: argparse.Namespace) -> int:
    """Print the differences between two studies."""
    folders = arguments.first, arguments.second
    first, second = (read_netcdf(study_of(folder)) for folder in folders)
    if arguments.exact:
        messages = comparison.differences(first, second)
        print("\n".join(messages) or "identical except for provenance and timing")
        return 1 if messages else 0
    changes = comparison.closure_changes(first, second)
    print(comparison.surfaces_sentence(changes))
    print("\nMean closures, over the cases of each rock")
    print(comparison.by_rock(changes).round(4).to_string(index=False))
    tables = (read_csv(existing(folder / "tables/table_3_indifference.csv")) for folder in folders)
    intervals = comparison.interval_changes(*tables)
    if len(intervals):
        print("\nLength of the indifference intervals, with bootstrap confidence intervals")
        print(intervals.round(3).to_string(index=False, na_rep="–"))
    else:
        print("\nNo indifference interval in common")
    claims = (read_csv(existing(folder / "tables/claims.csv")) for folder in folders)
    both = (table.set_index("number").verdict for table in claims)
    verdicts = pd.DataFrame(dict(zip(("first", "second"), both, strict=True))).fillna("not judged")
    moved = verdicts[verdicts["first"] != verdicts["second"]]
    print(f"\nVerdicts that differ\n{moved.to_string()}" if len(moved) else "\nNo verdict differs")
    return 0
