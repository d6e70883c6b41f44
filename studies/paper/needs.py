"""Files and settings that products of the paper's study read, by the names of their parameters."""

import os
from pathlib import Path

from jointclosure.statistics.repetitions import Design
from studies.frame.cases import dataset_of, ensembles_of
from studies.frame.configuration import Configuration
from studies.frame.plan import NEEDS, SETTINGS, UNTIMED, Need
from studies.frame.yaml_files import DEFAULT, PAPER_TABLE_3, read_plain
from studies.paper.measured import CurveSettings
from studies.paper.products import pooled, variates


def curve_settings(study: Configuration) -> dict[str, CurveSettings]:
    """Settings of the measured curves by rock, for rocks of the study that have one."""
    cycles, seating = study.study.cycles, study.seating_stress
    return {
        name: CurveSettings(rock.measured, rock.max_normal_stress, cycles, seating)
        for name, rock in study.rocks.items()
        if rock.measured
    }


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

NEEDS |= BESIDE | {
    "study": lambda study: study.file("study.nc"),
    "finest": lambda study: study.file("finest.nc"),
    "first_walls": lambda study: study.file("first_walls.nc"),
    "lengths": lambda study: study.file("predictive.nc"),
    # relative, so that results are still valid where the whole folder was moved
    "paper": lambda study: os.path.relpath(PAPER_TABLE_3),
    "pool": lambda study: study.file("pool.nc" if pooled(study) else "study.nc"),
    "ensembles": lambda study: [study.file(dataset_of(name)) for name in ensembles_of(study)],
    "pool_covariates": lambda study: (
        variates(study) and study.file("pool_covariates.nc" if pooled(study) else "covariates.nc")
    ),
    # they precede Table 3 by paired tests
    "elasticities": lambda study: (
        study.study.draws == "common" and study.file("tables/elasticities.csv")
    ),
    "curve_files": lambda study: [curve.measured.file for curve in curve_settings(study).values()],
}

SETTINGS |= {
    "curves": curve_settings,
    "closed_by": lambda study: {
        name: (part.study.realizations, part.numerics) for name, part in ensembles_of(study).items()
    },
    # intervals do not depend on its other parts
    "statistics": lambda study: study.statistics._replace(repetitions=0, control_variates=None),
    "design": lambda study: Design(study.study.realizations, study.statistics.significance),
}
UNTIMED |= BESIDE.keys()
