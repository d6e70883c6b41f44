"""A made-up study and its page: a rock of the paper, one that is not, and a joint that failed."""

import json
from pathlib import Path

import numpy as np
import pytest

from jointclosure.joint.curves import ATTRIBUTES
from jointclosure.parameters import Effects, scene_name
from jointclosure.statistics.repetitions import Design
from jointclosure.storage.files import read_csv
from studies.frame.configuration import model, resolved
from studies.frame.keys import json_schema
from studies.frame.yaml_files import PAPER_TABLE_3, provenance
from studies.paper.checks import check_results
from studies.paper.closures import elasticity_table, indifference_table, max_closure_table
from studies.paper.judged_claims import Evidence, judge_claims
from studies.paper.layout import with_paper
from studies.paper.predictive import joint_table, predictive, predictive_table
from studies.paper.report.content import Material
from tests.studied import DEFAULT
from tests.world import world

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
    granite = {"title": GRANITE, "youngs_modulus_GPa": 60, "poisson_ratio": 0.2, "jrc": 9}
    granite |= {"compressive_strength_MPa": 180, "max_normal_stress_MPa": 20}
    granite["levels"] = {"youngs_modulus_GPa": [50, 55, 65, 70], "jrc": [8, 10]}
    settings["rocks"]["granite"] = granite
    return settings


@pytest.fixture(scope="session")
def study(configuration):
    """In every case one joint failed, and one jumped over the target."""
    joined = world(resolved(configuration))
    status = np.zeros(joined.seed.shape, dtype=np.int16)
    status[:, FAILED], status[:, JUMPED] = 16, 1
    per_joint = {"least_force": 0.0, "volume_error": 1e-16, "largest_residual": 1e-9}
    joined = joined.assign(
        status=(joined.seed.dims, status, ATTRIBUTES["status"]),
        stiffness_net=1e6 / joined.max_closure,
        unloading_excess=0.0 * joined.max_closure,
        **{name: (joined.seed.dims, np.full(status.shape, v)) for name, v in per_joint.items()},
    )
    joined = joined.assign_coords(scene=("case", [SCENE] * joined.sizes["case"]))
    joined.attrs = {"references": "the paper"} | provenance(configuration)
    return joined


@pytest.fixture(scope="session")
def material(study, configuration, default):
    paper = read_csv(PAPER_TABLE_3)
    intervals = with_paper(indifference_table(study, resolved(configuration).statistics, 1), paper)
    claims, margins = judge_claims(Evidence(study, study, Design(), 100, 1, 3), paper)
    drawn = predictive(study, Design(), 100, 1, pools=3)
    tables = {
        "max_closure": max_closure_table(study),
        "checks": check_results(study, resolved(configuration).numerics, JOINTS),
        "table_3_indifference": intervals,
        "claims": claims,
        "claim_margins": margins,
        "table_3_predictive": predictive_table(drawn, paper),
        "table_3_joint_tests": joint_table(drawn, paper),
        "elasticities": elasticity_table(study),
    }
    return Material(
        study=study,
        tables=tables,
        paper=paper,
        default=default,
        schema=json_schema(model()),
        pictures={},
    )
