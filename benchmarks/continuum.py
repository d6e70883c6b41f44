"""The same walls in the asperity model, and in continuum codes with their nearest law.

The continuum is one elastic half-space, as in `peers.py`, whose set-ups are used. Its nearest law
to strength is a hardness: no pressure is larger, and what would overlap there stays as plastic
displacement (Almqvist et al. 2007), solved by ContactMechanics. Hardnesses: none (elastic; also by
tamaas and aspher); the mean Hertz pressure at which our asperities break, 2/3 sigma_c/c(nu); and
2.8 sigma_c, that of a fully plastic contact (Tabor 1951).

Walls are those of the paper's study of dolerite. Numbers are means over realisations with standard
errors; `ratio` is to the asperity model, by pairs. The stiffness of loading is read, in all models,
to the stress at which the asperity model begins to land on the maximum.

    .venv/bin/python -m pip install -e '.[peers]'

A code that is not installed is named and left out. Run as `python benchmarks/continuum.py`;
`make publish STUDY=results/continuum` stores its tables and figure for the page.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from yardstick import DOLERITE, ELASTIC, FULL, case_settings, close, machine, options

# isort: split
import numpy as np
import pandas as pd
import peers
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from jointclosure.joint.history import history_of
from jointclosure.mechanics.strength import strength_factor
from jointclosure.plotting.style import decimal_ticks, styled, subplots
from jointclosure.statistics.standard_errors import mean_of
from jointclosure.storage.files import write_csv
from jointclosure.storage.folders import write
from studies.frame.settings import walls_of

BRANCHES = ("loading", "unloading", "reloading")
LEVELS = np.array([0.05, 0.1, 0.25, 0.5, 0.75, 1.0])
"""Stresses of every branch over the largest; among them half of it."""
PENETRATION, ITERATIONS = 1e-8, 5000
"""Penetration [m] of cells in contact up to which ContactMechanics may stop, and its most
iterations."""
RESULTS = Path(__file__).parents[1] / "results/continuum"


class Stresses(NamedTuple):
    """Ascending stresses [Pa] of every branch of a joint, and places among them.

    ``levels`` are the places of `LEVELS`, and ``half`` is that of half of the largest stress. The
    stiffness of loading is read up to the place ``end``.
    """

    all: np.ndarray
    levels: np.ndarray
    half: int
    end: int


def stresses_of(largest: float, landing: float) -> Stresses:
    """Return `LEVELS` of a largest stress [Pa], with the stress from which a joint lands on it."""
    levels = LEVELS * largest
    end = min(landing, largest)
    every = np.unique(np.append(levels, end))
    half, last = np.searchsorted(every, [0.5 * largest, end])
    return Stresses(every, np.searchsorted(every, levels), int(half), int(last))


class PressedJoint(NamedTuple):
    """Closures [m] and shares of cells in contact over (branch, stress), and residual closure [m].

    Closures count from first touch of the pristine walls.
    """

    closure: np.ndarray
    contact: np.ndarray
    residual: float


def hardnesses(rock) -> dict[str, float]:
    """Return hardnesses [Pa] of a rock: the mean Hertz pressure at breakage, and Tabor's."""
    strength = rock.compressive_strength
    return {
        "at breakage": 2.0 / 3.0 * strength / strength_factor(rock.poisson_ratio),
        "2.8 sigma_c": 2.8 * strength,
    }


def asperity_model(walls, effects, stresses: np.ndarray) -> PressedJoint:
    """Press two walls (y, x) [m] by our model at ascending stresses [Pa]."""
    history = close(walls, effects, stresses[-1], cycles=2)
    stresses = np.minimum(stresses, float(history.normal_stress.max()))  # breakage may jump over it
    read = [history_of(history).curve(of).at(stresses) for of in ("closure", "contact_fraction")]
    # loading, unloading of the first cycle, loading of the second
    curves, shares = (np.array([each[0, 0], each[0, 1], each[1, 0]]) for each in read)
    return PressedJoint(curves, shares, float(history.residual_closure[0]))


