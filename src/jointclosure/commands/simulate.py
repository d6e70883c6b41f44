"""`jointclosure simulate`: close one joint."""

import argparse
import time
from pathlib import Path
from typing import Any

import xarray as xr

from jointclosure.commands import COMMANDS
from jointclosure.config.configuration import Configured, configured, merged, merged_study
from jointclosure.config.files import value_of
from jointclosure.config.typed import Configuration
from jointclosure.ensemble.cases import cases_of
from jointclosure.ensemble.closing import close_walls
from jointclosure.ensemble.settings import Case
from jointclosure.ensemble.slices import closure_settings, surface_settings
from jointclosure.inputs import InputError
from jointclosure.parameters import Effects
from jointclosure.progress import bar, duration
from jointclosure.protocol import FAILURE, LOADING
from jointclosure.storage.figures import save_figure
from jointclosure.storage.netcdf import write_netcdf
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import read_csv
from jointclosure.surface.synthesis import wall_pair

_OF_ROCK = {
    "youngs_modulus": "youngs_modulus_GPa",
    "poisson_ratio": "poisson_ratio",
    "strength": "compressive_strength_MPa",
    "jrc": "jrc",
    "stress": "max_normal_stress_MPa",
}
"""Options that say what a configuration says of a rock."""
_UNNAMED = "rock"
"""Name of a rock that is given by its properties."""
_PICTURES = (".png", ".pdf", ".svg")
_FIRST_LOADING = 5.0
"""Time of the first loading over that of a later cycle, for the progress bar: 4 to 10 measured on
joints of the paper's size; the first unloading takes a third of a cycle."""

_EXAMPLES = """examples:
  jointclosure simulate --rock dolerite --stress 10
  jointclosure simulate --youngs-modulus 60 --poisson-ratio 0.22 --strength 180 --jrc 10 --stress 15
  jointclosure simulate --config config/my_rock.yaml --rock granite --picture joint.png
  jointclosure simulate --rock dolerite --jrc 12 --cells 64 --seed 7 --output joint.nc
  jointclosure simulate --rock slate --without breakage gouge --cycles 1
  jointclosure simulate --rock slate --stress 10 --set numerics.breakage=resolved

What is not given is as in the configuration, where every key is explained (config/README.md).
"""


def add_to(commands) -> None:
    """Declare the command and its arguments."""
    command = commands.add_parser(
        "simulate",
        help=COMMANDS["simulate"],
        description="Press two random walls together and release them, and print how far they\n"
        "close. The rock is one of a configuration, by its name, or given by its properties.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    rock = command.add_argument_group("rock")
    rock.add_argument("--rock", metavar="NAME", help="one of the configuration's rocks")
    rock.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="study whose rocks and other keys are used, over the paper's",
    )
    rock.add_argument("--youngs-modulus", type=float, metavar="GPa", help="Young's modulus E")
    rock.add_argument("--poisson-ratio", type=float, metavar="NU", help="Poisson's ratio")
    rock.add_argument("--strength", type=float, metavar="MPa", help="compressive strength sigma_c")
    joint = command.add_argument_group("joint")
    joint.add_argument("--jrc", type=float, metavar="JRC", help="joint roughness coefficient")
    joint.add_argument("--cells", type=_cells, metavar="N", help="cells: 100, or 200x100 (x by y)")
    joint.add_argument("--spacing", type=float, metavar="mm", help="grid spacing")
    joint.add_argument(
        "--seed", type=int, default=1, metavar="N", help="which random walls (default 1)"
    )
    load = command.add_argument_group("load")
    load.add_argument("--stress", type=float, metavar="MPa", help="maximum normal stress")
    load.add_argument("--cycles", type=int, metavar="N", help="load-unload cycles")
    load.add_argument(
        "--seating", type=float, metavar="MPa", help="stress from which seated closures count"
    )
    model = command.add_argument_group("model")
    model.add_argument(
        "--without",
        nargs="+",
        choices=Effects._fields,
        default=[],
        metavar="EFFECT",
        help=f"effects to leave out, of {', '.join(Effects._fields)}",
    )
    model.add_argument(
        "--set",
        nargs="+",
        type=_setting,
        default=[],
        metavar="KEY=VALUE",
        help="any other key of the configuration, as in choices.largest_radius_mm=20",
    )
    results = command.add_argument_group("results")
    results.add_argument("--output", type=Path, metavar="FILE.nc", help="netCDF of all steps")
    results.add_argument(
        "--picture", type=Path, metavar="FILE.png", help="closure curve (png, pdf or svg)"
    )
    command.set_defaults(run=run)


def run(arguments) -> int:
    """Close the joint; 1 where the simulation failed."""
    _check_destination(arguments.output, (".nc",))
    _check_destination(arguments.picture, _PICTURES)
    if arguments.picture:  # drawing takes a second to load, and an extra that may be missing
        from jointclosure.plotting.joint import closure_curve
    settings = _settings(arguments)
    configuration = settings.typed
    case, grid = cases_of(configuration)[0], configuration.grid
    about = (
        f"{configuration.rocks[case.rock].title}, JRC {case.jrc:g}, {grid.cells_x} x "
        f"{grid.cells_y} cells of {1e3 * grid.spacing:g} mm, seed {arguments.seed}"
    )
    cycles = configuration.study.cycles
    print(f"{about}: {1e-6 * case.max_normal_stress:g} MPa, {cycles} cycles")
    start = time.perf_counter()
    closed = _close(configuration, case, arguments.seed)
    print(_summary(closed))
    status = int(closed.status)
    print(f"{_status_text(closed)}; {duration(time.perf_counter() - start)}")
    closed.attrs |= {"joint": about} | provenance(settings.keys)
    if arguments.output:
        write_netcdf(closed, arguments.output)
        print(f"wrote {arguments.output}")
    if arguments.picture:
        save_figure(closure_curve(closed, about), arguments.picture)
        print(f"wrote {arguments.picture}")
    return 1 if status >= FAILURE else 0


