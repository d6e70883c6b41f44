"""Keys of the model: effects that act, and what the paper leaves open."""

from typing import Literal

from studies.frame.config.keys.entries import Keys, entry


class EffectKeys(Keys):
    """Effects that act; interaction needs substrate, gouge needs breakage."""

    substrate: bool = entry("Substrates deform, Eqs. (6) and (7).")
    interaction: bool = entry("Contacts displace each other, Eqs. (17) and (18).")
    breakage: bool = entry("Overloaded asperities break.")
    gouge: bool = entry("Broken material fills the valleys around.")
    soft_peaks: bool = entry("Peaks have a lower modulus than the rock.")
    auto: float | None = entry(
        "Relative change of a mean maximum closure below which an effect that is true is left out, "
        "decided for each rock by a pilot; null: none is. `effects: auto` is short for all effects "
        "and 0.02.",
        gt=0,
        lt=1,
    )


class ChoiceKeys(Keys):
    """Decisions that the paper leaves open."""

    base_radius_in_cells: float = entry(
        "Base radius r of an asperity over the grid spacing.", gt=0, le=1
    )
    peak_modulus_ratio: float = entry("Young's modulus of a peak over the rock's.", gt=0, le=1)
    concave: Literal["magnitude", "flat"] = entry(
        "How valleys and saddles count. magnitude: by the size of their curvature; flat: such a "
        "cell of a wall is level, and only the other wall's asperity gives the pair a curvature."
    )
    peaks: Literal["pristine", "current"] = entry(
        "Whether peaks are those of the walls before loading, or of the walls as they are."
    )
    largest_radius_mm: float | None = entry(
        "Upper bound of each wall's Gaussian radius [mm]; null for none, the paper's.", gt=0
    )
    tie_tolerance: float = entry(
        "Difference in height that counts as lower, over the walls' rms height.", gt=0, lt=0.001
    )
