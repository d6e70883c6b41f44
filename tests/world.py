"""Study with known elasticities: closures are powers of the parameters, on random surfaces."""

import numpy as np
import xarray as xr

from jointclosure.statistics.randomness import generator, seed_of
from studies.frame.cases import cases_of, wall_name
from studies.frame.configuration import Configuration
from studies.frame.joint_tables import join_cases
from tests.studied import study_of

ELASTICITIES = {
    1: {"poisson_ratio": 0.0, "youngs_modulus": -0.3, "compressive_strength": -0.4, "jrc": 0.8},
    2: {"poisson_ratio": 0.02, "youngs_modulus": -1.0, "compressive_strength": 0.6, "jrc": 0.05},
}
"""Elasticities by cycle; with them the paper's claims are true in every rock."""
SCATTER = {1: 0.15, 2: 0.08}
"""Standard deviation of the log of a closure over surfaces."""
IRREGULAR = 0.004
"""Standard deviation of a part of it that differs between the cases of a surface."""
NET_SHARE = 0.9
STRESSES = 7


def world(
    configuration: Configuration | None = None,
    elasticities: dict | None = None,
    irregular: float = IRREGULAR,
    loop: float = 0.05,
    power: float = 0.5,
) -> xr.Dataset:
    """Return the dataset of a study, or of a pool, with known ``elasticities``.

    ``loop`` is the closure of unloading less that of loading, over the maximum closure. In a cycle
    closure rises as a ``power`` of the stress.
    """
    configuration = configuration or study_of()
    cases = cases_of(configuration)
    closed = [
        _closed(case, configuration, elasticities or ELASTICITIES, irregular, loop, power)
        for case in cases
    ]
    return join_cases(cases, closed)


def _closed(case, configuration, elasticities, irregular, loop, power) -> xr.Dataset:
    study = configuration.study
    seeds = [
        seed_of(study.root_seed, *wall_name(study, case), i) for i in range(study.realizations)
    ]
    own = configuration.rocks[case.rock]
    bases = own.intact._asdict() | {"jrc": own.jrc}
    maxima = np.empty((len(seeds), len(SCATTER)))
    for i, seed in enumerate(seeds):
        surface = generator(seed).normal(size=3)
        alone = generator(seed_of(seed, case.label)).normal(size=2)
        for j, (cycle, scatter) in enumerate(SCATTER.items()):
            z = scatter * (0.6 * surface[2] + 0.8 * surface[j]) + irregular * alone[j]
            z += sum(
                power * np.log(case.number(name) / bases[name])
                for name, power in elasticities[cycle].items()
            )
            maxima[i, j] = (1e-3, 1e-4)[j] * np.exp(z)
    stress = np.linspace(0.0, configuration.output.largest_stress, STRESSES)
    rise = np.clip(stress / case.max_normal_stress, 0.0, 1.0) ** power
    loading = maxima[..., None] * rise
    residual = np.stack([0.8 * maxima[:, 0], 0.8 * maxima[:, 0]], axis=1)
    loading[:, 1] += residual[:, :1]
    unloading = loading + loop * maxima[..., None] * (rise < 1.0)
    closure = np.stack([loading, unloading], axis=2)
    over = ("realization", "cycle")
    return xr.Dataset(
        {
            "closure": ((*over, "branch", "stress"), closure),
            "max_closure": (over, maxima),
            "max_closure_net": (over, NET_SHARE * maxima),
            "max_closure_seated": (over, 0.8 * maxima),
            "max_closure_seated_net": (over, 0.7 * maxima),
            "residual_closure": (over, residual),
            "residual_closure_seated_net": (over, 0.9 * residual),
            "status": ("realization", np.zeros(len(seeds), dtype=np.int16)),
            "timing_simulation": ("realization", np.full(len(seeds), 1.5)),
        },
        coords={
            "realization": range(len(seeds)), "cycle": list(SCATTER),
            "branch": ["loading", "unloading"], "stress": stress,
            "seed": ("realization", np.array([f"{s:032x}" for s in seeds], dtype=object)),
        },
    )  # fmt: skip
