"""Configuration files: plain YAML, checked before it is loaded, merged, and their provenance."""

import copy
import functools
import json
import re
import reprlib
import sys
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from jointclosure.inputs import InputError
from jointclosure.parameters.units import name_and_unit
from jointclosure.storage.files import read_text
from jointclosure.storage.provenance import origin

_STUDIES = Path(__file__).parents[1]
DEFAULT = _STUDIES.parent / "config/default.yaml"
"""Configuration of the paper's study, over which every other configuration is merged."""
PAPER_TABLE_3 = _STUDIES / "paper/paper_table_3.csv"
"""File with the paper's Table 3."""

# Limits of a configuration file. They are checked before the loader builds any value, as large or
# deeply nested values would exhaust memory or the stack.
_MOST_BYTES = 1_000_000
"""Largest size [bytes] of a configuration file."""
_MOST_VALUES = 100_000
"""Largest number of keys and values in a file, with all aliases expanded."""
_DEEPEST = 40
"""Largest number of levels to which keys in a file are nested."""
_DECIMAL = re.compile(r"[-+]?(0|[1-9][0-9]*)$|[-+]?([0-9]*\.[0-9]*([eE][-+]?[0-9]+)?|\.(inf|nan))$")


def folder_of(part: Any) -> str:
    """Return the name of the folder of `studies` in which a function or a class is defined."""
    return part.__module__.split(".")[1]


