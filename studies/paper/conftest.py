"""A made-up study and its page: a rock of the paper, one that is not, and a joint that failed."""

import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from jointclosure.cli.page import Picture
from jointclosure.compilation.sources import ROOTS
from jointclosure.engine.aggregation import join_cases
from jointclosure.joint.history import ATTRIBUTES
from jointclosure.parameters import Effects, scene_name
from jointclosure.statistics.drawn_studies import Design
from jointclosure.storage.provenance import provenance
from jointclosure.storage.text import read_csv
from studies.frame.config.configuration import resolved
from studies.frame.config.files import MEASURED, PAPER_TABLE_3
from studies.frame.config.keys.configuration import ConfigurationKeys
from studies.frame.config.schema import json_schema
from studies.frame.ensemble.cases import cases_of
from studies.frame.ensemble.checks import check_results
from studies.paper.closures import elasticity_table, indifference_table, max_closure_table
from studies.paper.judged_claims import Evidence, judge_claims
from studies.paper.layout import with_paper
from studies.paper.predictive import joint_table, predictive, predictive_table
from studies.paper.report.captions import read_caption
from studies.paper.report.content import Material, content
from studies.paper.report.page import render
from tests.studied import DEFAULT

ROOT = Path(__file__).parents[2]
GRANITE = "Granite </script><b>of & sons"
JOINTS = 23
FAILED, JUMPED = 3, 5
SCENE = scene_name(Effects())


@pytest.fixture(scope="session")
def default():
    return DEFAULT


@pytest.fixture(scope="session")
def configuration(default):
    """Slate as in the paper, but for two parameters only; granite with five levels of E."""
    settings = json.loads(json.dumps(default))
    settings["study"] |= {"name": "made_up", "rocks": ["slate", "granite"], "realizations": JOINTS}
    settings["statistics"]["bootstrap_resamples"] = 10
    settings["rocks"]["granite"] = {
        "title": GRANITE, "youngs_modulus_GPa": 60, "poisson_ratio": 0.2,
        "compressive_strength_MPa": 180, "jrc": 9, "max_normal_stress_MPa": 20,
        "levels": {"youngs_modulus_GPa": [50, 55, 65, 70], "jrc": [8, 10]},
    }  # fmt: skip
    return settings


@pytest.fixture(scope="session")
def study(configuration):
    """Curves of a made-up law; in every case one joint failed, and one jumped over the target."""
    cases = cases_of(resolved(configuration))
    joined = join_cases(cases, [_closed(case, i) for i, case in enumerate(cases)])
    joined = joined.assign_coords(scene=("case", [SCENE] * len(cases)))
    joined.attrs = {"references": "the paper"} | provenance(configuration)
    return joined


def _closed(case, number: int) -> xr.Dataset:
    random = np.random.default_rng(number)
    stress = np.linspace(0.0, 30e6, 13)
    scale = (random.lognormal(0.0, 0.1, JOINTS) * case.jrc / case.intact.youngs_modulus)[:, None]
    loading = 1e6 * scale * stress / (stress + 1e7)
    closure = np.empty((JOINTS, 2, 2, stress.size))
    closure[:, 0, 0], closure[:, 0, 1] = loading, 0.5 * (loading + loading[:, -1:])
    closure[:, 1, 0] = closure[:, 1, 1] = closure[:, 0, 1]
    closure[..., stress > case.max_normal_stress] = np.nan
    status = np.zeros(JOINTS, dtype=np.int16)
    status[FAILED], status[JUMPED] = 16, 1
    closure[FAILED] = np.nan
    at = int(np.argmin(np.abs(stress - case.max_normal_stress)))
    largest = closure[:, 0, 0, at].copy()
    closure[JUMPED, 0, :, at] = np.nan
    per_cycle = np.stack([largest, 0.5 * largest], axis=1)
    over = ("realization", "cycle")
    per_joint = {"least_force": 0.0, "volume_error": 1e-16, "largest_residual": 1e-9}
    return xr.Dataset(
        {
            "closure": (("realization", "cycle", "branch", "stress"), closure),
            "status": ("realization", status, ATTRIBUTES["status"]),
            "max_closure": (over, per_cycle),
            "max_closure_net": (over, 0.9 * per_cycle),
            "max_closure_seated": (over, 0.8 * per_cycle),
            "max_closure_seated_net": (over, 0.7 * per_cycle),
            "residual_closure": (over, np.repeat(closure[:, 0, 1, :1], 2, axis=1)),
            "residual_closure_seated_net": (over, 0.5 * per_cycle),
            "stiffness_net": (over, 1e6 / per_cycle),
            "unloading_excess": (over, 0.0 * per_cycle),
            "timing_simulation": ("realization", random.uniform(1.0, 2.0, JOINTS)),
            **{name: ("realization", np.full(JOINTS, v)) for name, v in per_joint.items()},
        },
        coords={
            "realization": range(JOINTS), "cycle": [1, 2], "branch": ["loading", "unloading"],
            "stress": stress, "seed": ("realization", [f"{i:032x}" for i in range(JOINTS)]),
        },
    )  # fmt: skip


@pytest.fixture(scope="session")
def pictures(tmp_path_factory, configuration):
    """A plain picture for each caption there is."""
    path = tmp_path_factory.mktemp("figures") / "figure.png"
    figure, _ = plt.subplots()
    figure.savefig(path)
    plt.close(figure)
    return [
        Picture(caption.stem, path.read_bytes(), read_caption(caption.read_text(), configuration))
        for caption in sorted((ROOTS["studies"] / "paper/report/texts").glob("*.rst"))
    ]


@pytest.fixture(scope="session")
def material(study, configuration, default, pictures):
    paper = read_csv(PAPER_TABLE_3)
    closures = max_closure_table(study)
    intervals = with_paper(indifference_table(study, resolved(configuration).statistics, 1), paper)
    claims, margins = judge_claims(Evidence(study, study, Design(), 100, 1, 3), paper)
    drawn = predictive(study, Design(), 100, 1, pools=3)
    numerics = resolved(configuration).numerics
    return Material(
        study=study,
        closures=closures,
        intervals=intervals,
        claims=claims,
        margins=margins,
        predictive=predictive_table(drawn, paper),
        joint=joint_table(drawn, paper),
        elasticities=elasticity_table(study),
        checks=check_results(study, numerics, JOINTS),
        paper=paper,
        default=default,
        schema=json_schema(ConfigurationKeys),
        pictures=pictures,
        benchmarks=pd.DataFrame(
            {
                "rule": ["close_surfaces"] * 2,
                "job": ["a", "b"],
                "s": [3.0, 5.0],
                "max_rss": [1, np.nan],
            }
        ),
        measured=None,
        accuracy=None,
        presets=read_csv(MEASURED),
    )


@pytest.fixture(scope="session")
def page(material):
    return render(content(material))
