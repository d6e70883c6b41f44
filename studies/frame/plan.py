"""Files and settings that products read, by the names of their functions' parameters.

Apart from `studies.frame.products`, so that no product depends on the code of the configuration.
"""

import typing
from collections.abc import Callable
from pathlib import Path
from typing import Any

from studies.frame.configuration import Configuration
from studies.frame.products import Product, Step, products_of

Need = Callable[[Configuration], Any]
NEEDS: dict[str, Need] = {
    "sizes": lambda study: study.file("tables/size.csv"),  # Snakemake takes no input named size
}
"""Paths of files; none of what is not made. A study may add some, as to the next two."""
SETTINGS: dict[str, Need] = {
    "titles": lambda study: {name: rock.title for name, rock in study.rocks.items()},
}
"""Settings [SI] that are more than a key of the configuration or of its general sections."""
UNTIMED: set[str] = set()
"""Names of files whose times do not count."""


def steps_of_products(folder: str, study: Configuration) -> dict[str, Step]:
    """Return the steps of the products of a folder that a study has."""
    return {
        name: Step(
            product.make,
            [study.file(file) for file in product.files(study)],
            inputs_of(product, study),
            settings_of(product, study),
            untimed=UNTIMED,
            priority=product.priority,
            group=folder,
        )
        for name, product in products_of(folder).items()
        if product.when(study)
    }


def inputs_of(product: Product, study: Configuration) -> dict[str, Any]:
    """Return the paths of the files that a product reads, by name; an empty list for none.

    They are of `NEEDS`, all ``joints``, or tables and datasets that products of the folder make.
    """
    paths: dict[str, Any] = {"joints": study.file(f"{product.folder}.nc")}
    for other in products_of(product.folder).values():
        made, files = other.when(study), map(Path, other.files(study))
        data = (file for file in files if file.suffix in (".csv", ".nc"))
        paths |= {file.stem: made and study.file(str(file)) for file in data}
    paths |= {name: NEEDS[name](study) for name in product.reads if name in NEEDS}
    return {name: paths[name] or [] for name in product.reads if name in paths}


def settings_of(product: Product, study: Configuration) -> dict[str, Any]:
    """Return the settings [SI] that a product reads: `SETTINGS`, as their types state, or keys."""
    own = study.study_sections.get(product.folder)
    sections = own, study, study.study, study.statistics, study.output
    hints = typing.get_type_hints(product.make, include_extras=True)

    def stated(name: str) -> Any:
        if name in SETTINGS:
            return SETTINGS[name](study)
        for made in getattr(hints.get(name), "__metadata__", ()):
            return made(study)
        for part in sections:
            if hasattr(part, name):
                return getattr(part, name)
        what = "no table of its study, and no key of its section or of the study"
        raise ValueError(f"{product.make.__name__}: parameter {name!r} is {what}")

    files = inputs_of(product, study)
    return {name: stated(name) for name in product.reads if name not in files}
