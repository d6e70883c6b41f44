"""Print the number of hard cases that hold and those that do not; fail if one does not."""

import sys

from jointclosure.storage.files import read_csv


def main(path: str) -> int:
    """Print the count; 0 where all hold, else 1."""
    table = read_csv(path)
    for row in table[~table.holds].itertuples():
        print(f"{row.name} does not hold: {row.failed}")
    for row in table[table.within_budget.eq(False)].itertuples():
        print(f"{row.name} took {row.seconds} s of {row.budget_s} s, which no requirement forbids")
    print(f"{int(table.holds.sum())} of {len(table)} hard cases hold")
    return 0 if table.holds.all() else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
