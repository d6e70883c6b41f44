"""Files and settings that products read, by the names of their functions' parameters.

Apart from `studies.frame.products`, so that no product depends on the code of the configuration.
"""

import os
import typing
from collections.abc import Callable
from pathlib import Path
from typing import Any

from jointclosure.statistics.repetitions import Design
from studies.frame.cases import dataset_of, ensembles_of
from studies.frame.configuration import Configuration, Configured
from studies.frame.files import DEFAULT, PAPER_TABLE_3, read_plain
from studies.frame.products import Product, Step, products_of

Need = Callable[[Configuration], Any]


def steps_of_products(folder: str, configured: Configured) -> dict[str, Step]:
    """Return the steps of the products of a folder that a study has."""
    return {
        name: step_of(product, configured)
        for name, product in products_of(folder).items()
        if product.when(configured.typed)
    }


def inputs_of(product: Product, study: Configuration) -> dict[str, Any]:
    """Return the paths of the files that a product reads, by name; an empty list for none.

    Those not of `NEEDS` are the table of all ``joints`` of an experiment, or tables and datasets
    that products of the same folder make, by their names without suffix.
    """
    paths: dict[str, Any] = {"joints": study.file(f"{product.folder}.nc")}
    for other in products_of(product.folder).values():
        made, files = other.when(study), map(Path, other.files(study))
        data = (file for file in files if file.suffix in (".csv", ".nc"))
        paths |= {file.stem: made and study.file(str(file)) for file in data}
    paths |= {name: NEEDS[name](study) for name in product.reads if name in NEEDS}
    return {name: paths[name] or [] for name in product.reads if name in paths}


def settings_of(product: Product, configured: Configured) -> dict[str, Any]:
    """Return the settings [SI] that a product reads, by name.

    Those not of `SETTINGS` are made of the configuration as their types state, or are keys of the
    section of the product's folder, of the configuration, or of one of its general sections.
    """
    keys, study = configured
    sections = (
        study.study_sections.get(product.folder), study, study.study, study.statistics, study.output
    )  # fmt: skip
    hints = typing.get_type_hints(product.make, include_extras=True)

    def stated(name: str) -> Any:
        if name == "keys":
            return keys
        if name in SETTINGS:
            return SETTINGS[name](study)
        if made := getattr(hints.get(name), "__metadata__", ()):
            return made[0](configured)
        return next(getattr(part, name) for part in sections if hasattr(part, name))

    files = inputs_of(product, study)
    return {name: stated(name) for name in product.reads if name not in files}


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
        group=product.folder,
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
    "pool_covariates": lambda study: (
        study.variates and study.file("pool_covariates.nc" if study.pooled else "covariates.nc")
    ),
    "lengths": _file("predictive.nc"),
    # they precede Table 3 by paired tests
    "elasticities": lambda study: (
        study.study.draws == "common" and study.file("tables/elasticities.csv")
    ),
    "curve_files": lambda study: [curve.measured.file for curve in study.curves.values()],
    "first_walls": _file("first_walls.nc"),
    "sizes": _file("tables/size.csv"),  # Snakemake takes no input of the name size
}
"""Paths of files; none of what is not made."""


SETTINGS: dict[str, Need] = {
    "titles": lambda study: {name: rock.title for name, rock in study.rocks.items()},
    "closed_by": lambda study: {
        name: (part.study.realizations, part.numerics) for name, part in ensembles_of(study).items()
    },
    # intervals do not depend on its other parts
    "statistics": lambda study: study.statistics._replace(repetitions=0, control_variates=None),
    "design": lambda study: Design(study.study.realizations, study.statistics.significance),
}
"""Settings that are more than a key of the configuration or of its general sections, in SI."""
