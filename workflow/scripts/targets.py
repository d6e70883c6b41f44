"""Targets of the Makefile: goals of Snakemake, and checks of the configuration.

The user's variables of make (CONFIG, PROFILE, CORES) come through the environment as data: no shell
reads them.
"""

import importlib.util
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import yaml
from following import follow
from process_group import EndRequest

from jointclosure.compilation.sources import ROOTS
from jointclosure.inputs import InputError
from jointclosure.storage.files import read_csv, write_text
from studies.frame.configuration import Configuration, configured, merged_study, sections
from studies.frame.experiments import experiment_named
from studies.frame.keys import Accuracy
from studies.frame.lock import enter_folder
from studies.frame.yaml_files import merged, read_plain
from studies.paper.accuracy import START, Counts, describe_reached, next_counts, start_counts
from studies.paper.layout import closure_lines
from studies.paper.measured import measured_curves
from studies.paper.needs import curve_settings

_PROFILE = "workflow/profiles/default"
_ADVICE = {
    "slurm": "make setup-slurm",
    "kubernetes": ".venv/bin/python -m pip install --no-deps --require-hashes "
    "--requirement requirements-kubernetes.lock",
}


class Target(NamedTuple):
    """Goals of Snakemake, one after the other.

    ``experiment``: its section must be in the configuration, and its file is the default;
    ``usual``: a file with this section; ``study``: folder of results without a configuration;
    ``page``: name of the page in the study's folder that the user opens.
    """

    goals: tuple[str, ...] = ("all",)
    experiment: str = ""
    usual: str = ""
    study: str = ""
    page: str = ""

    @property
    def configuration(self) -> str:
        """Default configuration."""
        file = ROOTS["studies"] / self.experiment / f"{self.experiment}.yaml"
        return os.path.relpath(file) if self.experiment else ""


TARGETS = {
    "study": Target(),
    "report": Target(("report",), page="report.html"),
    "hard-cases": Target(("hard_cases",), study="hard_cases"),
    "conclusions": Target(("all", "conclusions")),
}
TARGETS |= {name.replace("_", "-"): Target((f"estimate_{name}", name), name) for name in sections()}
TARGETS["assess"] = TARGETS.pop("assessment")._replace(usual="workflow/usual_assessment.yaml")
TARGETS["global-sensitivity-estimate"] = TARGETS["global-sensitivity"]._replace(
    goals=("estimate_global_sensitivity",)
)


def run_target(name: str, request: EndRequest) -> int:
    """Run a target and return the exit status of Snakemake."""
    target = TARGETS[name]
    override = "" if target.study else os.environ.get("CONFIG") or target.configuration
    study, files = checked(name, override)
    folder, accuracy = Path("results") / (target.study or study.study.name), study.study.accuracy
    command = snakemake(os.environ.get("PROFILE") or _PROFILE, os.environ.get("CORES", ""))
    files += [f"./{override}" if override.startswith("-") else override] if override else []
    given = ["--configfile", *files] if files else []
    enter_folder()
    log = folder / f"logs/make_{name.replace('-', '_')}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    print(f"The log is {log}", flush=True)
    write_text(" " * 2**16, log)  # an error where the disk is full
    log.write_text("")
    with open(log, "a", encoding="utf-8") as stream:

        def run(goal: str) -> int:
            words = [*command, *given, *planned(accuracy, folder), "--", goal]
            return follow(words, stream, log, request)

        status = reach(accuracy, folder, run) if {"all", "report"} & {*target.goals} else 0
        for goal in target.goals:
            status = status or run(goal)
        if status:
            return status
    closures = folder / "tables/max_closure.csv"
    if "all" in target.goals and closures.exists():
        print("\n".join(closure_lines(read_csv(closures))))
    parts = [part for part in ("tables", "figures", "study.nc") if (folder / part).exists()]
    print(f"Results are in {folder}/ ({', '.join(parts)})")
    if target.page:
        print(f"The page is {folder / target.page}")
    return 0 if name != "hard-cases" or all_hold(folder / "tables/hard_cases.csv") else 1


