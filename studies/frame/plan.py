"""Files and settings that products read, by the names of their functions' parameters.

Apart from `studies.frame.products`, so that no product depends on the code of the configuration.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from jointclosure.statistics.repetitions import Design
from studies.frame.cases import dataset_of, ensembles_of
from studies.frame.configuration import Configuration, Configured
from studies.frame.files import DEFAULT, PAPER_TABLE_3, read_plain
from studies.frame.products import Product, Step


class Plan(NamedTuple):
    """A study whose products are made."""

    configured: Configured

    @property
    def typed(self) -> Configuration:
        """Configuration in SI."""
        return self.configured.typed

    @property
    def pooled(self) -> bool:
        """Whether the study has a pool, by which the model is judged."""
        return self.typed.study.pool is not None

    @property
    def varied(self) -> bool:
        """Whether a property is varied."""
        return any(rock.levels for rock in self.typed.rocks.values())

    @property
    def variates(self) -> bool:
        """Whether means are adjusted by covariates; those of scanned walls are not known."""
        synthetic = any(rock.walls is None for rock in self.typed.rocks.values())
        return self.typed.statistics.control_variates is not None and synthetic

    def file(self, name: str, made: bool = True) -> str | None:
        """Path of a file of the study, None if it is not made."""
        return f"results/{self.typed.study.name}/{name}" if made else None

    def beside(self, *paths: str) -> str | None:
        """First existing table of another study, if this one is of the same model."""
        same_model = self.typed.study.name == read_plain(DEFAULT)["study"]["name"]
        return next((path for path in paths if same_model and Path(path).exists()), None)

    def inputs(self, product: Product) -> dict[str, Any]:
        """Paths of the files that a product reads, by name; an empty list for none."""
        return {name: NEEDS[name](self) or [] for name in product.reads if name in NEEDS}

    def settings(self, product: Product) -> dict[str, Any]:
        """Settings that a product reads, by name; those not of `SETTINGS` are configured ones."""
        typed = self.typed
        sections = (typed, typed.study, typed.statistics, typed.output)

        def stated(name: str) -> Any:
            if name in SETTINGS:
                return SETTINGS[name](self)
            return next(getattr(part, name) for part in sections if hasattr(part, name))

        return {name: stated(name) for name in product.reads if name not in NEEDS}

    def step(self, product: Product) -> Step:
        """The step that makes a product of this study."""
        return Step(
            product.make,
            [f"results/{self.typed.study.name}/{name}" for name in product.files(self)],
            self.inputs(product),
            self.settings(product),
            untimed=BESIDE,
            priority=product.priority,
        )


def _file(name: str) -> Callable[[Plan], str | None]:
    return lambda plan: plan.file(name)


def _global(kind: str) -> Callable[[Plan], str | None]:
    name = f"global_sensitivity/tables/global_sensitivity_{kind}.csv"
    return lambda plan: plan.beside(
        f"results/{name}", f"studies/global_sensitivity/results/{name.replace('tables/', '')}"
    )


BESIDE: dict[str, Callable[[Plan], str | None]] = {
    "jrc_range": lambda plan: plan.beside("studies/paper/results/jrc_range/jrc_range_claims.csv"),
    "readings": lambda plan: plan.beside("studies/paper/results/conclusions/earlier_readings.csv"),
    "choices": _global("conclusions"),
    "margins": _global("margins"),
}
"""Tables of other studies: those that were run here, or else the published ones."""

NEEDS: dict[str, Callable[[Plan], Any]] = BESIDE | {
    # relative, so that results are still valid where the whole folder was moved
    "paper": lambda plan: os.path.relpath(PAPER_TABLE_3),
    "study": _file("study.nc"),
    "pool": lambda plan: plan.file("pool.nc" if plan.pooled else "study.nc"),
    "ensembles": lambda plan: [plan.file(dataset_of(name)) for name in ensembles_of(plan.typed)],
    "finest": _file("finest.nc"),
    "covariates": lambda plan: plan.file("covariates.nc", plan.variates),
    "pool_covariates": lambda plan: plan.file(
        "pool_covariates.nc" if plan.pooled else "covariates.nc", plan.variates
    ),
    "lengths": _file("predictive.nc"),
    "checks": _file("tables/checks.csv"),
    "claims": _file("tables/claims.csv"),
    "closures": _file("tables/max_closure.csv"),
    "intervals": _file("tables/table_3_indifference.csv"),
    # they precede Table 3 by paired tests
    "elasticities": lambda plan: plan.file(
        "tables/elasticities.csv", plan.typed.study.draws == "common"
    ),
    "curve_files": lambda plan: [curve.measured.file for curve in plan.typed.curves.values()],
    "fits": lambda plan: plan.file("tables/measured_fit.csv", bool(plan.typed.curves)),
    "flow": lambda plan: plan.file("tables/hydraulic_aperture.csv", plan.typed.flow),
    "first_walls": _file("first_walls.nc"),
}
"""Paths of files."""


SETTINGS: dict[str, Callable[[Plan], Any]] = {
    "keys": lambda plan: plan.configured.keys,
    "closed_by": lambda plan: {
        name: (part.study.realizations, part.numerics)
        for name, part in ensembles_of(plan.typed).items()
    },
    # intervals do not depend on its other parts
    "statistics": lambda plan: plan.typed.statistics._replace(repetitions=0, control_variates=None),
    "design": lambda plan: Design(
        plan.typed.study.realizations, plan.typed.statistics.significance
    ),
}
"""Settings that are more than a key of the configuration or of its general sections, in SI."""
