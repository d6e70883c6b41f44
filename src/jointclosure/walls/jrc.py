"""Joint roughness coefficient (JRC) and RMS slope (Z2) of walls, and their published relations."""

from typing import Any, NamedTuple

import numpy as np

from jointclosure.inputs import InputError, check_one_of


class Relation(NamedTuple):
    """Published relation of JRC and RMS slope Z2, which is measured at an ``interval`` [m].

    By its ``form`` JRC is a Z2 + b (linear), a log10 Z2 + b (logarithmic) or a Z2^c + b (power). It
    holds from ``smallest_jrc`` to ``largest_jrc``. Its
    ``source`` names authors and year for reading.
    """

    form: str
    a: float
    b: float
    interval: float
    c: float = 1.0
    smallest_jrc: float = 0.0
    largest_jrc: float = 20.0
    source: str = ""

    @property
    def title(self) -> str:
        """Source, form and interval in words: "Yang et al. 2001, logarithmic, 0.5 mm"."""
        return f"{self.source}, {self.form}, {1e3 * self.interval:g} mm"

    def jrc(self, z2: float | np.ndarray) -> Any:
        """Return the JRC for RMS slopes at the relation's interval, also beyond its range."""
        reduced = np.log10(z2) if self.form == "logarithmic" else z2**self.c
        return self.a * reduced + self.b


_YU = "Yu & Vayssade 1991"
_TATONE = "Tatone & Grasselli 2010"
RELATIONS = {
    "yu_vayssade_linear_0.25mm": Relation("linear", 60.32, -4.51, 0.25e-3, source=_YU),
    "yu_vayssade_log_0.25mm": Relation("logarithmic", 28.1, 28.43, 0.25e-3, source=_YU),
    "yu_vayssade_linear_0.5mm": Relation("linear", 61.79, -3.47, 0.5e-3, source=_YU),  # later texts
    "yu_vayssade_linear_1mm": Relation("linear", 64.22, -2.31, 1e-3, source=_YU),  # source not seen
    "tse_cruden": Relation("logarithmic", 32.47, 32.2, 0.5e-3, source="Tse & Cruden 1979"),
    "yang": Relation("logarithmic", 32.98, 32.69, 0.5e-3, source="Yang et al. 2001"),
    "tatone_grasselli_0.5mm": Relation("power", 51.85, -10.37, 0.5e-3, 0.60, source=_TATONE),
    "tatone_grasselli_1mm": Relation("power", 55.03, -6.10, 1e-3, 0.74, source=_TATONE),
    "jang": Relation("power", 51.16, -11.44, 0.5e-3, 0.531, source="Jang et al. 2014"),
}
"""Relations of JRC and Z2 of the literature. That of Tse & Cruden is at about 0.5 mm."""
DEFAULT_RELATION = "yu_vayssade_linear_0.25mm"  # at the spacing of the paper's walls


def z2_of_jrc(jrc: float, spacing: float, hurst: float, relation: str = DEFAULT_RELATION) -> float:
    """Return the RMS slope Z2, at a ``spacing`` [m], of a wall with a JRC and a Hurst exponent.

    The relation gives Z2 at its interval h0. At the spacing h it is Z2(h) = Z2(h0) (h/h0)^(H - 1).
    Raise `InputError` if the relation is unknown or does not hold for this JRC.
    """
    rule = relation_of(relation)
    if not rule.smallest_jrc <= jrc <= rule.largest_jrc:
        limits = f"{rule.smallest_jrc:g} to {rule.largest_jrc:g}"
        raise InputError(f"jrc = {jrc!r}: {relation} holds from {limits}")
    reduced = (jrc - rule.b) / rule.a
    z2 = 10.0**reduced if rule.form == "logarithmic" else reduced ** (1.0 / rule.c)
    return float(z2 * (spacing / rule.interval) ** (hurst - 1.0))


def jrc_of_z2(z2: float, spacing: float, hurst: float, relation: str = DEFAULT_RELATION) -> float:
    """Return the JRC of a wall with an RMS slope ``z2`` at a ``spacing`` [m]: inverse `z2_of_jrc`.

    It may be outside the range of the relation. Raise `InputError` if the relation is unknown.
    """
    rule = relation_of(relation)
    return float(rule.jrc(z2 * (rule.interval / spacing) ** (hurst - 1.0)))


def relation_of(name: str) -> Relation:
    """Return a relation of JRC and Z2 by its key; raise `InputError` for an unknown key."""
    check_one_of("jrc_relation", name, tuple(RELATIONS))
    return RELATIONS[name]


def rms_slope(heights: np.ndarray, spacing: float) -> float:
    """Return Z2 of a wall (y, x) [m], the RMS slope of all its x and y profiles."""
    slopes = [np.diff(heights, axis=axis).ravel() / spacing for axis in (0, 1)]
    return float(np.sqrt(np.mean(np.concatenate(slopes) ** 2)))
