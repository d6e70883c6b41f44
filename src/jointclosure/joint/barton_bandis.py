"""Barton-Bandis law for mated joints, for comparison; it is not measured data."""

from typing import Any, NamedTuple

import numpy as np


class BartonBandis(NamedTuple):
    """Aperture a_j and largest closure V_m [m], initial stiffness K_ni [Pa/m]."""

    aperture: float
    largest_closure: float
    initial_stiffness: float

    def closure(self, normal_stress: float | np.ndarray) -> Any:
        """Return the closure [m] at a normal stress [Pa], dV = sigma V_m / (K_ni V_m + sigma)."""
        stress = np.asarray(normal_stress, dtype=float)
        asymptote = self.initial_stiffness * self.largest_closure
        return stress * self.largest_closure / (asymptote + stress)

    def since(self, normal_stress: float) -> "BartonBandis":
        """Return the same law with stress and closure counted from a normal stress [Pa]."""
        rise = 1.0 + normal_stress / (self.initial_stiffness * self.largest_closure)
        left = self.largest_closure - float(self.closure(normal_stress))
        return self._replace(
            initial_stiffness=self.initial_stiffness * rise**2, largest_closure=left
        )

    def results(self, normal_stress: float, seating: float = 0.0) -> dict[str, float]:
        """Return results [SI] of a loading to a stress [Pa] by the names of the model's.

        For a law ``since`` a seating stress [Pa] that is the ``seating``.
        """
        half, whole = self.closure(np.array([0.5, 1.0]) * normal_stress - seating)
        return {
            "kni_net": self.initial_stiffness,
            "vm_net": self.largest_closure,
            "stiffness_net": 0.5 * normal_stress / float(whole - half),
            "max_closure_seated_net": float(whole),
        }


# A, B, C, D of V_m = A + B JRC + C (JCS/a_j)^D [mm, MPa]. Those of cycle 3 stand in `bartonBandis`
# of the MATLAB Reservoir Simulation Toolbox too; those of cycle 2 are quoted from memory, and no
# public source of them was seen.
_CONSTANTS = {
    1: (-0.2960, -0.0056, 2.2410, -0.2450),
    2: (-0.1005, -0.0073, 1.0082, -0.2301),
    3: (-0.1032, -0.0074, 1.1350, -0.2510),
}
CYCLES = tuple(_CONSTANTS)
"""Cycles that the law has constants for."""
UNCHECKED = (2,)
"""Cycles whose constants were not checked against a source."""


def scaled_to(
    length: float, jrc: float, strength: float, reference_length: float
) -> tuple[float, float]:
    """Scale JRC and JCS [Pa] to a joint of another length (Barton & Bandis 1982)."""
    ratio = length / reference_length
    return jrc * ratio ** (-0.02 * jrc), strength * ratio ** (-0.03 * jrc)


def law_holds(jrc: float) -> bool:
    """Return whether a roughness is in the range of the law, JRC 5 to 15."""
    return 5.0 <= jrc <= 15.0


def barton_bandis(
    jrc: float, compressive_strength: float, strength_ratio: float, cycle: int
) -> BartonBandis:
    """Return the constants of the law for a joint.

    Bandis, Lumsden & Barton 1983 and Barton, Bandis & Bakhtar 1985: a_j = (JRC/5)(0.2 sigma_c/JCS -
    0.1) mm, K_ni = -7.15 + 1.75 JRC + 0.02 JCS/a_j MPa/mm, V_m as above.
    """
    a, b, c, d = _CONSTANTS[cycle]
    wall_strength = compressive_strength / strength_ratio * 1e-6
    aperture = jrc / 5.0 * (0.2 * strength_ratio - 0.1)
    largest = a + b * jrc + c * (wall_strength / aperture) ** d
    stiffness = -7.15 + 1.75 * jrc + 0.02 * wall_strength / aperture
    return BartonBandis(aperture * 1e-3, largest * 1e-3, stiffness * 1e9)


class JointLaws(NamedTuple):
    """Laws of a joint by cycle since its seating stress [Pa], of its JRC and JCS [Pa]."""

    jrc: float
    strength: float
    seating: float
    by_cycle: dict[int, BartonBandis]

    def sentence(self) -> str:
        """Describe the laws, and their constants from zero stress."""
        if not self.by_cycle:
            return (
                f"Barton-Bandis: left out, as it holds for JRC 5 to 15, and not for {self.jrc:.2g}"
            )
        first = barton_bandis(self.jrc, self.strength, 1.0, 1)
        return (
            f"Barton-Bandis: empirical law of mated joints for JRC {self.jrc:.2g} (by the slope of "
            f"both walls) and JCS {1e-6 * self.strength:.3g} MPa, the strength, from "
            f"{1e-6 * self.seating:g} MPa on; from 0 MPa on its first cycle has kni "
            f"{1e-9 * first.initial_stiffness:.2g} MPa/mm and Vm "
            f"{1e3 * first.largest_closure:.2g} mm"
        )


def laws_of_joint(jrc: float, strength: float, seating: float, cycles: int) -> JointLaws:
    """Return the laws of a joint of a strength [Pa] whose walls are not weathered."""
    laws = {}
    for cycle in CYCLES[: cycles if law_holds(jrc) else 0]:
        law = barton_bandis(jrc, strength, 1.0, cycle)
        if min(law) > 0.0:
            laws[cycle] = law.since(seating)
    return JointLaws(jrc, strength, seating, laws)
