"""Defaults of the workflow's rules: log, benchmark, environment, message, digest of code and seal.

A rule names its input, output, parameters and script. `complete` adds the rest to all rules of a
workflow, once they are read:

- a log, a log ``benchmark`` of time and memory, and an output ``seal``
  (`studies.frame.jobs.seals`), in the folders ``logs``, ``benchmarks`` and ``seals`` of the
  study's results, under the name of the rule and behind it the wildcards of its outputs;
- inputs ``seals``: the seals of the jobs that make its inputs;
- a parameter ``code``, the digest of its script and of all that this imports;
- a message: the first line of its script's docstring, and its wildcards.

It reads and sets attributes of Snakemake's rules, which Snakemake has no other place for.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from jointclosure.compilation.sources import code_digest
from studies.frame.jobs.seals import (
    OTHER_SETTINGS,
    seal_beside,
    settings_digest,
    unmet_seals,
)

FOLDER = re.compile(r"results/[^/{]+")
"""Folder of a study's results, at the start of each output."""


class SealedJobs:
    """Jobs that make files, and the seals that they write.

    Parameters
    ----------
    rules : iterable
        Rules of Snakemake with a script, as `complete` leaves them.
    """

    def __init__(self, rules: Iterable[Any]):
        rules = list(rules)
        seals = {rule.name: _file(rule, "seals", "json") for rule in rules if _sealed(rule)}
        self._made = [
            (_pattern(str(path), rule), seals.get(rule.name, ""))
            for rule in sorted(rules, key=_sealed)  # files without a seal are many
            for path in _raw(rule.ruleinfo.output)
        ]
        self._seals = [
            (rule, _pattern(seals[rule.name], rule)) for rule in rules if rule.name in seals
        ]
        self.seal_of = lru_cache(maxsize=None)(self._seal_of)

    def _seal_of(self, path: str) -> str:
        """Return the seal of the job that makes a file; empty without such a job or seal."""
        for pattern, seal in self._made:
            if match := pattern.fullmatch(path):
                return seal.format(**match.groupdict())
        return ""

    def folders(self) -> list[str]:
        """Return the folders of results in which jobs write."""
        return sorted({_folder(rule) for rule, _ in self._seals})

    def withdraw_unmet(self, report: Callable[[str], None], remove: bool) -> None:
        """Remove seals that are not met, so that their files are made again.

        Parameters
        ----------
        report : callable
            Receives a line for each changed file, and one a folder for files of other settings.
        remove : bool
            False to report only.
        """
        for folder in self.folders():
            unmet = list(unmet_seals(folder, self.expected_settings))
            for seal, _ in unmet:
                if remove:
                    seal.unlink(missing_ok=True)
            reasons = [reason.partition(": delete")[0] for _, reason in unmet]
            other = [reason for reason in reasons if OTHER_SETTINGS in reason]
            for reason in [reason for reason in reasons if reason not in other] + other[:1]:
                report(f"jointclosure: {reason}")
            if len(other) > 1:
                report(f"jointclosure: {folder}: the same of {len(other) - 1} more jobs")

    def expected_settings(self, seal: str | Path) -> str:
        """Return the digest of the settings that a seal must have.

        Empty if this configuration has no such job, or parameters depend on inputs.
        """
        for rule, pattern in self._seals:
            if match := pattern.fullmatch(Path(seal).as_posix()):
                wildcards = SimpleNamespace(**match.groupdict())
                try:
                    return settings_digest(
                        {
                            name: value(wildcards) if callable(value) else value
                            for name, value in rule.params.items()
                        }
                    )
                except (LookupError, TypeError, ValueError):
                    return ""
        return ""


def complete(rules: Iterable[Any], environment: str) -> SealedJobs:
    """Add to all rules of a workflow the parts that all have, and the conda ``environment``."""
    rules = list(rules)
    jobs = [rule for rule in rules if rule.script]
    for rule in jobs:
        _complete(rule, environment)
    made = SealedJobs(jobs)
    for rule in rules:
        if rule.ruleinfo.input:
            rule.set_input(seals=_seals(list(_raw(rule.ruleinfo.input)), made))
    return made


