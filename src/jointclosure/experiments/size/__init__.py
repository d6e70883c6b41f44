"""Experiment on the scale effect: nested patches of the same walls, at many sizes and spacings."""

from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd

from jointclosure.config.configuration import Configured
from jointclosure.config.typed import Grid, SizeDesign
from jointclosure.engine.points import Point
from jointclosure.ensemble.cases import base_case
from jointclosure.experiments import Design, Experiment, Tables, settings_of
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


def size_design(configured: Configured) -> Design:
    """Make a job for each rock and spectrum: all patches of all walls at all spacings."""
    configuration = configured.typed
    design, base = configuration.size, configuration.grid
    assert design is not None  # the section is there
    finest, longest = design.spacing[0], design.patch[-1]
    jobs: dict[str, list[Point]] = {}
    for rock, of_rock in configuration.rocks.items():
        case = base_case(rock, of_rock)
        for name, spectrum in design.spectra.items():
            points = jobs[f"{rock}.{name}"] = []
            for patch, spacing in sizes_of(design, base.spacing):
                cells = round(patch / spacing)
                sized = configuration._replace(grid=Grid(cells, cells, spacing))
                settings = settings_of(sized, case, **spectrum._asdict())
                at = {"rock": rock, "spectrum": name, "patch": patch, "spacing": spacing}
                walls = {"whole": [round(longest / finest), finest], "base": base.spacing}
                for position in range(round(longest / patch)):
                    place = {"position": position}
                    points.append(Point(at | place, settings, "nested", walls | place))
    parameters = {
        "base": [base.cells_x * base.spacing, base.spacing],
        "spectra": {name: spectrum.roll_off for name, spectrum in design.spectra.items()},
        "rocks": {
            name: [rock.jrc, rock.intact.compressive_strength, rock.max_normal_stress]
            for name, rock in configuration.rocks.items()
        },
        "strength_ratio": configuration.output.wall_strength_ratio,
    }
    tables = ("size", "size_exponents", "size_collapse", "size_barton_bandis")
    return Design(jobs, tables, ("size",), parameters)


def sizes_of(design: SizeDesign, base: float) -> Iterator[tuple[float, float]]:
    """Generate the patches and spacings [m] with few cells, or at the spacing of the base."""
    for patch in design.patch:
        for spacing in design.spacing:
            if round(patch / spacing) <= design.most_cells or spacing == base:
                yield patch, spacing


def size_tables(joints: pd.DataFrame, parameters: Mapping[str, Any]) -> Tables:
    """Return all tables by name."""
    roll_offs, (side, spacing) = parameters["spectra"], parameters["base"]
    runs, base = runs_of(joints, list(roll_offs)), (side, spacing)
    return {
        "size": size_table(runs, base),
        "size_exponents": exponent_table(runs, base),
        "size_collapse": collapse_table(runs, roll_offs),
        "size_barton_bandis": barton_bandis_table(
            runs, base, parameters["rocks"], parameters["strength_ratio"]
        ),
    }


EXPERIMENT = Experiment(
    title="effects of patch length and grid spacing",
    quantities=(*READ, *GEOMETRY),
    design=size_design,
    tabulate=size_tables,
    draw=lambda name, tables, parameters: size_figure(tables[name]),
)
