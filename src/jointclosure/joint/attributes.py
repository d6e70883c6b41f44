"""Names, units and comments of the variables of a simulated joint."""

from typing import Any

import numpy as np

from jointclosure.joint.status import FLAGS

_VARIABLES = {
    "closure": ("m", "closure from first touch"),
    "normal_stress": ("Pa", "nominal normal stress"),
    "contact_fraction": ("1", "fraction of the cells in contact"),
    "bulk_indentation": ("m", "mean displacement by the interaction"),
    "mean_aperture": (
        "m",
        "mean aperture",
        "void volume over nominal area: mean distance of the deformed walls, 0 in contacts",
    ),
    "mean_overlap": ("m", "sum of the overlaps of contacts over the number of cells"),
    "equilibrium_residual": ("1", "recomputed residual of the forces over their sum"),
    "max_closure": ("m", "maximum closure", "from the start of the cycle"),
    "residual_closure": ("m", "residual closure", "from first touch"),
    "max_closure_seated": ("m", "maximum gross closure since seating"),
    "residual_closure_seated": ("m", "residual closure at seating"),
    "max_bulk_indentation": ("m", "bulk indentation at the maximum stress"),
    "unloading_excess": ("Pa", "largest excess of unloading over loading at equal closure"),
    "least_force": ("N", "least force on any cell at any step"),
    "locked_share": ("1", "share of the force on locked contacts at the maximum stress"),
    "flat_share": ("1", "share of the force on other flat contacts at the maximum stress"),
    "upper_final": ("m", "upper wall at the end, towards the lower"),
    "lower_final": ("m", "lower wall at the end, towards the upper"),
    "settled_states": ("1", "states brought to rest, those thrown away included"),
    "equilibria": ("1", "equilibria solved on the way (reference: sweeps)"),
    "newton_steps": ("1", "steps of Newton's method"),
    "breakage_steps": ("1", "breakage steps taken"),
    "replayed_cycles": ("1", "cycles that are the unloading curve of the one before"),
    "idle_steps": ("1", "accepted steps of the first loading without interaction, as it was idle"),
    "idle_displacement": ("1", "largest displacement of a contact left out so, over closure"),
    "locked_contacts": ("1", "largest number of locked contacts at a step"),
    "solver_iterations": ("1", "products with the interaction, or sweeps (reference)"),
    "force": ("N", "normal force of each contact"),
    "overlap": ("m", "overlap delta_S, negative where the walls are apart"),
    "interaction_displacement": ("m", "displacement by all other contacts"),
    "hydraulic_aperture": (
        "m",
        "aperture of parallel plates that pass as much, 0 if blocked",
        "missing where flow_status is not_solved or at_least, and only bounds are known",
    ),
    "smallest_hydraulic": (
        "m",
        "lower bound of the hydraulic aperture",
        "the hydraulic aperture where it is known, 0 where the flow is not solved",
    ),
    "largest_hydraulic": (
        "m",
        "upper bound of the hydraulic aperture",
        "as if the open cells of every line across the flow were connected",
    ),
    "flow_imbalance": ("1", "sum of the cells' mass balances over the inflow"),
}
ATTRIBUTES: dict[str, dict[str, Any]] = {
    name: {"long_name": text, "units": unit} | ({"comment": comment[0]} if comment else {})
    for name, (unit, text, *comment) in _VARIABLES.items()
}
ATTRIBUTES["status"] = {
    "long_name": "status of the simulation: 0 success, below 16 success with a remark",
    "flag_masks": np.array(list(FLAGS), dtype=np.int16),
    "flag_meanings": " ".join(FLAGS.values()),
}