def _settings(arguments) -> Configured:
    """The whole configuration that the arguments describe, checked."""
    base = merged_study(*([arguments.config] if arguments.config else []))
    configured(base, read_csv)
    if arguments.rock and arguments.rock not in base["rocks"]:
        raise InputError(f"--rock {arguments.rock}: must be one of {', '.join(base['rocks'])}")
    if arguments.seed < 0:
        raise InputError(f"--seed {arguments.seed}: must be 0 or above")
    if base["rocks"].get(arguments.rock, {}).get("walls"):
        raise InputError(f"--rock {arguments.rock}: has scanned walls; this closes random ones")
    base["rocks"].setdefault(arguments.rock or _UNNAMED, {})["levels"] = {}
    return configured(merged(base, _changes(arguments), *arguments.set), read_csv)


def _changes(arguments) -> dict:
    """What the arguments change in a configuration."""
    given = {name: value for name, value in vars(arguments).items() if value is not None}
    own = {key: given[option] for option, key in _OF_ROCK.items() if option in given}
    if not arguments.rock:
        missing = ["--" + option.replace("_", "-") for option in _OF_ROCK if option not in given]
        if missing:
            raise InputError(f"without --rock: {', '.join(missing)} must be given")
        own["title"] = "Rock"
    if arguments.without:  # the rock's own settings go before the study's
        own["effects"] = dict.fromkeys(arguments.without, False)
    name = arguments.rock or _UNNAMED
    changes: dict = {
        "study": {"rocks": [name]},
        "rocks": {name: own},
        "grid": dict(zip(("cells_x", "cells_y"), given.get("cells", ()), strict=False)),
    }
    if "spacing" in given:
        changes["grid"]["spacing_mm"] = given["spacing"]
    if "cycles" in given:
        changes["study"]["cycles"] = given["cycles"]
    if "seating" in given:
        changes["seating_stress_MPa"] = given["seating"]
    return changes


def _close(configuration: Configuration, case: Case, seed: int) -> xr.Dataset:
    grid, cycles = configuration.grid, configuration.study.cycles
    surfaces = surface_settings(configuration, case, range(1))
    conditions = closure_settings(configuration, case, surfaces).conditions()
    surface = configuration.surface._asdict()
    walls = wall_pair(case.jrc, grid.shape, grid.spacing, seed, **surface)
    whole = _FIRST_LOADING + cycles - 1
    with bar("closing") as show:

        def report(cycle: int, branch: str, share: float) -> None:
            share = min(share, 1.0) if branch == LOADING else 1.0
            done = _FIRST_LOADING * share if cycle == 1 else _FIRST_LOADING + cycle - 2 + share
            show(done / whole, f"cycle {cycle} of {cycles}, {branch}")

        return close_walls(*walls, conditions, report)


def _summary(closed: xr.Dataset) -> str:
    seating = 1e-6 * closed.attrs["seating_stress_Pa"]
    columns = {
        "maximum": closed.max_closure,
        f"since {seating:g} MPa": closed.max_closure_seated,
        "at its end": closed.residual_closure,
    }
    frame = xr.Dataset({name: 1e3 * values for name, values in columns.items()}).to_dataframe()
    frame.index = [f"cycle {number}" for number in range(1, len(frame) + 1)]
    return "closure (mm)\n" + frame.to_string(float_format="{:.5f}".format)


def _status_text(closed: xr.Dataset) -> str:
    about, status = closed.status.attrs, int(closed.status)
    named = zip(about["flag_masks"], about["flag_meanings"].split(), strict=True)
    found = [name for mask, name in named if status & int(mask)]
    word = "failed" if status >= FAILURE else "success"
    return f"{word}{': ' + ', '.join(found) if found else ''}"


def _cells(text: str) -> tuple[int, int]:
    numbers = text.lower().split("x")
    if len(numbers) > 2 or not all(number.isdigit() for number in numbers):
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number, or two as in 200x100")
    return int(numbers[0]), int(numbers[-1])


def _setting(text: str) -> dict:
    """A nested setting from `section.key=value`."""
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise argparse.ArgumentTypeError(f"{text!r}: must be as in numerics.breakage=resolved")
    setting: Any = value_of(value)
    for part in reversed(key.split(".")):
        setting = {part: setting}
    return setting


def _check_destination(path: Path | None, suffixes: tuple[str, ...]) -> None:
    """Refuse what could not be written, before anything is computed."""
    if path is None:
        return
    if path.suffix not in suffixes:
        raise InputError(f"{path}: must end in {' or '.join(suffixes)}")
    if not path.parent.is_dir():
        raise InputError(f"{path}: there is no folder {path.parent}")
