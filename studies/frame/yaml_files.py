"""Configuration files: plain YAML, read strictly, and the files of the package."""

import copy
import functools
import json
import re
import reprlib
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml

from jointclosure.inputs import InputError
from jointclosure.storage.files import read_text
from jointclosure.storage.provenance import origin

_STUDIES = Path(__file__).parents[1]
DEFAULT = _STUDIES.parent / "config/default.yaml"
"""The paper's study; every other configuration is merged over it."""
PAPER_TABLE_3 = _STUDIES / "paper/paper_table_3.csv"
"""The paper's Table 3."""

_MOST_VALUES, _DEEPEST = 100_000, 40
_DECIMAL = re.compile(r"[-+]?(0|[1-9][0-9]*)$|[-+]?([0-9]*\.[0-9]*([eE][-+]?[0-9]+)?|\.(inf|nan))$")


def folder_of(part: Any) -> str:
    """Return the folder of `studies` in which a function or a type is defined."""
    return part.__module__.split(".")[1]


class ConfigurationError(InputError):
    """Error of a configuration; the message lists all problems."""


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Loader of plain YAML that refuses what YAML reads differently from its appearance."""

    def construct_mapping(self, node, deep=False):
        keys = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode))
        twice = [key for key, count in keys.items() if count > 1]
        if twice:
            line = [key for key, _ in node.value if key.value == twice[0]][1].start_mark.line
            raise yaml.constructor.ConstructorError(
                problem=f"line {line + 1}: the key {twice[0]} must be given once"
            )
        return super().construct_mapping(node, deep)

    def decimal(self, node):
        """Read a decimal number; YAML reads 1:30 as 90, and 010 as 8."""
        if not _DECIMAL.match(node.value.lower()):
            raise yaml.constructor.ConstructorError(
                problem=f"line {node.start_mark.line + 1}: {node.value} must be a decimal number, "
                "or in quotes if it is a text"
            )
        integer = node.tag.endswith(":int")
        return self.construct_yaml_int(node) if integer else self.construct_yaml_float(node)


for _kind in ("int", "float"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_kind}", _Loader.decimal)


def read_plain(path: str | Path) -> dict:
    """Read a configuration file as plain data, and refuse anything else."""
    try:
        settings = yaml.load(read_text(path), Loader=_Loader)
        reason = _not_plain(settings)
    except InputError as error:  # not a text
        raise ConfigurationError(str(error)) from None
    except OSError as error:
        reason = "file not found" if not Path(path).exists() else str(error.strerror or error)
    except (yaml.YAMLError, ValueError) as error:
        where = getattr(error, "problem_mark", None)
        line = f"line {where.line + 1}: " if where else ""
        problem = getattr(error, "problem", None) or " ".join(str(error).split())
        reason = f"not plain YAML: {line}{problem}"
    except RecursionError:
        reason = "not plain YAML: nested too deeply"
    if reason:
        raise ConfigurationError(f"{path}: {reason}")
    return settings


def _not_plain(settings: object) -> str:
    """Return what is wrong with data that are too deep, too large with aliases, or not plain."""
    if settings is None:
        return "is empty, must contain keys and values"
    if not isinstance(settings, dict):
        return f"must contain keys and values, not {short(settings)}"
    if "__use_yte__" in settings:
        return "__use_yte__: must be left out; Snakemake would run the Python in templates"
    waiting: list[tuple[object, int]] = [(settings, 0)]
    count = 0
    while waiting:
        value, depth = waiting.pop()
        count += 1
        if depth > _DEEPEST:
            return (
                f"an alias refers to itself, or values are nested more than {_DEEPEST} levels deep"
            )
        if count > _MOST_VALUES:
            return f"its aliases expand to more than {_MOST_VALUES} values; write them out"
        if isinstance(value, dict):
            if odd := [key for key in value if not isinstance(key, str)]:
                return f"the key {odd[0]!r} must be a text"
            waiting += [(part, depth + 1) for part in value.values()]
        elif isinstance(value, list):
            waiting += [(part, depth + 1) for part in value]
        elif not isinstance(value, str | int | float | None):  # YAML reads dates
            return f"{value}: is a {type(value).__name__}; quote a text"
    return ""


def overlaid(keys: dict, changes: dict) -> dict:
    """Nested keys with others over them; what does not change is not copied."""
    return keys | {
        name: overlaid(keys[name], value)
        if isinstance(value, dict) and isinstance(keys.get(name), dict)
        else value
        for name, value in changes.items()
    }


def merged(*settings: dict) -> dict:
    """Nested settings, later ones over earlier ones, as a copy."""
    return copy.deepcopy(functools.reduce(overlaid, settings, {}))


def refuse(problems: Iterable[str], what: str = "configuration") -> None:
    """Raise `ConfigurationError` where there are problems, one line each."""
    if lines := "".join(f"\n  {line}" for line in dict.fromkeys(problems)):
        raise ConfigurationError(f"{what}:{lines}") from None


def short(value: object) -> str:
    """Format a value for a message, in one line of limited length."""
    text = reprlib.repr(value) if isinstance(value, dict | list) else repr(value)
    return text if len(text) <= 100 else f"{text[:97]}..."


def provenance(configuration: dict[str, Any]) -> dict[str, str]:
    """Return `origin` with a configuration, without the split of work over jobs, and its seed."""
    return origin() | {
        "configuration": configuration_text(configuration),
        "root_seed": str(configuration["study"]["root_seed"]),
        "provenance_realizations_per_job": str(configuration["study"].get("realizations_per_job")),
    }


def configuration_text(configuration: dict[str, Any]) -> str:
    """Return a configuration as JSON, without the split of work over jobs."""
    study = dict(configuration["study"])
    study.pop("realizations_per_job", None)
    return json.dumps(configuration | {"study": study}, sort_keys=True)