def all_hold(path: Path) -> bool:
    """Print how many hard cases hold, and which do not; return whether all do."""
    table = read_csv(path)
    for row in table[~table.holds].itertuples():
        print(f"{row.name} does not hold: {row.failed}")
    for row in table[table.within_budget.eq(False)].itertuples():
        print(f"{row.name} took {row.seconds} s of {row.budget_s} s, which no requirement forbids")
    print(f"{int(table.holds.sum())} of {len(table)} hard cases hold")
    return bool(table.holds.all())


def checked(name: str, override: str) -> tuple[Configuration, list[str]]:
    """Return the study of a configuration file, checked for a target.

    The list has the file with the usual section of the target, if the configuration lacks it.
    """
    if override and not Path(override).is_file():
        raise InputError(f"CONFIG={override}: there is no such file")
    target, keys = TARGETS[name], merged_study(*([Path(override)] if override else []))
    section = target.experiment
    usual = [target.usual] if target.usual and not keys.get(section) else []
    study = configured(merged(keys, *map(read_plain, usual)))
    if section and section not in study.study_sections:
        raise InputError(
            f"{override}: has no section {section}, which make {name} needs "
            f"({target.configuration} has one)"
        )
    if section:
        experiment_named(section).check(study)
    measured_curves(curve_settings(study))
    return study, usual


PLAN = "accuracy_plan.yaml"
"""File in a study's folder with the numbers of surfaces for its requested accuracy."""


def planned(asked: Accuracy | None, folder: Path) -> list[str]:
    """Return the file with the numbers of surfaces for the requested accuracy, if there is one.

    It follows that of the study after one --configfile, as Snakemake takes the last only.
    """
    plan = folder / PLAN
    if not plan.is_file():
        return []
    earlier = Accuracy(**read_plain(plan)["study"]["accuracy"])
    if asked is None or asked._replace(differences=earlier.differences) != earlier:
        plan.unlink()  # of another request
        return []
    return [str(plan)]


def reach(accuracy: Accuracy | None, folder: Path, run: Callable[[str], int]) -> int:
    """Close surfaces until the requested accuracy is reached, if any; return the exit status."""
    tables = folder / "tables"
    if accuracy is None:
        return 0

    def plan(counts: Counts) -> None:
        asked = accuracy._replace(differences=counts.differences).model_dump()
        study = {"realizations": counts.surfaces, "accuracy": asked}
        write_text(yaml.safe_dump({"study": study}), folder / PLAN)

    if not planned(accuracy, folder):
        if accuracy.budget_core_minutes is None:
            plan(START)
        elif status := run("price_accuracy"):
            return status
        else:
            plan(start_counts(read_csv(tables / "accuracy_price.csv"), accuracy))
    while True:
        if status := run("reach_accuracy"):
            return status
        closed = read_plain(folder / PLAN)["study"]
        table = read_csv(tables / "accuracy_reached.csv")
        counts = Counts(closed["realizations"], closed["accuracy"]["differences"])
        following = next_counts(table, accuracy, counts)
        print(describe_reached(table, accuracy, ended=following is None), flush=True)
        if following is None:
            return 0
        plan(following)
        words = f"{following.surfaces} surfaces and {following.differences} differences"
        print(f"accuracy: continues with {words}", flush=True)


def snakemake(profile: str, cores: str) -> list[str]:
    """Return the command, without goals and configuration."""
    file = Path(profile) / "config.yaml"
    if not file.is_file():
        raise InputError(f"PROFILE={profile}: has no config.yaml")
    if cores and cores != "all" and not (cores.isdecimal() and int(cores) > 0):
        raise InputError(f"CORES={cores}: must be a number from 1 on, or all")
    settings = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
    for kind, name in (
        ("executor", settings.get("executor")),
        ("storage", settings.get("default-storage-provider")),
    ):
        plugin = f"snakemake_{kind}_plugin_{str(name).replace('-', '_')}"
        if name not in (None, "local") and not importlib.util.find_spec(plugin):
            advice = _ADVICE.get(settings.get("executor"), f"install {plugin.replace('_', '-')}")
            raise InputError(f"PROFILE={profile}: needs {plugin}, which is not installed: {advice}")
    command = [sys.executable, "-m", "snakemake", "--workflow-profile", profile]
    return [*command, *(["--cores", cores] if cores else [])]