def along(press: Callable, left: Callable[[], float], stresses: np.ndarray) -> PressedJoint:
    """Press a joint by a continuum code with a hardness at ascending stresses [Pa] of all branches.

    ``press(stress)`` returns closure [m] and pressures (y, x) [Pa] at the next stress [Pa], and
    ``left()`` the closure [m] at which the deformed walls touch last. The state at the largest
    stress is the same on all branches, and not computed again.
    """
    shape = (len(BRANCHES), stresses.size)
    closure = np.zeros(shape)
    contact = np.zeros(shape)
    up = range(stresses.size)
    for branch, order in enumerate((up, up[::-1], up)):
        if branch == 2:
            residual = left()
        for level in order:
            if branch and level == up[-1]:
                closure[branch, level] = closure[0, -1]
                contact[branch, level] = contact[0, -1]
                continue
            closure[branch, level], pressure = press(stresses[level])
            contact[branch, level] = np.mean(pressure > 0.0)
    return PressedJoint(closure, contact, residual)


def elastic(set_up: Callable, gap: np.ndarray, stresses: np.ndarray) -> PressedJoint:
    """Press a gap (y, x) [m] by an elastic code of `peers.py`, whose branches are all the same."""
    solve = set_up(gap)
    guess = np.ones_like(gap)
    curves = []
    for stress in stresses:
        closure, guess, _ = solve(stress, guess * (stress / guess.mean()), 1e-6, np.ptp(gap))
        curves.append((closure, np.mean(guess > 0.0)))
    closure, contact = (np.tile(each, (len(BRANCHES), 1)) for each in np.transpose(curves))
    return PressedJoint(closure, contact, 0.0)


def plastic(gap: np.ndarray, hardness: float):
    """Return ``press`` and ``left`` of `along` for ContactMechanics with a hardness [Pa]."""
    from ContactMechanics import FreeFFTElasticHalfSpace
    from ContactMechanics.Factory import make_plastic_system
    from SurfaceTopography import PlasticTopography, Topography

    sizes = (peers.SIDE, peers.SIDE)
    surface = PlasticTopography(Topography(-gap, physical_sizes=sizes), hardness)
    half_space = FreeFFTElasticHalfSpace(gap.shape, peers.MODULUS, sizes)
    system = make_plastic_system(substrate=half_space, surface=surface)

    def press(stress: float) -> tuple[float, np.ndarray]:
        found = system.minimize_proxy(
            external_force=stress * peers.SIDE**2,
            pentol=PENETRATION,
            maxiter=ITERATIONS,
        )
        pressure = found.jac[tuple(slice(cells) for cells in gap.shape)] / peers.CELL
        if not found.success:
            raise RuntimeError(f"ContactMechanics: no equilibrium at {stress:g} Pa")
        return found.offset, pressure

    return press, lambda: float(-surface.heights().max())


def models() -> dict[str, Callable]:
    """Return functions by name of the model, which press two walls at stresses (level,) [Pa]."""

    def gap_of(walls):
        summed = walls[0] + walls[1]
        return summed.max() - summed

    found: dict[str, Callable] = {
        "asperity model": lambda walls, stresses: asperity_model(walls, FULL, stresses),
        "asperity model, elastic": lambda walls, stresses: asperity_model(walls, ELASTIC, stresses),
    }
    for name in ("contact_mechanics", "tamaas", "aspher"):
        set_up = getattr(peers, name)
        found[f"continuum, elastic ({name})"] = lambda walls, stresses, set_up=set_up: elastic(
            set_up, gap_of(walls), stresses
        )
    for name, hardness in hardnesses(DOLERITE).items():
        found[f"continuum, hardness {name} (ContactMechanics)"] = (
            lambda walls, stresses, hardness=hardness: along(
                *plastic(gap_of(walls), hardness), stresses
            )
        )
    return found


