"""One realisation of a study again, from its settings."""

import xarray as xr

from jointclosure.study.cases import Case
from jointclosure.study.ensemble import close_surfaces, closing_arguments, surfaces_of


def repeated(settings: dict, realization: int, walls: xr.Dataset | None = None) -> xr.Dataset:
    """Close one surface pair of a case again.

    Parameters
    ----------
    settings : dict
        As from `jointclosure.study.settings.closure_settings`.
    realization : int
        Its number; the settings' block has it.
    walls : Dataset, optional
        The surface pair (realization, y, x), one realisation; made from its seed
        when it is not given.

    Returns
    -------
    Dataset
        As a block of `jointclosure.study.ensemble.close_surfaces`, of one realisation.
    """
    if walls is None:
        one = {"first_realization": realization, "realizations": 1}
        walls = next(surfaces_of(settings["surfaces"] | one))
    case = Case(**settings["case"])
    return next(close_surfaces(walls, case, **closing_arguments(settings)))
