"""Coverage of the ranges of `jointclosure close`: do they contain the results of the true walls?

Pairs of known truth: walls are synthesised at half the spacing of the scans. The upper scan is
rotated by up to 7 degrees and tilted by up to 3. Both scans have white noise of 0 to 15 um, and 5 %
of the heights are missing, half of them in holes. Three in five pairs mate beyond 0.5 to 4 mm and
are registered. The others mate beyond 3 to 10 mm, or are independent, and stay as scanned. JRC
(5 to 15), rock, stress (3, 5 or 8 MPa), spacing and size (32 to 46 cells a side) are drawn too.
Pairs from number `ROUGH` on have rough walls and unequal grids: heights 0.8 to 1.4 times those of a
JRC of 20 (the largest of the relation that is used), a rotation of up to 45 degrees, a tilt of up
to 8, and a lower scan whose points are 0.7 to 1 times as far apart as those of the upper one.

The truth of a range is the result of the true walls, without noise and missing heights, at the true
position, on the cells of the registered pair, and with the usual choices of the model. That of the
range with other choices is the result of the same walls with random choices: peak modulus ratio
and base radius uniform in their logarithm over `jointclosure.parameters.PLAUSIBLE`, either
choice of soft peaks, and the usual spacing or twice as much. Grids cannot be finer than the scans.

    .venv/bin/python -m benchmarks.range_coverage [--first 2000] [--pairs 60] [--output FOLDER]

Results that the output has are not computed again. A pair takes about a minute of a core.
"""

import argparse
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import scipy
import xarray as xr

import jointclosure as jc
from benchmarks.registration import Truth
from jointclosure.ensembles.quantities import CURVES, HEADINGS
from jointclosure.joint.result_tables import columns_of, stress_table
from jointclosure.joint.simulation import simulate_walls
from jointclosure.joint.status import LOADING
from jointclosure.statistics.randomness import generator, seed_of
from jointclosure.storage.files import write_csv
from jointclosure.storage.provenance import write_origin
from jointclosure.uncertainty.budget import ROUNDING
from jointclosure.uncertainty.ranged_results import (
    CLOSURE_NET,
    CONTACT,
    KNI,
    RESIDUAL_NET,
    STIFFNESS,
    VM,
    results_of,
)
from jointclosure.uncertainty.ranges import WIDER
from jointclosure.uncertainty.scanned_joint import ClosedJoint
from jointclosure.uncertainty.sources import ALL, MULTIPLE, sources_of
from jointclosure.uncertainty.tested_domain import TESTED, Domain
from jointclosure.uncertainty.variants import Variant, variants_of
from jointclosure.walls.gridding import usual_grid_spacing

RESULTS = (CLOSURE_NET, RESIDUAL_NET, STIFFNESS, KNI, VM, "mean_aperture_at_max_mm", CONTACT)
"""Results of a cycle whose ranges are judged."""
ALONG = ("normal_stiffness_net_MPa_per_mm", "mean_aperture_mm", "transmissivity_m2_per_s")
"""Curves on loading whose bands are judged."""
SHARES_OF_MAXIMUM = (0.25, 0.5, 1.0)  # stresses at which they are judged
HELD = 0.9  # probability that a range is to have
RESAMPLES = 400  # of the pairs, for standard errors
CHOICES = 2  # random choices of the model for each pair
USUAL, CHOSEN = "usual", "with choices"
SMOOTH = Domain(rotation=7.0, tilt=3.0, noise=TESTED.noise, jrc=15.0)
"""Largest rotation, tilt, noise and JRC of the pairs below number `ROUGH`."""
LEAST_JRC = 5.0
STEEPEST = 1.4
"""Largest factor of the heights of rough pairs, over those of a JRC of 20."""
ROUGH = 6000
"""Number of the first pair of rough walls and unequal grids, of up to the `TESTED` values."""