def closed(name: str, simulate_pair: Callable, walls, stresses: np.ndarray) -> PressedJoint:
    """Press two walls by a model; if it finds no equilibrium, print this and return NaN."""
    try:
        return simulate_pair(walls, stresses)
    except RuntimeError as error:
        print(f"{name}: a realisation is left out ({error})", flush=True)
        nothing = np.full((len(BRANCHES), stresses.size), np.nan)
        return PressedJoint(nothing, nothing, np.nan)


def readings(history: PressedJoint, stresses: Stresses) -> dict[str, float]:
    """Return the readings that are compared, in mm, percent, MPa/mm and MPa."""
    half = stresses.half
    top = stresses.all.size - 1
    chords = {
        branch: _chord(
            history.closure[place], stresses.all, half, stresses.end if place == 0 else top
        )
        for place, branch in enumerate(BRANCHES)
    }
    first, _, second = history.closure[:, -1]
    return {
        "closure_1_mm": 1e3 * first,
        "residual_mm": 1e3 * history.residual,
        "closure_2_mm": 1e3 * (second - history.residual),
        "contact_1_percent": 100.0 * history.contact[0, -1],
        "contact_half_unloaded_percent": 100.0 * history.contact[1, half],
        **{f"stiffness_{branch}_MPa_per_mm": 1e-9 * chord for branch, chord in chords.items()},
        "loading_read_to_MPa": 1e-6 * stresses.all[stresses.end],
    }


def _chord(closure: np.ndarray, stresses: np.ndarray, low: int, high: int) -> float:
    """Return the stiffness [Pa/m] between two places; NaN if the second is not higher."""
    rise = stresses[high] - stresses[low]
    return float(rise / (closure[high] - closure[low])) if high > low else np.nan


def table_of(histories: dict[str, list[PressedJoint]], stresses: list[Stresses]) -> pd.DataFrame:
    """Tabulate means with errors, and mean ratios to the first model on the same walls."""
    read = {
        name: pd.DataFrame(
            [readings(each, there) for each, there in zip(own, stresses, strict=True)]
        )
        for name, own in histories.items()
    }
    ours = next(iter(read.values()))
    rows = []
    for name, own in read.items():
        for reading in own:
            known = own[reading].notna()
            values = own[reading][known]
            of_ours = ours[reading][known]
            rows.append(
                {"model": name, "reading": reading, "realizations": int(known.sum())}
                | dict(zip(("mean", "error"), mean_of(values), strict=True))
                | dict(zip(("ratio", "ratio_error"), mean_of(values / of_ours), strict=True))
            )
    return pd.DataFrame(rows)


NOT_DRAWN = ("tamaas", "aspher")
"""Words in names of models that are not drawn, as their lines lie on another one."""
_BRANCH_STYLES: dict[str, dict] = {
    "loading": {"ls": "-"},
    "unloading": {"ls": "--", "mfc": "white"},
    "reloading": {"ls": ":", "ms": 3.0},
}
"""Line style and markers of each branch."""


def curve_table(histories: dict[str, list[PressedJoint]], stresses: list[Stresses]) -> pd.DataFrame:
    """Tabulate mean closure and contact with standard errors, by model, branch and stress.

    At zero stress closure is 0 on loading and the residual closure on the other branches. There is
    no contact then.
    """
    tables = []
    levels = [each.levels for each in stresses]
    forces = np.append(0.0, 1e-6 * stresses[0].all[levels[0]])
    for name, pressed in histories.items():
        pairs = list(zip(pressed, levels, strict=True))
        closure = 1e3 * np.array([each.closure[:, there] for each, there in pairs])
        contact = 100.0 * np.array([each.contact[:, there] for each, there in pairs])
        residual = 1e3 * np.array([each.residual for each, _ in pairs])
        known = np.isfinite(closure[:, 0, 0])
        for number, branch in enumerate(BRANCHES):
            start = (0.0, 0.0) if number == 0 else _mean_and_error(residual[known])
            columns = {"model": name, "branch": branch, "normal_stress_MPa": forces}
            of_closure = _mean_and_error(closure[known, number])
            of_contact = _mean_and_error(contact[known, number])
            for column, values, least in zip(("", "_error"), of_closure, start, strict=True):
                columns[f"closure_mm{column}"] = np.append(least, values)
            for column, values in zip(("", "_error"), of_contact, strict=True):
                columns[f"contact_percent{column}"] = np.append(np.nan, values)
            tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True)


