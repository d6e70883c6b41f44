"""Rocks of the package that are in no study, as keys of a configuration."""

from jointclosure.joint.rocks import ROCKS
from jointclosure.parameters import OF_ROCK, key_of
from jointclosure.parameters.units import in_unit


def other_rocks() -> dict[str, dict]:
    """Return the keys of the rocks of the package, by name, without a roughness."""
    return {
        name: {"title": rock.title}
        | {key_of(of): in_unit(getattr(rock.intact, of), OF_ROCK[of].unit) for of in OF_ROCK}
        | {"max_normal_stress_MPa": in_unit(rock.max_normal_stress, "MPa")}
        | {"max_normal_stress_is_assumed": True, "levels": {}}
        for name, rock in ROCKS.items()
    }
