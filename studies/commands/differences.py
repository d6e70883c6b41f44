"""Differences between two datasets, except in provenance and timing."""

import numpy as np
import xarray as xr

MAY_DIFFER = ("provenance_", "timing_")
"""Prefixes of names whose values may differ between two runs of one study."""


def differences(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """List all differences between two datasets except in provenance and timing, one line each."""
    messages = []
    for kind, one, two in (
        ("attribute", first.attrs, second.attrs),
        ("variable", first.variables, second.variables),
    ):
        names = {str(name) for name in [*one, *two]}
        for name in sorted(name for name in names if not name.startswith(MAY_DIFFER)):
            if name not in one or name not in two:
                where = "first" if name in one else "second"
                messages.append(f"{kind} {name}: only in the {where}")
            elif kind == "attribute" and not np.array_equal(one[name], two[name]):
                messages.append(f"attribute {name} differs")
            elif kind == "variable" and (where := _difference(one[name], two[name])):
                messages.append(f"variable {name} differs{where}")
    return messages


def _difference(one: xr.Variable, two: xr.Variable) -> str:
    """Describe how two variables differ; "" if they have the same bits and attributes."""
    numbers = one.dtype.kind in "iuf"
    if one.identical(two) and not (numbers and one.values.tobytes() != two.values.tobytes()):
        return ""
    if one.shape != two.shape or not numbers:
        return f": {one.dtype} {dict(one.sizes)} and {two.dtype} {dict(two.sizes)}"
    unequal = ~((one.values == two.values) | (np.isnan(one.values) & np.isnan(two.values)))
    if not unequal.any():
        return " in its attributes, or in signs of zeros"
    with np.errstate(invalid="ignore"):
        largest = np.nanmax(np.abs(one.values - two.values), initial=0.0)
    return f" in {int(unequal.sum())} of {unequal.size} values, by at most {largest:.3g}"
