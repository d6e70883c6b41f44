"""Defaults of the workflow's rules, and files of results that are made again.

A rule names its input, output, parameters and script. `complete` adds the rest, once all are read:
a log and a ``benchmark`` of time and memory in the folders ``logs`` and ``benchmarks`` of the
study's results, under the name of the rule and the wildcards of its outputs; a parameter ``code``,
the digest of its script and of all that this imports; and as message the first line of its script's
docstring. It sets attributes of Snakemake's rules, which has no other place for them.
"""

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from snakemake.io import strip_wildcard_constraints

from jointclosure.compilation.sources import code_digest
from studies.frame.jobs import (
    OTHER_SETTINGS,
    Seal,
    is_sealed,
    sealed_files,
    seals_in,
    settings_digest,
    unmet_seals,
)

FOLDER = re.compile(r"results/[^/{]+")
"""Folder of a study's results, at the start of each output."""
_NO_RESULTS = ("seals", "logs", "benchmarks")


def complete(rules: Iterable[Any], environment: str) -> None:
    """Add to all rules with a script what all have, and the conda ``environment``."""
    for rule in rules:
        if not rule.script:
            continue
        rule.log_modifier = rule.output_modifier
        rule.set_log(_file(rule, "logs", "log"), benchmark=_file(rule, "benchmarks", "tsv"))
        rule.conda_env = environment
        script = Path(rule.basedir.join(rule.script).get_path_or_uri(secret_free=True))
        if not rule.params.get("code"):
            rule.set_params(code=code_digest(str(script)))
        if not rule.message:
            named = ", ".join(f"{{wildcards.{name}}}" for name in sorted(rule.wildcard_names))
            text = script.read_text(encoding="utf-8").split('"""')[1]
            rule.message = text.splitlines()[0].rstrip(".") + (f" ({named})" if named else "")


def withdraw_unmet(rules: Iterable[Any], report: Callable[[str], None], remove: bool) -> None:
    """Remove sealed files that are not as jobs of these rules write them, and all made of them.

    A line tells of each changed file, and one a folder of files of other settings. Without
    ``remove`` they are only reported.
    """
    sealed = [rule for rule in rules if rule.script and is_sealed(rule.output, rule.params)]
    for folder in sorted({Path(_folder(rule)) for rule in sealed}):
        unmet = list(unmet_seals(folder, lambda seal: _expected(seal, sealed)))
        reasons = [reason.partition(": delete")[0] for _, _, reason in unmet]
        other = [reason for reason in reasons if OTHER_SETTINGS in reason]
        for reason in [reason for reason in reasons if reason not in other] + other[:1]:
            report(f"jointclosure: {reason}")
        if len(other) > 1:
            report(f"jointclosure: {folder}: the same of {len(other) - 1} more jobs")
        listed = dict(sealed_files(folder))
        unlisted = {
            path.as_posix()
            for path in folder.rglob("*")
            if path.is_file() and path.relative_to(folder).parts[0] not in _NO_RESULTS
        } - listed.keys()
        foreign = {file for file in unlisted if _producer(file, sealed)}
        for file in sorted(foreign):
            report(f"jointclosure: {file}: no seal lists the file")
        if remove:
            for path, _, _ in unmet:
                path.unlink(missing_ok=True)
            _remove(foreign | {file for _, seal, _ in unmet if seal for file in seal.files}, folder)


def _remove(files: set[str], folder: Path) -> None:
    """Remove files of a study, and what was made of them with its seals."""
    while files:
        for file in files:
            Path(file).unlink(missing_ok=True)
        made = {p: s for p, s in seals_in(folder).items() if s and s.made_from.keys() & files}
        for path in made:
            path.unlink()
        files = {file for seal in made.values() for file in seal.files}


def _producer(file: str, rules: list[Any]) -> Any:
    """Return the rule that makes a file, if any."""
    return next((rule for rule in rules if rule.is_producer(file)), None)


def _expected(seal: Seal, rules: list[Any]) -> str:
    """Return the digest of settings that a seal must have; empty if no job of the rules has any."""
    file = next(iter(seal.files), "")
    if not (rule := _producer(file, rules)):
        return ""
    wildcards = SimpleNamespace(**rule.get_wildcards(file))
    try:
        params = {n: v(wildcards) if callable(v) else v for n, v in rule.params.items()}
        return settings_digest(params)
    except (LookupError, TypeError, ValueError):  # parameters that depend on inputs
        return ""


def _folder(rule: Any) -> str:
    first = str(rule.output[0])
    match = FOLDER.match(first)
    if not match:
        raise ValueError(f"rule {rule.name}: {first}: must lie in results/<study>")
    return match[0]


def _file(rule: Any, kind: str, suffix: str) -> str:
    """Return the pattern of a file besides a rule's output, named by its first to last wildcard."""
    match = re.search(r"\{.*\}", strip_wildcard_constraints(str(rule.output[0])))
    wildcards = f"/{match[0]}" if match else ""
    return f"{_folder(rule)}/{kind}/{rule.name}{wildcards}.{suffix}"
