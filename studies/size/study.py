"""Experiment on the scale effect: nested patches of the same walls, at many sizes and spacings.

Joints of one size scatter by a factor, so means are those of logarithms. The mean over the patches
of one size of a wall counts once, as these patches are not independent. A scaling is a product of
powers of size or roughness, by which closures and stiffness of one size predict those of another.
"""

import itertools
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import scipy
import xarray as xr
from matplotlib.figure import Figure

from jointclosure.ensembles.quantities import COLUMNS, titles_of_cycles
from jointclosure.joint.laws import barton_bandis, scaled_to
from jointclosure.joint.status import FAILURE
from jointclosure.statistics.number_texts import rounded
from jointclosure.statistics.standard_errors import Estimate, jackknife_error, mean_of
from jointclosure.walls import Walls
from jointclosure.walls.jrc import rms_slope, z2_of_jrc
from jointclosure.walls.planes import detrended
from studies.frame.cases import base_case
from studies.frame.configuration import Configuration
from studies.frame.experiments import Experiment, Tables, settings_of
from studies.frame.joint_tables import gridded
from studies.frame.keys import Grid
from studies.frame.panels import PanelColumn, Row, panels
from studies.frame.settings import ClosureSettings, Point, walls_of
from studies.size.section import SizeSection

GEOMETRY = ("rms_height", "rms_slope", "depth_5")
"""Quantities of the pristine walls."""
SCALINGS: dict[str, tuple[str, ...]] = {
    "none": (),
    "patch length": ("patch",),
    "spacing": ("spacing",),
    "patch length, spacing": ("patch", "spacing"),
    "longest wave, spacing": ("wave", "spacing"),
    "rms height": ("rms_height",),
    "rms height, spacing": ("rms_height", "spacing"),
    "rms height, rms slope": ("rms_height", "rms_slope"),
    "depth of 5 %": ("depth_5",),
    "depth of 5 %, spacing": ("depth_5", "spacing"),
}
"""Scalings that are tested, and the variables of which they are powers."""
JUDGED = (
    "max_closure",
    "max_closure_net",
    "max_closure_seated_net",
    "residual_closure_seated_net",
    "stiffness_net",
)
FEWEST_REALIZATIONS = 6
"""Smallest number of realisations with a quantity at every size for which a scaling is tested."""
BETWEEN = ("sizes", "sizes and spectra")
"""Joints that a scaling should make equal: sizes of one spectrum, or of all spectra."""


NUMBERS: tuple[str, ...] = ("removed_percent", "removed_error", "left_percent")
NUMBERS += ("largest_off_percent", "largest_off_error")


def mean_logs(run: xr.Dataset, name: str, cycle: int) -> xr.DataArray:
    """Compute logarithms of a quantity [SI], averaged over the patches of a wall; NaN if none."""
    values = run[name].sel(cycle=cycle) if "cycle" in run[name].dims else run[name]
    positive = values.where(values > 0.0)
    return positive.copy(data=np.log(positive.values)).mean("position")


def stack_conditions(
    run: xr.Dataset, roll_offs: Mapping[str, float | None], name: str, cycle: int
) -> xr.Dataset:
    """Stack logarithms over (condition, realization), of the realisations that have all of them.

    The logarithms are those of the quantity ``name`` (``response``) and of `GEOMETRY`. Conditions
    are spectrum, patch and spacing; they have their longest ``wave`` [m]. ``roll_offs`` [m] are by
    spectrum.
    """
    logs = {"response": name} | {of: of for of in GEOMETRY}
    over = xr.Dataset({of: mean_logs(run, one, cycle) for of, one in logs.items()})
    flat = over.stack(condition=("spectrum", "patch", "spacing"))  # noqa: PD013
    joints = flat.reset_index("condition").transpose("condition", "realization")
    joints = joints.dropna("condition", how="all", subset=["response"])
    joints = joints.dropna("realization", subset=["response"])
    roll_off = [roll_offs[spectrum] or np.inf for spectrum in joints.spectrum.values]
    return joints.assign(wave=np.minimum(joints.patch, np.array(roll_off)))


