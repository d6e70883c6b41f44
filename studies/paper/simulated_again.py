"""Single joints of a finished study, simulated again for their steps, which no dataset has."""

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
    """Simulate a joint of a study again by the configuration in its dataset; return all steps."""
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
    """Read the keys of a dataset; those that it lacks (see `closed_keys`) have their defaults."""
    return read_stored(merged(merged_study(), json.loads(stated)))
