"""Quantities of a simulated joint: their titles, units and symbols, and how they are computed."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from jointclosure.ensembles.simulated_joint import SimulatedJoint
from jointclosure.joint.attributes import ATTRIBUTES
from jointclosure.joint.cycle_results import hysteresis, largest_jump, loop_between
from jointclosure.joint.status import LOADING, unbreakable_share
from jointclosure.walls.bearing_area import bearing_depths
from jointclosure.walls.jrc import rms_slope

CYCLE = ("cycle",)
CURVE = ("cycle", "branch", "stress")
_ROUNDING = 1e-13  # change of a height [m] that is no breakage
_SHOWN = {
    "m": ("mm", 1e3),
    "Pa": ("MPa", 1e-6),
    "Pa/m": ("MPa/mm", 1e-9),
    "m/Pa": ("mm/MPa", 1e9),
    "1": ("", 1.0),
}
"""Unit in tables and figures, and the factor from SI to it, by SI unit."""


def shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit in which tables and figures show values in an SI unit, and the factor.

    Values in SI are multiplied by the factor. The unit of a ratio is empty.
    """
    return _SHOWN.get(unit, (unit, 1.0))


def shown_as(name: str, unit: str) -> tuple[str, float]:
    """Return the column of a quantity ``name`` in tables, and the factor of its values there.

    The column ends in the shown unit, such as "stiffness_net_MPa_per_mm". ``unit`` is that in SI.
    """
    shown, scale = shown_unit(unit)
    return f"{name}_{shown.replace('/', '_per_')}".removesuffix("_"), scale


def heading(title: str, unit: str) -> str:
    """Return a title with its ``unit`` in brackets; without it for a ratio."""
    return title if unit in ("", "1") else f"{title} ({unit})"


