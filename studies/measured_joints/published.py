"""Files of the measured granodiorite joints, in clones of the two public repositories.

The repositories have no licence, so none of their files is part of this package. A folder that
contains both clones has, for a joint n (1 to 3):

- ``hm_data/ethz_-_specimen_vd<n>_sigmaZ_vs_fractureClosure_hm1.txt``: later loading and unloading;
  a line of names, a line of units, then number, sensor displacement [mm], stress [MPa];
- ``data/vd<n>/ethz_vd<n>_120.X.txt``, ``.Y.txt`` [m] and ``.Z.txt`` [MPa]: map of contact stress
  under 120 kN, numbers with spaces between them;
- ``surface_scans``: walls as STL files, whose paths contain ``vd<n>a`` (upper) and ``vd<n>b``
  (lower), and ``post`` after testing. Their full names are not documented.
"""

import math
from pathlib import Path

import numpy as np

from jointclosure.engine.measured_joints import measured
from jointclosure.inputs import InputError
from jointclosure.measured.curves import parsed_curve
from jointclosure.storage.files import read_text

FILM_THRESHOLD = 2.5
"""Contact stress above which the film counts as in contact [MPa]."""
UNLOADED = 0.02
"""Largest excess of the last stress over the first, over the maximum, of a joint that was unloaded.
It is 0.001 at most in the published files."""


def file_named(folder: Path, name: str) -> Path:
    """Return the one file of a name below a folder; `InputError` if there is none, or several."""
    files = sorted(folder.rglob(name))
    if len(files) != 1:
        count = f"{len(files)} files of this name" if files else "no such file"
        raise InputError(f"{folder}: {name}: {count}, must be one")
    return files[0]


def _matrix(path: Path) -> np.ndarray:
    """Read finite numbers with blanks between them as an array (lines, columns)."""
    try:
        matrix = np.loadtxt(read_text(path).splitlines(), ndmin=2)
    except ValueError as error:
        raise InputError(f"{path}: lines of equally many numbers expected: {error}") from None
    if not np.isfinite(matrix).all():
        raise InputError(f"{path}: {np.sum(~np.isfinite(matrix))} values are not finite")
    return matrix


def later_loading(folder: Path, joint: str) -> tuple[dict[str, float], list[str]]:
    """Read the observables of a later loading, net of the rock, as in ``measured_joints.csv``."""
    path = file_named(folder, f"ethz_-_specimen_vd{joint}_sigmaZ_vs_fractureClosure_hm1.txt")
    curve = parsed_curve(read_text(path), str(path), cycle=1, names=("3", "2"))
    sensor, stress = 1e3 * curve.closure, 1e-6 * curve.stress
    top = int(stress.argmax())
    if not 1 < top < len(stress) - 1 or (np.diff(stress[: top + 1]) <= 0.0).any():
        raise InputError(f"{path}: stress must rise to its maximum, and fall after it")
    net = sensor - measured("rock_compliance").value * (stress - stress[0])
    net -= net[0]
    half = float(np.interp(0.5 * stress[top], stress[: top + 1], net[: top + 1]))
    unloaded = stress[-1] <= stress[0] + UNLOADED * stress[top]
    reason = (
        f"later_residual_share of joint {joint} is missing: {path.name} ends at "
        f"{stress[-1]:.3g} MPa, before the joint was unloaded to {stress[0]:.3g} MPa"
    )
    return {
        "later_closure": float(net[top]),
        "later_stiffness": float(0.5 * stress[top] / (net[top] - half)),
        "later_residual_share": float(100.0 * net[-1] / net[top]) if unloaded else math.nan,
    }, [reason] * (not unloaded)


def film(folder: Path, joint: str) -> dict[str, float]:
    """Read the map of contact stress at the largest load."""
    paths = [file_named(folder, f"ethz_vd{joint}_120.{axis}.txt") for axis in "XYZ"]
    x, y, stress = map(_matrix, paths)
    if not x.shape == y.shape == stress.shape:
        raise InputError(f"{paths[2]}: shape {stress.shape}: must be that of X and Y, {x.shape}")
    inside = stress[np.hypot(x, y) < 0.5e-3 * measured("side").value]
    if not inside.size:
        raise InputError(f"{paths[0]}: no point within the specimen: are X and Y in metres?")
    return {
        "contact_share": float(100.0 * (inside > FILM_THRESHOLD).mean()),
        "recovered_load": float(100.0 * inside.mean() / measured("largest_stress").value),
    }


def scans(folder: Path, joint: str) -> tuple[Path, Path] | None:
    """Return the files of upper and lower wall before testing; None if there are no scans."""
    files = [path for path in sorted(folder.rglob("*")) if path.suffix.lower() == ".stl"]
    if not files:
        return None
    names = {path: path.relative_to(folder).as_posix().lower() for path in files}
    walls = []
    for side in "ab":
        wall = f"vd{joint}{side}"
        here = [path for path, name in names.items() if wall in name and "post" not in name]
        if len(here) != 1:
            there = [names[path] for path in here or names][:5]
            raise InputError(
                f"{folder}: {len(here)} scans of wall {wall} before testing, must be one "
                f"(STL files without 'post' in their path), such as {', '.join(there) or 'none'}"
            )
        walls += here
    return walls[0], walls[1]
