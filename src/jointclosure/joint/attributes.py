"""Titles and units of the variables of a joint's history."""

from typing import Any

import numpy as np

from jointclosure.joint.protocol import FLAGS

ATTRIBUTES: dict[str, dict[str, Any]] = {
    name: {"long_name": text, "units": unit} | ({"comment": comment[0]} if comment else {})
    for name, unit, text, *comment in (
        ("closure", "m", "closure from first touch"),
        ("normal_stress", "Pa", "nominal normal stress"),
        ("contact_fraction", "1", "fraction of the cells in contact"),
        ("bulk_indentation", "m", "mean displacement by the interaction"),
        ("mean_aperture", "m", "mean distance of the deformed walls"),
        ("equilibrium_residual", "1", "recomputed residual of the forces over their sum"),
        ("max_closure", "m", "maximum closure", "from the start of the cycle"),
        ("residual_closure", "m", "residual closure", "from first touch"),
        ("max_closure_seated", "m", "maximum closure since seating"),
        ("residual_closure_seated", "m", "residual closure at seating"),
        ("max_bulk_indentation", "m", "bulk indentation at the maximum stress"),
        (
            "unloading_excess",
            "Pa",
            "largest stress by which unloading exceeds loading at equal closure",
        ),
        ("least_force", "N", "least force on any cell at any step"),
        ("locked_share", "1", "share of the force on locked contacts at the maximum stress"),
        ("flat_share", "1", "share of the force on flat contacts at the maximum stress"),
        ("upper_final", "m", "upper wall at the end, towards the lower"),
        ("lower_final", "m", "lower wall at the end, towards the upper"),
        ("settled_states", "1", "states brought to rest, those thrown away included"),
        ("equilibria", "1", "equilibria solved on the way (reference: sweeps)"),
        ("newton_steps", "1", "steps of Newton's method"),
        ("breakage_steps", "1", "breakage steps taken"),
        ("replayed_cycles", "1", "cycles that are the unloading curve of the one before"),
        ("idle_steps", "1", "steps of the first loading without interaction, as it was idle"),
        (
            "idle_displacement",
            "1",
            "largest displacement of a contact that was left out so, over the closure",
        ),
        ("locked_contacts", "1", "largest number of locked contacts at a step"),
        ("solver_iterations", "1", "products with the interaction, or sweeps (reference)"),
        ("force", "N", "normal force of each contact"),
        ("overlap", "m", "overlap delta_S, negative where the walls are apart"),
        ("interaction_displacement", "m", "displacement by all other contacts"),
        (
            "hydraulic_aperture",
            "m",
            "aperture of parallel plates that pass as much, 0 where flow is blocked",
        ),
        ("flow_imbalance", "1", "sum of the cells' mass balances over the inflow"),
    )
}
ATTRIBUTES["status"] = {
    "long_name": "status of the simulation: 0 success, below 16 success with a remark",
    "flag_masks": np.array(list(FLAGS), dtype=np.int16),
    "flag_meanings": " ".join(FLAGS.values()),
}