@styled
def continuum_figure(curves: pd.DataFrame) -> Figure:
    """Draw stress over closure, and contact over stress: means with standard errors as bars.

    Markers of unloading are hollow, those of reloading small, as its line may lie on that of
    unloading. Both reach to the residual closure.
    """
    figure, (upper, lower) = subplots(2, 1, figsize=(6.2, 10.5), layout="constrained")
    models = curves.model.unique()
    shown = [name for name in models if not any(word in name for word in NOT_DRAWN)]
    for number, name in enumerate(shown):
        title = name.replace("contact_mechanics", "ContactMechanics").replace("sigma_c", "σc")
        look: dict = {"color": f"C{number}", "marker": "osD^vP"[number % 6], "ms": 5.5}
        for branch, style in _BRANCH_STYLES.items():
            rows = curves[(curves.model == name) & (curves.branch == branch)]
            settings = {"label": title if branch == BRANCHES[0] else None, "capsize": 2, "lw": 1.3}
            settings |= look | style
            stress = rows.normal_stress_MPa
            upper.errorbar(rows.closure_mm, stress, xerr=rows.closure_mm_error, **settings)
            lower.errorbar(
                stress, rows.contact_percent, yerr=rows.contact_percent_error, **settings
            )
    upper.set(xlabel="closure from first touch (mm)", ylabel="normal stress (MPa)", ylim=-0.6)
    lower.set(xlabel="normal stress (MPa)", ylabel="cells in contact (%)", yscale="log")
    decimal_ticks(lower.yaxis)
    handles = list(upper.get_legend_handles_labels()[0])
    for branch, style in _BRANCH_STYLES.items():
        handles.append(Line2D([], [], **{"color": "0.3", "marker": "o", "label": branch} | style))
    figure.legend(handles=handles, loc="outside lower center", ncols=1)
    return figure


def _mean_and_error(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and standard error over the first axis."""
    return values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(len(values))


def main(realizations: int, stress: float, output: Path) -> None:
    """Print the machine and the comparison; write both tables and the figure."""
    settings = case_settings(realizations, peers.CELLS, stress, FULL)
    pairs = list(walls_of(settings))
    histories = {}
    stresses = [
        stresses_of(stress, history_of(close(walls, FULL, stress)).landing_stresses[0])
        for walls in pairs
    ]
    for name, simulate_pair in models().items():
        try:
            histories[name] = [
                closed(name, simulate_pair, walls, there.all)
                for walls, there in zip(pairs, stresses, strict=True)
            ]
        except ImportError as error:
            print(f"{name} is left out: it is not installed here ({error})")
    table = table_of(histories, stresses)
    print(f"{machine()}\n{DOLERITE}, {1e-6 * stress:g} MPa, {peers.CELLS} x {peers.CELLS} cells")
    print(table.to_string(float_format="%.4g"))
    for folder in ("tables", "figures"):
        (output / folder).mkdir(parents=True, exist_ok=True)
    write_csv(table, output / "tables/continuum.csv")
    curves = curve_table(histories, stresses)
    write_csv(curves, output / "tables/continuum_curves.csv")
    write(continuum_figure(curves), output / "figures/continuum.png")


if __name__ == "__main__":
    asked = options(__doc__, realizations=10, stress=30e6, output=RESULTS)
    main(asked.realizations, asked.stress, asked.output)
