"""Experiment on the scale effect: nested patches of the same walls, at many sizes and spacings."""

from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from jointclosure.engine.points import Point
from jointclosure.engine.quantities import COLUMNS, titles_of_cycles
from jointclosure.engine.settings import Grid
from studies.frame.config.configuration import Configured
from studies.frame.config.typed import SizeDesign
from studies.frame.ensemble.cases import base_case
from studies.frame.experiments import Design, Experiment, Tables, settings_of
from studies.frame.panels import Column, Row, panels
from studies.size.scaling import collapse_table
from studies.size.table import (
    GEOMETRY,
    READ,
    barton_bandis_table,
    exponent_table,
    runs_of,
    size_table,
)

SHOWN = (
    ("max_closure_seated_net", 1),
    ("max_closure_net", 1),
    ("residual_closure_seated_net", 1),
    ("max_closure_seated_net", 2),
    ("stiffness_net", 2),
)
"""Quantity and cycle of each row of the figure."""


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
        "titles": {
            name: f"H {spectrum.hurst:g}, "
            + (f"roll-off {1e3 * spectrum.roll_off:g} mm" if spectrum.roll_off else "no roll-off")
            for name, spectrum in design.spectra.items()
        },
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


def size_figure(table: pd.DataFrame, parameters: Mapping[str, Any]) -> Figure:
    """Draw ratios of the first rock to the joints of the base; a power law is a straight line."""
    table = table[table.rock == table.rock.iloc[0]]
    rows = [
        Row(f"ratio of {title}", part, f"{column}_ratio", f"{column}_error", {"yscale": "log"})
        for (name, cycle), title in titles_of_cycles(*SHOWN).items()
        for column, part in [(COLUMNS[name][0], table[table.cycle == cycle])]
    ]
    side, spacing = (
        table[name].iloc[(table[name] - 1e3 * base).abs().argmin()]
        for name, base in zip(("patch_mm", "spacing_mm"), parameters["base"], strict=True)
    )
    columns = [
        Column("patch_mm", "spectrum", {"spacing_mm": spacing}, "log", f"spacing {spacing:g} mm"),
        Column("spacing_mm", "spectrum", {"patch_mm": side}, "log", f"patch {side:g} mm"),
    ]
    return panels(rows, columns, {"spectrum": parameters["titles"]}, reference=1.0)


EXPERIMENT = Experiment(
    title="effects of patch length and grid spacing",
    quantities=(*READ, *GEOMETRY),
    design=size_design,
    tabulate=size_tables,
    draw=lambda name, tables, parameters: size_figure(tables[name], parameters),
)
