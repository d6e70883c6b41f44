"""Conditions of a joint from the options of a command, checked as keys of a configuration.

Of the commands that close a joint this module alone knows the configuration of studies, for
``--config`` and ``--set``.
"""

from jointclosure.cli.joint_options import NEEDED, OPTIONS
from jointclosure.engine.scanned_joint import RESOLVED
from jointclosure.inputs import InputError
from jointclosure.joint.conditions import Conditions
from jointclosure.joint.loading import load_cycles, usual_seating
from jointclosure.joint.rocks import matching
from jointclosure.parameters.units import in_unit
from jointclosure.storage.text import read_csv
from studies.frame.config.configuration import Configured, configured, merged, merged_study
from studies.frame.config.files import read_plain
from studies.frame.config.presets import CHOSEN_BY
from studies.frame.config.rocks import other_rocks

_UNNAMED = "rock"
"""Name of a rock that is given by its properties."""


def base_keys(arguments) -> dict:
    """Return the checked keys of the configuration of the joint, including the named rock.

    A rock of the package that is in no study is added to the rocks of the study.
    """
    base = merged_study(*([arguments.config] if arguments.config else []))
    configured(base, read_csv)
    if arguments.rock:
        known = other_rocks() | base["rocks"]
        name = matching(arguments.rock, known)
        if name is None:
            listed = ", ".join(base["rocks"] | known)
            raise InputError(f"--rock {arguments.rock}: must be one of {listed}")
        arguments.rock, base["rocks"][name] = name, known[name]
    return base


def joint_configuration(
    base: dict, arguments, rock: dict, changes: dict, needed: tuple[str, ...] = NEEDED
) -> tuple[Configured, Conditions]:
    """Return the checked configuration of the arguments, and the conditions of the joint.

    To the keys ``base`` are added those of the ``rock`` and other ``changes``. Without a named rock
    the options ``needed`` must be given.
    """
    given = {name: value for name, value in vars(arguments).items() if value is not None}
    if isinstance(given.get("stress"), tuple):
        given["stress"] = max(arguments.stress)
    rock = rock | {key: given[option] for option, key in OPTIONS.items() if option in given}
    name = arguments.rock or _UNNAMED
    base["rocks"].setdefault(name, {})["levels"] = {}
    if not arguments.rock:
        missing = ["--" + option.replace("_", "-") for option in needed if option not in given]
        if missing:
            raise InputError(
                f"without --rock (such as --rock granite): {', '.join(missing)} must be given"
            )
        rock["title"] = "Rock"
    if arguments.without:  # effects of the rock have priority over those of the study
        rock["effects"] = dict.fromkeys(arguments.without, False)
    changes = merged({"study": {"rocks": [name]}, "rocks": {name: rock}}, changes)
    if "cycles" in given:
        changes["study"]["cycles"] = given["cycles"]
    if given.get("flow"):
        changes["flow"] = True
    changes["seating_stress_MPa"] = given.get("seating", _seating(base, arguments, rock))
    stated = _settings(arguments)
    keys = merged(base, changes, stated)
    if "jrc" in needed and not {"jrc", "walls"} & keys["rocks"][name].keys():
        raise InputError(f"--rock {name}: has no roughness, --jrc must be given")
    settings = configured(keys, read_csv)
    if settings.typed.numerics.breakage != "resolved" and "tolerance" in stated.get("numerics", {}):
        raise InputError(
            "--set numerics.tolerance: has no effect on fixed steps of breakage, needs "
            "numerics.breakage=resolved"
        )
    conditions = _conditions(settings, name, arguments)
    conditions.checked(given.get("snapshots", ()))
    return settings, conditions


def _conditions(settings: Configured, name: str, arguments) -> Conditions:
    """Return the conditions of the configuration, with the load history of --stress if it is one.

    The spacing is that of the grid; scanned walls may have another one.
    """
    typed, rock = settings.typed, settings.typed.rocks[name]
    load: float | tuple[float, ...] = rock.max_normal_stress
    cycles = typed.study.cycles
    if isinstance(getattr(arguments, "stress", None), tuple):
        load = tuple(1e6 * stress for stress in arguments.stress)
        cycles = len(load_cycles(load, arguments.cycles))
    return Conditions(
        typed.grid.spacing, rock.intact, load, cycles, typed.seating_stress, rock.effects,
        typed.choices, typed.numerics, typed.flow, typed.study.unusual_values == "allow",
    )  # fmt: skip


def _seating(base: dict, arguments, rock: dict) -> float:
    """Return the seating stress [MPa] of the configuration, or the usual one of a stated load."""
    stated = base["seating_stress_MPa"]
    stress = getattr(arguments, "stress", None) or rock.get("max_normal_stress_MPa")
    if stress is None or stated != merged_study()["seating_stress_MPa"]:
        return stated
    maxima = stress[::2] if isinstance(stress, tuple) else (stress,)
    return min(stated, 1e-6 * usual_seating(1e6 * min(maxima)))


def resolved_breakage(arguments) -> dict:
    """Return the numerics of a scanned or measured joint as keys, without those that are stated.

    There are none if the rule of breakage, or a key that selects it, is stated.
    """
    files = [read_plain(arguments.config)] if arguments.config else []
    stated = merged(*files, _settings(arguments)).get("numerics") or {}
    if not isinstance(stated, dict) or {"breakage", *CHOSEN_BY} & stated.keys():
        return {}
    about = RESOLVED._asdict()
    steps = {f"{name}_um": in_unit(about[name], "um") for name in about if name.endswith("_step")}
    keys = {name: about[name] for name in ("breakage", "tolerance")} | steps
    return {"numerics": {name: keys[name] for name in keys.keys() - stated.keys()}}


def _settings(arguments) -> dict:
    """Return the keys of all --set; a key with two values is an error."""
    together = merged(*arguments.set)
    for setting in arguments.set:
        if merged(together, setting) != together:
            path, value = [], setting
            while isinstance(value, dict) and len(value) == 1:
                ((key, value),) = value.items()
                path.append(key)
            raise InputError(f"--set {'.'.join(path)}={value}: another value is set as well")
    return together