class ConfigurationError(InputError):
    """Error of a configuration; the message lists all problems."""


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Loader of plain YAML that refuses repeated keys and numbers that are not decimal."""

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
        """Return a decimal number; refuse other forms, as YAML reads 1:30 as 90 and 010 as 8."""
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
    """Return the nested keys of a configuration file, in its units.

    Raise `ConfigurationError` if it cannot be read, exceeds a limit, or is not plain YAML.
    """
    settings = None
    try:
        if not (reason := _no_file(Path(path))):
            text = read_text(path)
            if not (reason := _unbounded(text)):
                settings = yaml.load(text, Loader=_Loader)
                reason = _not_plain(settings)
    except InputError as error:  # not a text
        raise ConfigurationError(str(error)) from None
    except OSError as error:
        reason = "file not found" if not Path(path).exists() else str(error.strerror or error)
    except (yaml.YAMLError, ValueError) as error:
        where = getattr(error, "problem_mark", None)
        line = f"line {where.line + 1}: " if where else ""
        problem = getattr(error, "problem", None) or " ".join(str(error).split())
        if where and "\t" in "".join(text.splitlines()[where.line : where.line + 1]):
            problem += "; the line has a tab: write spaces in its place"
        reason = f"not plain YAML: {line}{problem}"
    if reason or settings is None:
        raise ConfigurationError(f"{path}: {reason}")
    return settings


def key_lines(path: str | Path) -> dict[str, int]:
    """Return the line of each key of a configuration file by its path, such as "study.name"."""
    lines: dict[str, int] = {}
    waiting = [("", yaml.compose(read_text(path), Loader=_Loader))]
    while waiting:
        within, node = waiting.pop()
        for key, value in node.value if isinstance(node, yaml.MappingNode) else ():
            lines[f"{within}{key.value}"] = key.start_mark.line + 1
            waiting.append((f"{within}{key.value}.", value))
    return lines


def with_places(message: str, files: Iterable[str | Path]) -> str:
    """Return a message on a configuration in which places of keys are added to its lines.

    A line of the message that begins with a key gets the file and line in which the last of the
    ``files`` states the key, or the section that lacks it. A key that is named without its section
    is found if only one section has it.
    """
    stated: dict[str, str] = {}
    for file in files:
        stated |= {key: f"{file}, line {line}: " for key, line in key_lines(file).items()}
    of_last: dict[str, list[str]] = {}
    for key in stated:
        of_last.setdefault(name_and_unit(key.rpartition(".")[2])[0], []).append(key)
    lines = []
    for line in message.splitlines():
        text = line.strip()
        key = text.split(" ")[0].rstrip(":")
        if (alike := of_last.get(key, [])) and key not in stated:
            key = alike[0] if len(alike) == 1 else ""
        while key and key not in stated:
            key = key.rpartition(".")[0]
        lines.append(line.removesuffix(text) + stated.get(key, "") + text)
    return "\n".join(lines)


def _no_file(path: Path) -> str:
    """Return why a path cannot be a configuration file; "" if it can."""
    size = path.stat().st_size
    if not path.is_file():
        return "must be a file"
    if size > _MOST_BYTES:
        return f"has {1e-6 * size:.3g} MB, and a configuration at most {1e-6 * _MOST_BYTES:g} MB"
    return ""


@dataclass
class _Node:
    """Node of a YAML document, while its events are counted."""

    anchor: str | None = None
    count: int = 1  # of nodes: this one and those within it, with aliases expanded
    levels: int = 0  # of nodes below this one
    complete: bool = False  # whether its end has been read

    def add(self, part: "_Node") -> None:
        """Count a complete node that lies directly within this one."""
        self.count += part.count
        self.levels = max(self.levels, 1 + part.levels)


def _unbounded(text: str) -> str:
    """Return why the text of a YAML file is refused before it is loaded; "" if it is not refused.

    It is refused if it is nested too deeply, has too many values, or has tags. The events of the
    parser are counted one by one, because the loader would recurse into nodes, and would copy the
    nodes that merge keys (``<<``) name.
    """
    anchors: dict[str | None, _Node] = {}
    whole = [_Node()]  # nodes that are not complete, each within the one before
    aliases = False
    for event in yaml.parse(text, Loader=_Loader):
        if isinstance(event, yaml.CollectionEndEvent):
            node = whole.pop()
        elif isinstance(event, yaml.AliasEvent):
            aliases = True
            # an unknown anchor is refused by the loader
            node = anchors.get(event.anchor, _Node(complete=True))
            if not node.complete:
                return "an alias refers to itself"
        elif isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent):
            if event.tag is not None:
                line = f"line {event.start_mark.line + 1}: " if event.start_mark else ""
                return f"not plain YAML: {line}the tag {event.tag} must be left out"
            anchors[event.anchor] = node = _Node(event.anchor)
            if isinstance(event, yaml.CollectionStartEvent):
                whole.append(node)
        else:  # begin or end of a document
            continue
        if node is not whole[-1]:
            node.complete = True
            whole[-1].add(node)
        # the first of the incomplete nodes is the file
        if len(whole) - 2 + whole[-1].levels > _DEEPEST:
            return f"values are nested more than {_DEEPEST} levels deep"
        if whole[-1].count > _MOST_VALUES:
            if aliases:
                return f"its aliases expand to more than {_MOST_VALUES} values; write them out"
            return f"has more than {_MOST_VALUES} keys and values"
    return ""


def _not_plain(settings: object) -> str:
    """Return why loaded YAML is refused; "" if it has only keys with texts, numbers and lists."""
    if settings is None:
        return "is empty, must contain keys and values"
    if not isinstance(settings, dict):
        return f"must contain keys and values, not {short(settings)}"
    if "__use_yte__" in settings:
        return "__use_yte__: must be left out; Snakemake would run the Python in templates"
    waiting: list[object] = [settings]
    while waiting:
        value = waiting.pop()
        if isinstance(value, dict):
            if odd := [key for key in value if not isinstance(key, str)]:
                return f"the key {odd[0]!r} must be a text"
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
        elif not isinstance(value, str | int | float | None):  # YAML reads dates
            return f"{value}: is a {type(value).__name__}; quote a text"
    return ""


def overlaid(keys: dict, changes: dict) -> dict:
    """Return nested keys, with those in ``changes`` replaced or added.

    The arguments stay as they are; the result shares the parts without a change.
    """
    return keys | {
        name: overlaid(keys[name], value)
        if isinstance(value, dict) and isinstance(keys.get(name), dict)
        else value
        for name, value in changes.items()
    }


def merged(*settings: dict) -> dict:
    """Return a copy of several nested settings in one; later ones replace keys of earlier ones."""
    return copy.deepcopy(functools.reduce(overlaid, settings, {}))


def refuse(problems: Iterable[str], what: str = "configuration") -> None:
    """Raise `ConfigurationError` if there are problems: ``what``, then a line for each problem."""
    if lines := "".join(f"\n  {line}" for line in dict.fromkeys(problems)):
        raise ConfigurationError(f"{what}:{lines}") from None


def short(value: object) -> str:
    """Return a value as text for a message, in one line of at most 100 characters."""
    text = reprlib.repr(value) if isinstance(value, dict | list) else repr(value)
    return text if len(text) <= 100 else f"{text[:97]}..."


def provenance(configuration: dict[str, Any]) -> dict[str, str]:
    """Return the provenance of a study's results as texts by name, for attributes of files.

    It has that of `origin`, the configuration, the root seed and the realisations per job.
    """
    return origin() | {
        "configuration": configuration_text(configuration),
        "root_seed": str(configuration["study"]["root_seed"]),
        "provenance_realizations_per_job": str(configuration["study"].get("realizations_per_job")),
    }


def configuration_text(configuration: dict[str, Any]) -> str:
    """Return the keys of a configuration as JSON, without ``study.realizations_per_job``.

    That key changes no result.
    """
    study = dict(configuration["study"])
    study.pop("realizations_per_job", None)
    return json.dumps(configuration | {"study": study}, sort_keys=True)


if __name__ == "__main__":  # run before Snakemake reads a file, as its loader accepts more
    try:
        read_plain(sys.argv[1])
    except ConfigurationError as error:
        sys.exit(str(error))
