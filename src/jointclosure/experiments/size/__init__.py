"""The scale effect: nested patches of the same walls, closed at several sizes and spacings."""

from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd

from jointclosure.config.configuration import Configured
from jointclosure.config.typed import Grid, SizeDesign
from jointclosure.ensemble.cases import base_case
from jointclosure.ensemble.points import Point
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.experiments import Design, Experiment, Tables
from jointclosure.experiments.size.scaling import collapse_table
from jointclosure.experiments.size.table import (
    GEOMETRY,
    READ,
    barton_bandis_table,
    exponent_table,
    runs_of,
    size_table,
)
from jointclosure.plotting.size import size_figure

TABLES = ("size", "size_exponents", "size_collapse", "size_barton_bandis")


def size_design(configured: Configured) -> Design:
    """A job for each rock and spectrum: all patches of all walls at all spacings."""
    configuration = configured.typed
    design, base = configuration.size, configuration.grid
    assert design is not None  # the section is there
    finest, block = design.spacing[0], range(configuration.study.realizations)
    whole = round(design.patch[-1] / finest)
    jobs = {}
    for rock, of_rock in configuration.rocks.items():
        case = base_case(rock, of_rock)
        for name, spectrum in design.spectra.items():
            points = []
            for patch, spacing in sizes_of(design, base.spacing):
                cells = round(patch / spacing)
                own = configuration._replace(
                    grid=Grid(cells, cells, spacing),
                    surface=configuration.surface._replace(**spectrum._asdict()),
                )
                settings = closure_settings(own, case, surface_settings(own, case, block))
                for position in range(round(design.patch[-1] / patch)):
                    points.append(
                        Point(
                            {"rock": rock, "spectrum": name, "patch": patch, "spacing": spacing}
                            | {"position": position},
                            settings,
                            "nested",
                            {"whole": [whole, finest], "base": base.spacing, "position": position},
                        )
                    )
            jobs[f"{rock}.{name}"] = points
    parameters = {
        "base": [base.cells_x * base.spacing, base.spacing],
        "spectra": {name: each.roll_off for name, each in design.spectra.items()},
        "rocks": {
            name: [rock.jrc, rock.intact.compressive_strength, rock.max_normal_stress]
            for name, rock in configuration.rocks.items()
        },
        "strength_ratio": configuration.output.wall_strength_ratio,
    }
    return Design(jobs, TABLES, ("size",), parameters)


def sizes_of(design: SizeDesign, base: float) -> Iterator[tuple[float, float]]:
    """Patches and spacings [m] that are closed: of few cells, or at the base's spacing."""
    for patch in design.patch:
        for spacing in design.spacing:
            if round(patch / spacing) <= design.most_cells or spacing == base:
                yield patch, spacing


def size_tables(joints: pd.DataFrame, parameters: Mapping[str, Any]) -> Tables:
    """Ratios to the base's joints, powers, scalings, and the law of Barton and Bandis."""
    roll_offs = parameters["spectra"]
    side, spacing = parameters["base"]
    runs, base = runs_of(joints, list(roll_offs)), (side, spacing)
    found = (
        size_table(runs, base),
        exponent_table(runs, base),
        collapse_table(runs, roll_offs),
        barton_bandis_table(runs, base, parameters["rocks"], parameters["strength_ratio"]),
    )
    return dict(zip(TABLES, found, strict=True))


EXPERIMENT = Experiment(
    title="what patch length and grid spacing do",
    quantities=(*READ, *GEOMETRY),
    design=size_design,
    tabulate=size_tables,
    draw=lambda name, tables, parameters: size_figure(tables[name]),
)
