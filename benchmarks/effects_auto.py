"""Selected effects at random conditions, against the full model and against the best scene.

Closes joints of random rock, roughness, stress and size (ranges of effects.yaml) in every
well-posed scene, selects effects by `effects: auto` on the same closures, and reports the time
saved beside that of the best scene, the regret, the share within the tolerance, and the effectivity
index. Run as `python benchmarks/effects_auto.py --scenes 24 --tolerances 0.05 --seed 7`.
"""

import os

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
os.environ.update(dict.fromkeys(("MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))

import argparse
from pathlib import Path

import pandas as pd
from yardstick import machine, show

from jointclosure.storage.figures import save_figure
from jointclosure.storage.text import write_csv
from studies.effects.figures import choice_figure, region_figure
from studies.effects.validation import validate, validation_settings, validation_summary
from studies.frame.config.configuration import configured, merged, merged_study
from studies.frame.config.files import ConfigurationError

STUDY = Path(__file__).parents[1] / "studies/effects/effects.yaml"


def main(arguments) -> None:
    """Print the summary, and write tables and figures."""
    design = {
        "scenes": arguments.scenes,
        "realizations": arguments.surfaces,
        "tolerances": arguments.tolerances,
    }
    changes = {"study": {"root_seed": arguments.seed}, "ablation": {"validation": design}}
    try:
        study = configured(merged(merged_study(STUDY), changes)).typed
    except ConfigurationError as error:
        raise SystemExit(str(error)) from None
    if arguments.output:
        arguments.output.mkdir(parents=True, exist_ok=True)
    print(machine(), flush=True)
    rows: list[pd.DataFrame] = []
    for number in range(arguments.scenes):
        rows.append(validate(validation_settings(study), number))
        print(f"conditions {number + 1} of {arguments.scenes}", flush=True)
        if arguments.output:  # after each scene, as the next may take minutes
            write_csv(pd.concat(rows), arguments.output / "effects_auto.csv")
    present(pd.concat(rows, ignore_index=True), arguments.output)


def present(table: pd.DataFrame, output: Path | None) -> None:
    """Print the summary of a table of scenes, and write it and the figures."""
    show(__doc__.splitlines()[0], validation_summary(table), output, "effects_auto_summary")
    if output:
        save_figure(choice_figure(table), output / "effects_auto.png")
        save_figure(region_figure(table), output / "effects_regions.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=24, help="number of random conditions")
    parser.add_argument("--tolerances", type=float, nargs="+", default=[0.02, 0.05, 0.2])
    parser.add_argument("--seed", type=int, default=1, help="root seed of conditions and surfaces")
    parser.add_argument("--surfaces", type=int, default=10, help="pairs of walls of each")
    parser.add_argument("--output", type=Path, help="folder for tables and figures")
    main(parser.parse_args())