def _complete(rule: Any, environment: str) -> None:
    rule.log_modifier = rule.output_modifier
    rule.set_log(_file(rule, "logs", "log"), benchmark=_file(rule, "benchmarks", "tsv"))
    rule.conda_env = environment
    script = Path(rule.basedir.join(rule.script).get_path_or_uri(secret_free=True))
    if not rule.params.get("code"):
        rule.set_params(code=code_digest(str(script)))
    if not rule.message:
        named = ", ".join(f"{{wildcards.{name}}}" for name in sorted(rule.wildcard_names))
        rule.message = _first_line(script) + (f" ({named})" if named else "")
    # notes are no input, and files of the cache bear a key
    if Path(str(next(_raw(rule.ruleinfo.output)))).suffix != ".txt" and not rule.params.get("key"):
        rule.set_output(seal=_file(rule, "seals", "json"))


def _seals(inputs: list[Any], made: SealedJobs) -> Callable[[Any], list[str]]:
    """Input function: the seals of other inputs, those of other studies included."""

    def seals(wildcards: Any) -> list[str]:
        paths = _expanded(inputs, wildcards)
        return sorted({seal for path in paths if (seal := made.seal_of(path) or seal_beside(path))})

    return seals


def _expanded(inputs: Any, wildcards: Any) -> Iterator[str]:
    """Generate the paths of inputs, with called functions and inserted wildcards."""
    function = inputs if callable(inputs) else getattr(inputs, "callable", None)
    if function:
        yield from _expanded(function(wildcards), wildcards)
    elif isinstance(inputs, (str, Path)):
        yield str(inputs).format(**dict(wildcards.items())) if "{" in str(inputs) else str(inputs)
    else:
        for part in inputs:
            yield from _expanded(part, wildcards)


def _raw(files: Any) -> Iterator[Any]:
    """Generate the files of a rule as written in it."""
    for part in (*files.paths, *files.kwpaths.values()):
        if isinstance(part, (str, Path)) or callable(part):
            yield part
        else:
            yield from part


def _folder(rule: Any) -> str:
    first = str(next(_raw(rule.ruleinfo.output)))
    match = FOLDER.match(first)
    if not match:
        raise ValueError(f"rule {rule.name}: {first}: must lie in results/<study>")
    return match[0]


def _file(rule: Any, kind: str, suffix: str) -> str:
    """Return the pattern of a file that a rule writes besides its output.

    Its name ends with the part of the first output from its first wildcard to its last.
    """
    match = re.search(r"\{.*\}", str(next(_raw(rule.ruleinfo.output))))
    wildcards = f"/{match[0]}" if match else ""
    return f"{_folder(rule)}/{kind}/{rule.name}{wildcards}.{suffix}"


def _sealed(rule: Any) -> bool:
    return bool(rule.output.get("seal"))


def _pattern(path: str, rule: Any) -> re.Pattern[str]:
    """Return the regular expression of an output, with wildcards as groups."""
    constraints: Mapping[str, str] = {
        **rule.workflow.wildcard_constraints,
        **rule.wildcard_constraints,
    }
    parts = re.split(r"\{(\w+)[^}]*\}", path)
    seen: set[str] = set()
    text = ""
    for number, part in enumerate(parts):
        if number % 2 == 0:
            text += re.escape(part)
        else:
            text += f"(?P={part})" if part in seen else f"(?P<{part}>{constraints.get(part, '.+')})"
            seen.add(part)
    return re.compile(text)


def _first_line(script: Path) -> str:
    """Return the first line of a script's docstring, without its full stop."""
    text = script.read_text(encoding="utf-8")
    return text.partition('"""')[2].partition('"""')[0].strip().splitlines()[0].rstrip(".")
