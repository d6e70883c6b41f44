"""Single joints of a finished study, simulated again for all their steps, which no dataset has."""

import json
from functools import lru_cache

import xarray as xr

from jointclosure.ensembles.simulation import simulated_joint
from jointclosure.parameters import scene_of
from studies.frame.cases import block_settings, cases_of
from studies.frame.configuration import Configuration, merged_study, read_stored
from studies.frame.scanned_walls import cut_walls, walls_of_files
from studies.frame.settings import walls_of
from studies.frame.yaml_files import merged


def simulate_again(study: xr.Dataset, case: str, realization: int) -> xr.Dataset:
    """Return all steps of a joint of a finished study, which is simulated again.

    The study is its dataset, which has its configuration, and ``case`` is a label. The joint is
    simulated with the effects of the case, and without flow.
    """
    scene = str(study.scene.sel(case=case).item())
    return _closed(study.attrs["configuration"], scene, case, realization)


@lru_cache(maxsize=16)
def _closed(stated: str, scene: str, label: str, realization: int) -> xr.Dataset:
    whole = _configuration(stated)
    case = next(case for case in cases_of(whole) if case.label == label)
    settings = block_settings(whole, case, range(realization, realization + 1))
    settings = settings.under(effects=scene_of(scene), flow=False)
    scans = whole.rocks[case.rock].walls
    if scans:
        unusual = whole.study.unusual_values == "allow"
        about = settings.grid.spacing, settings.surface.jrc_relation, unusual
        pairs = cut_walls(walls_of_files(scans, *about), settings)
    else:
        pairs = walls_of(settings)
    return simulated_joint(next(iter(pairs)), settings.conditions).closed


def _configuration(stated: str) -> Configuration:
    """Return the configuration that a dataset stores as JSON.

    Keys that it lacks (see `studies.frame.cases.closed_keys`) have their defaults.
    """
    return read_stored(merged(merged_study(), json.loads(stated)))