class Quantity(NamedTuple):
    """Quantity of a simulated joint, and the function ``rule`` that computes it.

    ``title`` is without the unit, ``unit`` in SI ("1" for a ratio), ``symbol`` in matplotlib's
    notation of formulas. ``dims`` are the dimensions of its values. ``further`` attributes are a
    comment, or the meanings of bits. A quantity ``of_effort`` describes the computation: joints
    that failed have only these.
    """

    title: str
    unit: str
    dims: tuple[str, ...]
    rule: Callable[[SimulatedJoint], Any]
    symbol: str = ""
    further: Mapping[str, Any] = {}
    of_effort: bool = False

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of the quantity as a variable of a dataset."""
        unit = {} if "flag_masks" in self.further else {"units": self.unit}
        return {"long_name": self.title} | unit | dict(self.further)

    @property
    def has_harmonic_mean(self) -> bool:
        """Whether the mean of the quantity over joints is the harmonic one.

        This is so for stiffnesses, so that their mean is the stiffness of the mean curve.
        """
        return self.unit == "Pa/m"

    @property
    def heading(self) -> str:
        """Title with the unit in which tables and figures show the quantity."""
        return heading(self.title, shown_unit(self.unit)[0])


def _history(
    name: str,
    dims: tuple[str, ...] = (),
    symbol: str = "",
    rule: Callable[[SimulatedJoint], Any] | None = None,
) -> Quantity:
    """Make a quantity with the title and unit of a variable ``name`` of a history.

    It is computed by ``rule``, and is the variable itself by default.
    """
    further = dict(ATTRIBUTES[name])
    title = further.pop("long_name")
    unit = further.pop("units", "1")
    rule = rule or (lambda joint: joint.closed[name].values)
    return Quantity(title, unit, dims, rule, symbol, further)


def _curve(name: str) -> Quantity:
    """Make a quantity of a variable of steps, read at the stresses of curves on each branch."""
    return _history(
        name,
        CURVE,
        rule=lambda joint: joint.read_at_stresses(joint.closed[name].values, joint.stresses),
    )


def _net(title: str, name: str, symbol: str = "", unit: str = "m", comment: str = "") -> Quantity:
    """Make a quantity that is the entry ``name`` of `net_responses`, for each cycle."""
    further = {"comment": comment} if comment else {}
    return Quantity(title, unit, CYCLE, lambda joint: joint.net[name], symbol, further)


def _hydraulic(joint: SimulatedJoint) -> np.ndarray:
    """Return hydraulic apertures [m] over (direction, cycle, branch, stress)."""
    along = joint.closed.hydraulic_aperture.values.T
    return np.stack([joint.read_at_stresses(values, joint.stresses) for values in along])


def _loop(joint: SimulatedJoint) -> np.ndarray:
    """Return the closure on unloading less that on loading [m] at half of the maximum, by cycle."""
    half = np.array([0.5 * joint.conditions.largest_stress])
    return loop_between(*joint.read_at_stresses(joint.closed.closure.values, half)[:, :, 0].T)


def _aperture_at_seating(joint: SimulatedJoint) -> np.ndarray:
    """Return the mean aperture [m] at the seating stress on the loading of each cycle."""
    cycles = range(1, joint.conditions.cycle_count + 1)
    aperture = joint.history.curve("mean_aperture")
    return np.array([aperture.seat(cycle, LOADING) for cycle in cycles])


def _volume_error(joint: SimulatedJoint) -> float:
    """Return the relative change of the volume of a wall [1], the larger one of both walls.

    It is |sum z - sum z0| / sum (z0 - min z0) with the heights z at the end and z0 before loading,
    or its numerator [m] for a flat wall.
    """
    errors = []
    for before, after in zip(joint.walls, joint.final, strict=True):
        scale = float(np.sum(before - before.min()))
        change = abs(float(np.sum(after - before)))
        errors.append(change / scale if scale > 0.0 else change)
    return max(errors)


def _oracle_ratio(joint: SimulatedJoint) -> float:
    """Return the `oracle_ratio` of a joint."""
    # imported only here, as it loads the solvers, which jobs that tabulate do not need
    from jointclosure.ensembles.oracle_limits import oracle_ratio

    return oracle_ratio(joint)


_OF_LAW = {"comment": "of the hyperbolic law of loading since seating"}
_EFFORT = ("status", "breakage_steps", "locked_contacts", "solver_iterations", "replayed_cycles",
           "idle_steps")  # fmt: skip
QUANTITIES: dict[str, Quantity] = {
    "max_closure": _history("max_closure", CYCLE, r"x_\mathrm{max}"),
    "residual_closure": _history("residual_closure", CYCLE, r"x_\mathrm{res}"),
    "max_closure_seated": _history("max_closure_seated", CYCLE, r"x_\mathrm{max,s}"),
    "residual_closure_seated": _history("residual_closure_seated", CYCLE),
    "max_bulk_indentation": _history("max_bulk_indentation", CYCLE),
    "locked_share": _history("locked_share", CYCLE),
    "flat_share": _history("flat_share", CYCLE),
    "unloading_excess": _history("unloading_excess", CYCLE),
    **{name: _history(name)._replace(of_effort=True) for name in _EFFORT},
    "least_force": _history("least_force"),
    "idle_displacement": _history("idle_displacement"),
    "closure": _curve("closure"),
    "bulk_indentation": _curve("bulk_indentation"),
    "max_closure_net": _net("maximum net closure", "max_closure_net", r"x_\mathrm{net}"),
    "max_closure_seated_net": _net(
        "net closure since seating", "max_closure_seated_net", r"x_\mathrm{net,s}"),
    "residual_closure_seated_net": _net(
        "net residual closure at seating", "residual_closure_seated_net", r"x_\mathrm{res,s}"),
    "stiffness_net": _net(
        "net chord stiffness", "stiffness_net", r"k_\mathrm{n}", "Pa/m",
        "chord of loading from half of the maximum stress to the landing on it"),
    "landing_stress": _net(
        "landing stress", "landing_stress", unit="Pa",
        comment="loading lands on its maximum by smaller steps from here, infinite without"),
    "largest_residual": Quantity(
        "largest equilibrium residual of all steps", "1", (),
        lambda joint: float(joint.closed.equilibrium_residual.max())),
    "mean_aperture": _curve("mean_aperture"),
    "hydraulic_aperture": _history("hydraulic_aperture", ("direction", *CURVE), rule=_hydraulic),
    "largest_flow_imbalance": Quantity(
        "largest sum of the cells' mass balances over the inflow, of all steps", "1", (),
        lambda joint: float(joint.closed.flow_imbalance.max())),
    "largest_jump": Quantity(
        "largest closure of a loading at constant stress, over its closure", "1", (),
        lambda joint: largest_jump(joint.closed),
        further={"comment": "where a test that controls the stress would jump"}),
    "volume_error": Quantity(
        "change of a wall's volume over the volume above its lowest point", "1", (),
        _volume_error),
    "timing_simulation": Quantity(
        "processor time of the simulation", "s", (), lambda joint: joint.seconds, of_effort=True),
    "compliance_net": Quantity(
        "net normal compliance", "m/Pa", CYCLE, lambda joint: 1.0 / joint.net["stiffness_net"],
        r"c_\mathrm{n}", {"comment": "one over the net chord stiffness"}),
    "kni_net": Quantity(
        "initial net stiffness kni", "Pa/m", CYCLE,
        lambda joint: 1e9 * joint.hyperbola("kni_MPa_per_mm"), r"k_\mathrm{ni}", _OF_LAW),
    "vm_net": Quantity(
        "asymptotic net closure Vm of the hyperbola", "m", CYCLE,
        lambda joint: 1e-3 * joint.hyperbola("vm_mm"),
        r"V_\mathrm{m}", _OF_LAW),
    "rms_height": Quantity(
        "rms of the summed heights", "m", (), lambda joint: float(np.std(joint.summed)), "R_q"),
    "rms_slope": Quantity(
        "rms slope of the summed heights at their spacing", "1", (),
        lambda joint: rms_slope(joint.summed, joint.conditions.grid_spacing), "Z_2"),
    "depth_5": Quantity(
        "depth of the highest 5 % of the summed heights below their top", "m", (),
        lambda joint: float(bearing_depths(joint.summed, 0.05)), "d_5"),
    "initial_aperture": Quantity(
        "mean aperture at first touch", "m", (),
        lambda joint: float((joint.summed.max() - joint.summed).mean()), "a_0"),
    "mean_aperture_at_seating": Quantity(
        "mean aperture at seating", "m", CYCLE, _aperture_at_seating, r"a_\mathrm{s}"),
    "mean_aperture_at_max": Quantity(
        "mean aperture at the maximum stress", "m", CYCLE,
        lambda joint: joint.history.curve("mean_aperture").at_maxima,
        r"a_\mathrm{max}"),
    "contact_at_max": Quantity(
        "share of cells in contact at the maximum stress", "1", CYCLE,
        lambda joint: joint.history.curve("contact_fraction").at_maxima, r"A_\mathrm{c}"),
    "loop": Quantity(
        "closure of unloading less that of loading, at half of the maximum stress", "m", CYCLE,
        _loop, r"x_\mathrm{loop}"),
    "hysteresis": Quantity(
        "hysteresis, share of the work of loading", "1", CYCLE,
        lambda joint: hysteresis(joint.closed), r"\eta",
        {"comment": "what unloading does not give back"}),
    "unbreakable_share": Quantity(
        "largest share of the force on contacts that cannot break", "1", (),
        lambda joint: float(unbreakable_share(joint.closed).max())),
    "contacts_at_max": Quantity(
        "largest number of cells in contact at the maximum stress", "1", (),
        lambda joint: float(
            np.nanmax(joint.history.curve("contact_fraction").at_maxima) * joint.walls[0].size)),
    "broken_share": Quantity(
        "share of the cells of both walls that broke", "1", (),
        lambda joint: float(np.mean(np.subtract(joint.walls, joint.final) > _ROUNDING))),
    "stress_over_strength": Quantity(
        "maximum stress over the compressive strength of the weaker rock", "1", (),
        lambda joint: joint.conditions.largest_stress / min(
            rock.compressive_strength for rock in joint.conditions.rock)),
    "oracle_ratio": Quantity(
        "largest number of the oracle over its limit, at the first maximum", "1", (),
        _oracle_ratio),
}  # fmt: skip
"""All quantities by name, which is that of variables of datasets and of responses in tables."""
COLUMNS = {name: shown_as(name, quantity.unit) for name, quantity in QUANTITIES.items()}
"""Column of each quantity in tables, and the factor of its values there, by name of quantity."""
COORDINATES = {
    "wavelength": ("mismatch wavelength", "m"),
    "shift": ("shift", "m"),
    "patch": ("patch length", "m"),
    "spacing": ("spacing", "m"),
    "tilt": ("tilt", "degrees"),
    "rotation": ("rotation", "degrees"),
    "stress": ("maximum stress", "Pa"),
}
"""Titles and SI units of the coordinates of the points of studies, as far as they are numbers."""
HEADINGS = {COLUMNS[name][0]: quantity.heading for name, quantity in QUANTITIES.items()} | {
    shown_as(name, unit)[0]: heading(title, shown_unit(unit)[0])
    for name, (title, unit) in COORDINATES.items()
}
"""Headings of tables and labels of axes, by column."""
CURVES = {
    "closure_net_since_seating_mm": ("net closure since seating (mm)", True),
    "normal_stiffness_net_MPa_per_mm": ("net tangent stiffness kn (MPa/mm)", True),
    "mean_aperture_mm": ("mean aperture (mm)", False),
    "hydraulic_aperture_mm": ("hydraulic aperture (mm)", False),
    "smallest_hydraulic_mm": ("lower bound of the hydraulic aperture (mm)", False),
    "largest_hydraulic_mm": ("upper bound of the hydraulic aperture (mm)", False),
    "transmissivity_m2_per_s": ("transmissivity of water at 20 °C (m2/s)", False),
    "smallest_transmissivity_m2_per_s": ("lower bound of the transmissivity (m2/s)", False),
    "largest_transmissivity_m2_per_s": ("upper bound of the transmissivity (m2/s)", False),
}
"""Heading of each curve over stress (`jointclosure.joint.result_tables.stress_table`), by column,
and whether the curve rises with stress; the others fall."""


def titles_of_cycles(*shown: tuple[str, int]) -> dict[tuple[str, int], str]:
    """Return the titles of quantities in cycles, such as "..., cycle 2", by (quantity, cycle)."""
    return {(name, cycle): f"{QUANTITIES[name].title}, cycle {cycle}" for name, cycle in shown}


OF_FLOW = ("mean_aperture", "hydraulic_aperture", "largest_flow_imbalance")
_STORED = tuple(QUANTITIES)[: tuple(QUANTITIES).index("timing_simulation") + 1]


def names_of_case(flow: bool) -> tuple[str, ...]:
    """Return the names of the quantities that are stored of every joint of a case.

    Those of flow are among them only with ``flow``.
    """
    return tuple(name for name in _STORED if flow or name not in OF_FLOW)