def inputs(number: int) -> tuple[dict, jc.Rock, float]:
    """Return the arguments of a pair's `Truth`, its rock and its maximum stress [Pa]."""
    random = generator(seed_of(59, "coverage", number))
    cell = 1e-3 * random.choice([0.125, 0.25, 0.25, 0.3])
    cells = int(random.integers(32, 47)) * round(usual_grid_spacing(cell) / cell)
    stated = {
        "cell": cell, "cells": cells, "cloud": False, "over": False,
        "rotation": random.uniform(-SMOOTH.rotation, SMOOTH.rotation),
        "tilt": random.uniform(0.0, SMOOTH.tilt),
        "noise": 1e-6 * random.uniform(0.0, 1e6 * SMOOTH.noise),
        "jrc": random.uniform(LEAST_JRC, SMOOTH.jrc),
        "mating": 0.5e-3 * 8.0 ** random.random(),
    }  # fmt: skip
    rock = jc.Rock(
        youngs_modulus=1e9 * random.uniform(20.0, 80.0),
        poisson_ratio=random.uniform(0.15, 0.3),
        compressive_strength=1e6 * random.uniform(60.0, 200.0),
    )
    stress = 1e6 * random.choice([3.0, 5.0, 8.0])
    if number >= ROUGH:
        stated |= {
            "jrc": 20.0,
            "steepness": random.uniform(0.8, STEEPEST),
            "rotation": random.uniform(-TESTED.rotation, TESTED.rotation),
            "tilt": random.uniform(0.0, TESTED.tilt),
            "lower_cell": cell * random.uniform(0.7, 1.0),
        }
    if number % 5 >= 3:  # too different from each other to be registered
        mating = None if number % 2 else 1e-3 * random.uniform(3.0, 10.0)
        stated |= {"rotation": 0.0, "tilt": 0.0, "mating": mating}
    return stated, rock, stress


def closed(number: int) -> tuple[Truth, ClosedJoint]:
    """Return the truth of a pair, and the joint of its scans (by `close`) with its ranges."""
    stated, rock, stress = inputs(number)
    truth = Truth(number, **stated)
    shift = None
    if not stated["rotation"]:
        truth.own = truth.middle
        shift = "scanned"  # in the frame of the lower scan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        joint = jc.close(
            *truth.scans(), rock=rock, max_normal_stress=stress, flow=True, workers=1,
            spacing=usual_grid_spacing(truth.cell), orientation="common_frame", shift=shift,
        )  # fmt: skip
    return truth, joint


def truths(number: int, truth: Truth, joint: ClosedJoint) -> list[tuple[str, xr.Dataset]]:
    """Simulate the true walls with the usual choices of the model, and with random ones.

    Returns `USUAL` or `CHOSEN`, and the history, of each.
    """
    walls = truth.walls(joint.pair)
    conditions = joint.conditions
    variants = [Variant(USUAL, "", conditions)]
    sources = {
        name: source._replace(
            varied=True, kind="choice" if source.kind == MULTIPLE else source.kind
        )
        for name, source in sources_of(conditions, walls[0].shape).items()
        if not source.varied
    }
    drawn = variants_of(conditions, sources, CHOICES, seed_of(2, number))
    variants += [variant._replace(source=CHOSEN) for variant in drawn if variant.source == ALL]
    return [
        (variant.source, simulate_walls(*variant.walls(*walls, None), variant.conditions))
        for variant in variants
    ]


def compared(number: int) -> list[dict]:
    """Return the ranges of a pair beside the true results, a row for each."""
    truth, joint = closed(number)
    assert joint.budget is not None
    curves = joint.curves
    ranges = joint.budget.ranges
    levels = np.sort(curves.normal_stress_MPa.unique())
    at = [levels[np.abs(levels - share * levels[-1]).argmin()] for share in SHARES_OF_MAXIMUM]
    places = ["cycle", "branch", "normal_stress_MPa"]
    bands = curves.set_index(places)
    about = {
        "number": number,
        "noise_um": 1e6 * truth.about["noise"],
        "cells": joint.pair.upper.size,
    }
    about |= {"mating_mm": 1e3 * (truth.about["mating"] or np.nan)}
    is_registered = joint.pair.motion.covariance.any()
    width = joint.pair.mismatch_wavelengths if is_registered else np.inf
    about |= {"width_in_mismatch_wavelengths": width}
    rows = []
    for kind, history in truths(number, truth, joint):
        table = results_of(history).set_index("cycle")
        true_curves = stress_table(history, 1e6 * levels).set_index(places)
        low, high = ("low", "high") if kind == USUAL else WIDER
        for cycle in table.index:
            of_cycle = about | {"truth": kind, "cycle": cycle}
            for name in RESULTS:
                row = ranges.loc[cycle, name]
                numbers = {"best": row.best, "low": row[low], "high": row[high]}
                numbers |= {"true": table.loc[cycle, name]}
                rows.append(of_cycle | {"quantity": name, "part": np.nan} | numbers)
            if kind != USUAL:  # bands have no range with other choices
                continue
            for name in ALONG:
                ends = columns_of(curves, name)
                for part, stress in zip(SHARES_OF_MAXIMUM, at, strict=True):
                    place = cycle, LOADING, stress
                    values = (*bands.loc[place, ends], true_curves.loc[place, name])
                    numbers = dict(zip(("best", "low", "high", "true"), values, strict=True))
                    rows.append(of_cycle | {"quantity": name, "part": part} | numbers)
    return rows


