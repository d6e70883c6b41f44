"""Files and settings that products read, by the names of their functions' parameters.

Apart from `studies.frame.products`, so that no product depends on the code of the configuration.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from jointclosure.statistics.repetitions import Design
from studies.frame.cases import dataset_of, ensembles_of
from studies.frame.configuration import Configuration, Configured
from studies.frame.files import DEFAULT, PAPER_TABLE_3, read_plain
from studies.frame.products import Product, Step

Need = Callable[[Configuration], Any]


def inputs_of(product: Product, study: Configuration) -> dict[str, Any]:
    """Return the paths of the files that a product reads, by name; an empty list for none."""
    return {name: NEEDS[name](study) or [] for name in product.reads if name in NEEDS}


def settings_of(product: Product, configured: Configured) -> dict[str, Any]:
    """Return the settings [SI] that a product reads, by name.

    Those not of `SETTINGS` are keys of the configuration or of one of its general sections.
    """
    study = configured.typed
    sections = (study, study.study, study.statistics, study.output)

    def stated(name: str) -> Any:
        if name in SETTINGS:
            return SETTINGS[name](study)
        return next(getattr(part, name) for part in sections if hasattr(part, name))

    names = (name for name in product.reads if name not in NEEDS)
    return {name: configured.keys if name == "keys" else stated(name) for name in names}


def step_of(product: Product, configured: Configured) -> Step:
    """Return the step that makes a product of a study."""
    study = configured.typed
    return Step(
        product.make,
        [study.file(name) for name in product.files(study)],
        inputs_of(product, study),
        settings_of(product, configured),
        untimed=BESIDE,
        priority=product.priority,
    )


def _file(name: str) -> Need:
    return lambda study: study.file(name)


def _beside(*paths: str) -> Need:
    """Return the need of the first existing table of another study, if this is of its model."""

    def path(study: Configuration) -> str | None:
        same_model = study.study.name == read_plain(DEFAULT)["study"]["name"]
        return next((path for path in paths if same_model and Path(path).exists()), None)

    return path


_GLOBAL = (
    "results/global_sensitivity/tables/global_sensitivity",
    "studies/global_sensitivity/results/global_sensitivity/global_sensitivity",
)
BESIDE: dict[str, Need] = {
    "jrc_range": _beside("studies/paper/results/jrc_range/jrc_range_claims.csv"),
    "readings": _beside("studies/paper/results/conclusions/earlier_readings.csv"),
    "choices": _beside(*(f"{folder}_conclusions.csv" for folder in _GLOBAL)),
    "margins": _beside(*(f"{folder}_margins.csv" for folder in _GLOBAL)),
}
"""Tables of other studies: those that were run here, or else the published ones."""

NEEDS: dict[str, Need] = BESIDE | {
    # relative, so that results are still valid where the whole folder was moved
    "paper": lambda study: os.path.relpath(PAPER_TABLE_3),
    "study": _file("study.nc"),
    "pool": lambda study: study.file("pool.nc" if study.pooled else "study.nc"),
    "ensembles": lambda study: [study.file(dataset_of(name)) for name in ensembles_of(study)],
    "finest": _file("finest.nc"),
    "covariates": lambda study: study.variates and study.file("covariates.nc"),
    "pool_covariates": lambda study: (
        study.variates and study.file("pool_covariates.nc" if study.pooled else "covariates.nc")
    ),
    "lengths": _file("predictive.nc"),
    "checks": _file("tables/checks.csv"),
    "claims": _file("tables/claims.csv"),
    "closures": _file("tables/max_closure.csv"),
    "intervals": _file("tables/table_3_indifference.csv"),
    # they precede Table 3 by paired tests
    "elasticities": lambda study: (
        study.study.draws == "common" and study.file("tables/elasticities.csv")
    ),
    "curve_files": lambda study: [curve.measured.file for curve in study.curves.values()],
    "fits": lambda study: study.curves and study.file("tables/measured_fit.csv"),
    "flow": lambda study: study.flow and study.file("tables/hydraulic_aperture.csv"),
    "first_walls": _file("first_walls.nc"),
}
"""Paths of files; none of what is not made."""


SETTINGS: dict[str, Need] = {
    "closed_by": lambda study: {
        name: (part.study.realizations, part.numerics) for name, part in ensembles_of(study).items()
    },
    # intervals do not depend on its other parts
    "statistics": lambda study: study.statistics._replace(repetitions=0, control_variates=None),
    "design": lambda study: Design(study.study.realizations, study.statistics.significance),
}
"""Settings that are more than a key of the configuration or of its general sections, in SI."""
