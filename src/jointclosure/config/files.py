"""Configuration files: plain YAML, read strictly, and the files that come with the package."""

import re
import reprlib
from collections import Counter
from pathlib import Path

import yaml

from jointclosure.inputs import InputError

DEFAULT = Path(__file__).with_name("default.yaml")
"""The paper's study, over which every other configuration is merged."""
MEASURED = Path(__file__).with_name("accuracy_settings.csv")
"""What settings of the numerics were off by: presets are chosen from it."""
METHODS = Path(__file__).with_name("accuracy_methods.csv")
"""What presets are off by, scatter and cost: a wanted accuracy is granted from it."""
SURROGATES = tuple(
    Path(__file__).with_name(f"surrogate_{walls}.csv") for walls in ("roll_off", "no_roll_off")
)
"""Constants of the bearing-area law, and what it was off by, for the default study's walls and for
walls with waves of all lengths: `snakemake surrogate` makes such a table."""
PAPER_TABLE_3 = Path(__file__).with_name("paper_table_3.csv")
"""The paper's Table 3."""

_MOST_VALUES, _DEEPEST = 100_000, 40
_DECIMAL = re.compile(r"[-+]?(0|[1-9][0-9]*)$|[-+]?([0-9]*\.[0-9]*([eE][-+]?[0-9]+)?|\.(inf|nan))$")


class ConfigurationError(InputError):
    """A configuration that cannot be run; the message lists all that is wrong."""


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Plain YAML, without what YAML reads otherwise than it looks: said, and refused."""

    def construct_mapping(self, node, deep=False):
        keys = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode))
        twice = [key for key, count in keys.items() if count > 1]
        if twice:
            line = [key for key, _ in node.value if key.value == twice[0]][1].start_mark.line
            raise yaml.constructor.ConstructorError(
                problem=f"line {line + 1}: the key {twice[0]} is given twice"
            )
        return super().construct_mapping(node, deep)

    def decimal(self, node):
        """A number that is written in decimal; 1:30 is 90 to YAML, and 010 is 8."""
        if not _DECIMAL.match(node.value.lower()):
            raise yaml.constructor.ConstructorError(
                problem=f"line {node.start_mark.line + 1}: {node.value} is no decimal number; "
                "put it in quotes if it is a text"
            )
        integer = node.tag.endswith(":int")
        return self.construct_yaml_int(node) if integer else self.construct_yaml_float(node)


for _kind in ("int", "float"):
    _Loader.add_constructor(f"tag:yaml.org,2002:{_kind}", _Loader.decimal)


def read_plain(path: str | Path) -> dict:
    """A configuration's own file, as the plain data that it must be.

    Snakemake runs Python expressions in a file that has ``__use_yte__``: the file of
    a stranger is to be read by this function first, as `make` does.

    Raises
    ------
    ConfigurationError
        In one line: the file is not there, not UTF-8, empty or no mapping, has a tag of
        YAML, a key twice, a number that is not decimal, an alias that refers to itself or
        that makes a large thing of a small file, or asks to be run as a template.
    """
    try:
        text = Path(path).read_bytes().decode("utf-8")
    except FileNotFoundError:
        raise ConfigurationError(f"{path}: there is no such file") from None
    except OSError as error:
        raise ConfigurationError(f"{path}: {(error.strerror or str(error)).lower()}") from None
    except UnicodeDecodeError as error:
        raise ConfigurationError(
            f"{path}: is not UTF-8 text (byte {error.object[error.start]:#04x} at "
            f"{error.start}): save it as UTF-8"
        ) from None
    settings = _parsed(text, path)
    if settings is None:
        raise ConfigurationError(f"{path}: is empty; it must hold keys and values")
    if not isinstance(settings, dict):
        raise ConfigurationError(f"{path}: must hold keys and values, not {_short(settings)}")
    if "__use_yte__" in settings:
        raise ConfigurationError(
            f"{path}: __use_yte__ = {_short(settings['__use_yte__'])}: templates are not allowed, "
            "as Snakemake would run the Python in them"
        )
    _check_plain(settings, path)
    return settings


def value_of(text: str) -> object:
    """A value as a configuration would have it: a number, a word, a list."""
    return _parsed(text, repr(text))


def _parsed(text: str, path: str | Path) -> object:
    try:
        return yaml.load(text, Loader=_Loader)
    except (yaml.YAMLError, ValueError) as error:
        where = getattr(error, "problem_mark", None)
        said = getattr(error, "problem", None) or " ".join(str(error).split())
        line = f"line {where.line + 1}: " if where else ""
        raise ConfigurationError(f"{path}: not plain YAML: {line}{said}") from None
    except RecursionError:
        raise ConfigurationError(f"{path}: not plain YAML: nested too deeply") from None


def _check_plain(settings: dict, path: str | Path) -> None:
    """Refuse what is too deep, too large once its aliases are written out, or has odd keys."""
    waiting, count = [(settings, 0)], 0
    while waiting:
        value, depth = waiting.pop()
        count += 1
        if depth > _DEEPEST:
            raise ConfigurationError(
                f"{path}: an alias refers to what it is in, or values are nested over {_DEEPEST} "
                "deep"
            )
        if count > _MOST_VALUES:
            raise ConfigurationError(
                f"{path}: its aliases stand for over {_MOST_VALUES} values; write out what is meant"
            )
        if isinstance(value, dict):
            odd = [key for key in value if not isinstance(key, str)]
            if odd:
                raise ConfigurationError(f"{path}: the key {odd[0]!r} must be a text")
        parts = value.values() if isinstance(value, dict) else value
        if isinstance(value, dict | list):
            waiting += [(part, depth + 1) for part in parts]


def _short(value: object) -> str:
    text = reprlib.repr(value) if isinstance(value, dict | list) else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