def on_scale(table: pd.DataFrame) -> pd.DataFrame:
    """Return the numbers of a table of ranges as logarithms; those of shares as log odds."""
    numbers = table[["true", "best", "low", "high"]].astype(float)
    share = table.quantity == CONTACT
    numbers[share] = numbers[share] / (1.0 - numbers[share])
    with np.errstate(divide="ignore"):
        return np.log(numbers)


def coverage(table: pd.DataFrame) -> pd.DataFrame:
    """Tabulate shares of truths in their ranges, and widths over those that would hold 90 %.

    On the scale of logarithms, or of log odds, a truth departs from the middle of its range by a
    multiple of half of the width. The width that is needed is the width times the 90 % quantile of
    these multiples. The 95 % interval of the share in the range is exact, with a count for each
    pair; that of the width is from resampled pairs. ``below`` and ``above`` are the shares of
    truths on either side. ``half_width``, ``error`` (of the joint that was simulated) and
    ``error_of_middle`` are medians of their sizes on this scale.
    """
    known = table[(table.true > 0.0) & (table.high > table.low) & (table.low > 0.0)]
    # in later cycles nothing remains
    known = known[(known.quantity != RESIDUAL_NET) | (known.best > ROUNDING)]
    scaled = on_scale(known)
    middle = 0.5 * (scaled.low + scaled.high)
    half = 0.5 * (scaled.high - scaled.low)
    known = known.assign(
        inside=known.true.between(known.low, known.high),
        departure=((scaled.true - middle) / half).abs(),
        half_width=half,
        error=(scaled.best - scaled.true).abs(),
        error_of_middle=(middle - scaled.true).abs(),
    )
    random = generator(seed_of(3, "coverage"))
    rows = []
    for place, part in known.groupby(["truth", "quantity", "part", "cycle"], dropna=False):
        by_pair = part.groupby("number")
        inside = by_pair.inside.mean().to_numpy()
        pairs = [departure.to_numpy() for _, departure in by_pair.departure]
        drawn = random.integers(len(pairs), size=(RESAMPLES, len(pairs)))
        needed = [np.quantile(np.concatenate([pairs[n] for n in row]), HELD) for row in drawn]
        row = dict(zip(("truth", "quantity", "part", "cycle"), place, strict=True))
        row["result"] = HEADINGS[name] if (name := row["quantity"]) in HEADINGS else CURVES[name][0]
        row |= {"pairs": len(pairs), "inside": inside.mean()}
        test = scipy.stats.binomtest(round(inside.sum()), len(pairs))
        row["inside_low"], row["inside_high"] = test.proportion_ci(method="exact")
        row |= {"below": (part.true < part.low).mean(), "above": (part.true > part.high).mean()}
        row["width_over_needed"] = 1.0 / np.quantile(part.departure, HELD)
        row["width_low"], row["width_high"] = 1.0 / np.quantile(needed, [0.975, 0.025])
        row |= {name: part[name].median() for name in ("half_width", "error", "error_of_middle")}
        rows.append(row)
    return pd.DataFrame(rows)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--pairs", type=int, default=60)
    parser.add_argument("--first", type=int, default=2000)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/range_coverage"))
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    stored = options.output / "ranges.csv"
    rows = pd.read_csv(stored).to_dict("records") if stored.exists() else []
    for number in range(options.first, options.first + options.pairs):
        if any(row["number"] == number for row in rows):
            continue
        try:
            rows += compared(number)
        except jc.InputError as error:  # such as an ambiguous fit
            print(number, error, flush=True)
            continue
        write_csv(pd.DataFrame(rows), stored)
        print(number, "closed", flush=True)
    result = coverage(pd.DataFrame(rows)).assign(tried=options.pairs)
    write_csv(result, options.output / "coverage.csv")
    write_origin(options.output, f"--first {options.first} --pairs {options.pairs}")
    print(result.round(3).to_string(index=False))


if __name__ == "__main__":
    main()