def predictors_of(joints: xr.Dataset, scaling: tuple[str, ...]) -> np.ndarray:
    """Return the logarithms (k, condition, realisation) of the variables of a scaling."""
    values = [joints[name].broadcast_like(joints.response).values for name in scaling]
    logs = [v if name in GEOMETRY else np.log(v) for name, v in zip(scaling, values, strict=True)]
    return np.array(logs).reshape(-1, *joints.response.shape)


class Collapse(NamedTuple):
    """Exponents of a scaling, and their effect on surfaces to which they were not fitted.

    ``removed`` is the share of the mean square spread between conditions that the scaling removes,
    and ``left`` the root of the spread that is left.
    """

    exponents: np.ndarray
    errors: np.ndarray
    removed: float
    removed_error: float
    left: float


def centred(logs: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """Subtract each surface's mean over its group from logarithms (..., condition, surface)."""
    answer = np.array(logs, dtype=float)
    for group in np.unique(groups):
        members = groups == group
        answer[..., members, :] -= answer[..., members, :].mean(axis=-2, keepdims=True)
    return answer


def exponents_of(predictors: np.ndarray, response: np.ndarray) -> np.ndarray:
    """Fit the exponents (k,) of centred predictors (k, condition, surface) by least squares."""
    if not len(predictors):
        return np.zeros(0)
    return np.linalg.lstsq(predictors.reshape(len(predictors), -1).T, response.ravel())[0]


def spreads(predictors: np.ndarray, response: np.ndarray) -> tuple[float, float]:
    """Return the mean square spread between conditions before and after scaling.

    Exponents are fitted to every second surface and tested on the others, and the reverse.
    Arguments are centred logarithms (k, condition, surface) and (condition, surface). The variance
    of the means over surfaces is subtracted, so that the result may be negative.
    """
    halves = np.arange(response.shape[1]) % 2
    both = []
    for half in (0, 1):
        fitted = halves != half
        tested = halves == half
        powers = exponents_of(predictors[..., fitted], response[:, fitted])
        rest = response[:, tested] - np.tensordot(powers, predictors[..., tested], axes=1)
        both.append([_mean_square(response[:, tested]), _mean_square(rest)])
    before, after = np.mean(both, axis=0).tolist()
    return before, after


def _mean_square(values: np.ndarray) -> float:
    noise = values.var(axis=1, ddof=1) / values.shape[1]
    return float(np.mean(values.mean(axis=1) ** 2 - noise))


def collapse_of(predictors: np.ndarray, response: np.ndarray) -> Collapse:
    """Fit exponents and find their effect, with jackknife errors; arguments as for `spreads`."""
    before, after = spreads(predictors, response)
    powers = []
    shares = []
    for kept in ~np.eye(response.shape[1], dtype=bool):
        one = predictors[..., kept], response[:, kept]
        powers.append(exponents_of(*one))
        first, second = spreads(*one)
        shares.append(1.0 - second / first)
    errors = np.array(list(map(jackknife_error, np.transpose(powers))))
    left = max(after, 0.0)
    removed = 1.0 - after / before, float(jackknife_error(shares))
    return Collapse(exponents_of(predictors, response), errors, *removed, float(np.sqrt(left)))


def collapse_table(
    runs: Mapping[str, xr.Dataset], roll_offs: Mapping[str, float | None]
) -> pd.DataFrame:
    """Compute by how much each scaling reduces the spread between sizes (`BETWEEN`).

    Scalings are tested on realisations to which they were not fitted. ``removed_percent`` is the
    share of the mean square spread that is removed, ``left_percent`` the rms of ratios to the mean.
    ``largest_off_percent`` is the rms error (over spectra and spacings) of the largest patch, when
    it is predicted by fits without it. Numbers are NaN if fewer than `FEWEST_REALIZATIONS` have the
    quantity at every size. ``roll_offs`` [m] are by spectrum.
    """
    rows = []
    for rock, run in runs.items():
        for reading, cycle in itertools.product(JUDGED, run.cycle.values.tolist()):
            joints = stack_conditions(run, roll_offs, reading, cycle)
            for between, scaling in itertools.product(BETWEEN, SCALINGS):
                groups = (
                    joints.spectrum.values
                    if between == "sizes"
                    else np.zeros(joints.sizes["condition"])
                )
                row = {"rock": rock, "reading": reading, "cycle": cycle}
                row |= {"between": between, "scaling": scaling}
                rows.append(row | _row(joints, groups, SCALINGS[scaling]))
    return pd.DataFrame(rows)


def _row(joints: xr.Dataset, groups: np.ndarray, names: tuple[str, ...]) -> dict:
    """Fit and test a scaling between the conditions of each group."""
    surfaces = joints.sizes["realization"]
    if surfaces < FEWEST_REALIZATIONS:
        return {"realizations": surfaces, "exponents": ""} | dict.fromkeys(NUMBERS, np.nan)
    predictors = predictors_of(joints, names)
    response = joints.response.values
    fit = collapse_of(centred(predictors, groups), centred(response, groups))
    every = np.arange(surfaces)
    given = (joints, predictors, groups, _largest(joints))
    off, *left_out = (
        _off(*given, chosen)
        for chosen in (every, *(np.delete(every, surface) for surface in every))
    )
    numbers = (fit.removed, fit.removed_error, fit.left, off, jackknife_error(left_out))
    powers = zip(names, fit.exponents, fit.errors, strict=True)
    return {
        "realizations": surfaces,
        "exponents": "; ".join(f"{name} {rounded(value, error)}" for name, value, error in powers),
    } | {name: 100.0 * number for name, number in zip(NUMBERS, numbers, strict=True)}


def _largest(joints: xr.Dataset) -> np.ndarray:
    """Return the places (2, n) of conditions with the largest patch, and the next smaller one."""
    conditions = joints[["spectrum", "spacing", "patch"]].to_dataframe().reset_index(drop=True)
    lengths = np.unique(joints.patch)[:-3:-1]
    last, other = (conditions[conditions.patch == length].reset_index() for length in lengths)
    return last.merge(other, on=["spectrum", "spacing"])[["index_x", "index_y"]].to_numpy().T


def _off(
    joints: xr.Dataset, predictors: np.ndarray, groups: np.ndarray, pairs: np.ndarray,
    surfaces: np.ndarray,
) -> float:  # fmt: skip
    """Compute the rms error [logarithm] of the largest patch, predicted by fits to smaller ones."""
    large, small = pairs
    response = joints.response.values
    squares = []
    smaller = np.flatnonzero(joints.patch < joints.patch.max())
    for half in (0, 1):
        fitted = surfaces[half::2]
        tested = surfaces[1 - half :: 2]
        few = np.ix_(smaller, fitted)
        powers = exponents_of(
            centred(predictors[:, few[0], few[1]], groups[smaller]),
            centred(response[few], groups[smaller]),
        )
        scaled = response[:, tested] - np.tensordot(powers, predictors[..., tested], axes=1)
        squares.append(np.mean((scaled[large] - scaled[small]).mean(axis=1) ** 2))
    return float(np.sqrt(np.mean(squares)))


READ = (*JUDGED, "kni_net", "vm_net")
"""Quantities that are read of each cycle."""
SHOWN = (
    ("max_closure_seated_net", 1),
    ("stiffness_net", 1),
    ("residual_closure_seated_net", 1),
    ("max_closure_seated_net", 2),
    ("stiffness_net", 2),
)
"""Quantity and cycle of each row of the figure."""


def nested(
    settings: ClosureSettings, whole: tuple[int, float], base: float, position: int
) -> Iterator[Walls]:
    """Generate plane-detrended patches (y, x) [m] of larger walls, at a position on the diagonal.

    The walls of a realisation are the same for all patches and spacings. ``whole`` is the number of
    cells along a side of the walls, and their spacing [m]. They have the Z2 of their JRC at the
    spacing ``base`` [m]. A coarser grid has every so many-th cell of the walls.
    """
    cells, finest = whole
    grid = settings.grid
    surface = settings.surface
    large = settings._replace(grid=grid._replace(cells_x=cells, cells_y=cells, spacing=finest))
    z2 = z2_of_jrc(settings.case.jrc, base, surface.hurst, surface.jrc_relation)
    coarse = round(base / finest)
    step = round(grid.spacing / finest)
    side = grid.cells_x * step
    part = slice(position * side, (position + 1) * side, step)
    for pair in walls_of(large):
        scaled = (wall * (z2 / rms_slope(wall[::coarse, ::coarse], base)) for wall in pair)
        upper, lower = (np.ascontiguousarray(detrended(wall[part, part])) for wall in scaled)
        yield upper, lower


def size_jobs(study: Configuration) -> dict[str, list[Point]]:
    """Make a job for each rock and spectrum: all patches of all walls at all spacings."""
    design = study.section(SizeSection)
    base = study.grid
    finest = design.spacing[0]
    longest = design.patch[-1]
    walls = {"whole": [round(longest / finest), finest], "base": base.spacing}
    jobs: dict[str, list[Point]] = {}
    for rock, (name, spectrum) in itertools.product(study.rocks, design.spectra.items()):
        points = jobs[f"{rock}.{name}"] = []
        for patch, spacing in sizes_of(design, base.spacing):
            cells = round(patch / spacing)
            grid = base._replace(cells_x=cells, cells_y=cells, spacing=spacing)
            sized = study._replace(grid=grid)
            settings = settings_of(sized, base_case(sized, rock), **dict(spectrum))
            at = {"rock": rock, "spectrum": name, "patch": patch, "spacing": spacing}
            points += [
                Point(at | place, settings, f"{__name__}:nested", walls | place)
                for place in ({"position": i} for i in range(round(longest / patch)))
            ]
    return jobs


def sizes_of(design: SizeSection, base: float) -> Iterator[tuple[float, float]]:
    """Generate patches and spacings [m] that have few enough cells, or the spacing ``base`` [m]."""
    for patch, spacing in itertools.product(design.patch, design.spacing):
        if round(patch / spacing) <= design.most_cells or spacing == base:
            yield patch, spacing


def runs_of(joints: pd.DataFrame, spectra: list[str]) -> dict[str, xr.Dataset]:
    """Arrange joints by rock over (spectrum, patch, spacing, position, realization, cycle)."""
    over = ("spectrum", "patch", "spacing", "position", "realization")
    runs = {}
    for rock, part in joints.groupby("rock", sort=False):
        run = gridded(part, over, (*READ, *GEOMETRY)).sel(spectrum=spectra)
        walls = {name: run[name].isel(cycle=0, drop=True) for name in GEOMETRY}
        runs[str(rock)] = run.assign(walls)
    return runs


def _spectra(runs: Mapping[str, xr.Dataset]) -> Iterator[tuple[dict, xr.Dataset]]:
    """Generate the joints of each rock and spectrum."""
    for rock, run in runs.items():
        for spectrum in run.spectrum.values.tolist():
            yield {"rock": rock, "spectrum": spectrum}, run.sel(spectrum=spectrum)


def _at(logs: xr.DataArray, size: tuple[float, float]) -> np.ndarray:
    return logs.sel(patch=size[0], spacing=size[1], method="nearest").values


def _ratio(logs: np.ndarray, base: np.ndarray) -> Estimate:
    """Compute the geometric mean of ratios from logarithms (n,) and (n,) of the same walls."""
    known = (logs - base)[np.isfinite(logs - base)]
    if known.size < 2:
        return Estimate(np.nan, np.nan)
    mean, error = mean_of(known)
    return Estimate(float(np.exp(mean)), float(np.exp(mean)) * error)


def size_table(runs: Mapping[str, xr.Dataset], base: tuple[float, float]) -> pd.DataFrame:
    """Compute geometric means at each size, and ratios to those of the base (side, spacing) [m]."""
    rows = []
    for about, run in _spectra(runs):
        values = (run[name].values.tolist() for name in ("patch", "spacing", "cycle"))
        for patch, spacing, cycle in itertools.product(*values):
            status = run.status.sel(patch=patch, spacing=spacing)
            if not np.isfinite(status).any():
                continue
            row = about | {"patch_mm": 1e3 * patch, "spacing_mm": 1e3 * spacing}
            row |= {"joints": int(np.isfinite(status).sum())}
            row |= {"failed": int((status >= FAILURE).sum()), "cycle": cycle}
            for name in (*READ, *GEOMETRY):
                column, scale = COLUMNS[name]
                logs = mean_logs(run, name, cycle)
                here = _at(logs, (patch, spacing))
                known = here[np.isfinite(here)]
                ratio = _ratio(here, _at(logs, base))
                row[column] = scale * float(np.exp(known.mean())) if known.size else np.nan
                row |= {f"{column}_ratio": ratio.value, f"{column}_error": ratio.standard_error}
            rows.append(row)
    return pd.DataFrame(rows)


def exponent_table(runs: Mapping[str, xr.Dataset], base: tuple[float, float]) -> pd.DataFrame:
    """Fit powers of patch length and of spacing, and test whether quantities are powers of these.

    ``reading`` is the quantity, and ``cycle`` is 0 for those of the pristine walls. The power is
    ``of`` the patch length at the base's spacing, or of the spacing at the base's patch. ``change``
    is the exponent between the two largest sizes less that between the two smallest, and ``p`` the
    probability of as large a change if there is none (t test over realisations). ``base`` is side
    and spacing [m].
    """
    rows = []
    for about, run in _spectra(runs):
        cycles = run.cycle.values.tolist()
        for reading, cycle in [*itertools.product(READ, cycles), *((name, 0) for name in GEOMETRY)]:
            logs = mean_logs(run, reading, cycle)
            for of, other, place in (("patch", "spacing", base[1]), ("spacing", "patch", base[0])):
                line = logs.sel({other: place}, method="nearest")
                power = _power(np.log(line[of].values), line.transpose(of, ...).values)
                rows.append(about | {"reading": reading, "cycle": cycle, "of": of} | power)
    return pd.DataFrame(rows)


def _power(size: np.ndarray, logs: np.ndarray) -> dict[str, float]:
    """Fit a power of ``size`` (k,) to ``logs`` (k, realization), both logarithms, and test it."""
    known = logs[:, np.isfinite(logs).all(axis=0)]
    power = dict.fromkeys(("exponent", "error", "change", "change_error", "p"), np.nan)
    if len(size) < 2 or known.shape[1] < 2:
        return power
    power["exponent"], power["error"] = mean_of(np.polyfit(size, known, 1)[0])
    local = np.diff(known, axis=0) / np.diff(size)[:, None]
    if len(local) < 2:
        return power
    changes = local[-1] - local[0]
    power["change"], power["change_error"] = mean_of(changes)
    return power | {"p": float(scipy.stats.ttest_1samp(changes, 0.0).pvalue)}


def barton_bandis_table(
    runs: Mapping[str, xr.Dataset],
    base: tuple[float, float],
    rocks: Mapping[str, tuple[float, float, float]],
    strength_ratio: float,
    seating: float,
) -> pd.DataFrame:
    """Compare changes from the smallest patch to larger ones with those of Barton and Bandis' law.

    ``rocks`` has JRC, compressive strength and maximum stress [Pa] of each rock, those of the
    smallest patch. ``base`` is side and spacing [m], ``strength_ratio`` the strength of the rock
    over that of the wall, ``seating`` the stress [Pa] from which closures count.
    """
    rows = []
    for rock, of_rock in runs.items():
        smallest, *larger = of_rock.patch.values.tolist()
        spectra = list(_spectra({rock: of_rock}))
        for cycle, (about, run) in itertools.product(of_rock.cycle.values, spectra):
            known, *laws = (
                law_of_size(patch / smallest, rocks[rock], strength_ratio, cycle, seating)
                for patch in (smallest, *larger)
            )
            for reading in known:
                logs = mean_logs(run, reading, cycle)
                for patch, law in zip(larger, laws, strict=True):
                    ratio = _ratio(*(_at(logs, (length, base[1])) for length in (patch, smallest)))
                    row = about | {"reading": reading, "cycle": cycle}
                    row |= {"from_mm": 1e3 * smallest, "to_mm": 1e3 * patch}
                    row |= {"ratio": ratio.value, "error": ratio.standard_error}
                    rows.append(row | {"barton_bandis": law[reading] / known[reading]})
    return pd.DataFrame(rows)


def law_of_size(
    times: float,
    rock: tuple[float, float, float],
    strength_ratio: float,
    cycle: int,
    seating: float,
) -> dict[str, float]:
    """Apply the law of Barton and Bandis to a joint so many ``times`` as long as a known one.

    Stiffnesses [Pa/m] and closures [m] since the ``seating`` stress [Pa] have the names of the
    model's quantities. ``strength_ratio`` is sigma_c over JCS of the known joint.
    ``rock`` has JRC, compressive strength [Pa] and maximum stress [Pa] of the known joint.
    """
    jrc, strength, stress = rock
    jrc, wall_strength = scaled_to(times, jrc, strength / strength_ratio, 1.0)
    law = barton_bandis(jrc, strength, strength / wall_strength, cycle)
    return law.since(seating).results(stress, seating)


def _runs(joints: pd.DataFrame, settings: Mapping[str, Any]) -> dict[str, xr.Dataset]:
    return runs_of(joints, list(settings["roll_offs"]))


def tabulate_size(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compute geometric means at each size, and their ratios to those of the base."""
    return size_table(_runs(joints, settings), settings["base"])


def tabulate_exponents(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Fit the powers of patch length and spacing."""
    return exponent_table(_runs(joints, settings), settings["base"])


def tabulate_collapse(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compute by how much each scaling reduces the spread between sizes."""
    return collapse_table(_runs(joints, settings), settings["roll_offs"])


def tabulate_laws(joints: pd.DataFrame, settings: Mapping[str, Any]) -> pd.DataFrame:
    """Compare ratios of sizes with the law of Barton and Bandis."""
    ratio = settings["wall_strength_ratio"]
    runs = _runs(joints, settings)
    seating = settings["seating_stress"]
    return barton_bandis_table(runs, settings["base"], settings["rocks"], ratio, seating)


def settings_of_tables(study: Configuration) -> dict[str, Any]:
    """Return the settings [SI] of a study that its tables and its figure need."""
    spectra = study.section(SizeSection).spectra
    return {
        "base": base_of(study.grid),
        "hursts": {name: spectrum.hurst for name, spectrum in spectra.items()},
        "rocks": {
            name: (rock.jrc, rock.intact.compressive_strength, rock.max_normal_stress)
            for name, rock in study.rocks.items()
        },
        "roll_offs": {name: spectrum.roll_off for name, spectrum in spectra.items()},
        "wall_strength_ratio": study.output.wall_strength_ratio,
        "seating_stress": study.seating_stress,
    }


def draw_size(tables: Tables, settings: Mapping[str, Any]) -> Figure:
    """Draw the first rock's ratios to the base over size; a power law is a straight line."""
    sizes = tables["size"]
    table = sizes[sizes.rock == sizes.rock.iloc[0]]
    rows = [
        Row(f"ratio of {title}", part, f"{column}_ratio", f"{column}_error", {"yscale": "log"})
        for (name, cycle), title in titles_of_cycles(*SHOWN).items()
        for column, part in [(COLUMNS[name][0], table[table.cycle == cycle])]
    ]
    side, spacing = (
        table[name].iloc[(table[name] - 1e3 * length).abs().argmin()]
        for name, length in zip(("patch_mm", "spacing_mm"), settings["base"], strict=True)
    )
    columns = [
        PanelColumn(
            "patch_mm", "spectrum", {"spacing_mm": spacing}, "log", f"spacing {spacing:g} mm"
        ),
        PanelColumn("spacing_mm", "spectrum", {"patch_mm": side}, "log", f"patch {side:g} mm"),
    ]
    titles = {}
    for name, roll_off in settings["roll_offs"].items():
        wave = f"roll-off {1e3 * roll_off:g} mm" if roll_off else "no roll-off"
        titles[name] = f"H {settings['hursts'][name]:g}, {wave}"
    return panels(rows, columns, {"spectrum": titles}, reference=1.0)


def base_of(grid: Grid) -> tuple[float, float]:
    """Return side and spacing [m] of the grid of the study."""
    return grid.cells_x * grid.spacing, grid.spacing


EXPERIMENT = Experiment(
    title="effects of patch length and grid spacing",
    quantities=(*READ, *GEOMETRY),
    jobs=size_jobs,
    tables={
        "size.csv": tabulate_size,
        "size_exponents.csv": tabulate_exponents,
        "size_collapse.csv": tabulate_collapse,
        "size_barton_bandis.csv": tabulate_laws,
    },
    figures={"size": draw_size},
    settings=settings_of_tables,
)
