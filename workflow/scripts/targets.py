"""Targets of the Makefile: what Snakemake is asked for, and which configurations are refused.

What a user tells make (CONFIG, PROFILE, CORES) comes through the environment and is data: no shell
reads it.
"""

import importlib.util
import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import psutil
import yaml
from following import follow
from process_group import EndRequest, run_group

from jointclosure.config.configuration import Configured, configured, merged_study
from jointclosure.config.files import read_plain
from jointclosure.config.wanted import Wanted, wanted_of
from jointclosure.experiments import SECTIONS, checked_design
from jointclosure.inputs import InputError
from jointclosure.measured.curves import curve_settings, measured_curves
from jointclosure.sensitivity.jrc_range import check_jrc_varies
from jointclosure.sensitivity.reached import describe_reached, surfaces_next
from jointclosure.sensitivity.tables import closure_lines
from jointclosure.storage.text import read_csv, read_text, write_text

_PROFILE = "workflow/profiles/default"
_ADVICE = {
    "slurm": "make setup-slurm",
    "kubernetes": ".venv/bin/python -m pip install --no-deps --require-hashes "
    "--requirement requirements-kubernetes.lock",
}


class Target(NamedTuple):
    """What Snakemake is asked for: goals one after the other, and the usual configuration.

    ``section`` of a configuration that it needs; ``check`` refuses one that cannot be done;
    ``page`` in the study's folder is what the user wants to open.
    """

    goals: tuple[str, ...] = ("all",)
    configuration: str = ""
    study: str = ""
    section: str = ""
    check: Callable[[Configured], object] = lambda configured: None
    page: str = ""


TARGETS = {
    "study": Target(),
    "report": Target(("report",), page="report.html"),
    "hard-cases": Target(("hard_cases",), study="hard_cases"),
    "jrc-range": Target(("all", "jrc_range"), check=lambda told: check_jrc_varies(told.typed)),
    "conclusions": Target(("all", "conclusions"), check=lambda told: check_jrc_varies(told.typed)),
}
TARGETS |= {
    name.replace("_", "-"): Target(
        (f"estimate_{name}", name),
        f"config/{name}.yaml",
        section=section,
        check=partial(checked_design, name),
    )
    for name, section in SECTIONS.items()
}
TARGETS["effects"] = TARGETS["effects"]._replace(
    goals=("estimate_effects", "effects", "effects_auto")
)
TARGETS["global-sensitivity-estimate"] = TARGETS["global-sensitivity"]._replace(
    goals=("estimate_global_sensitivity",)
)


def run_target(name: str, request: EndRequest) -> int:
    """Run a target; the exit status of Snakemake, or 1 where the results are not as they should."""
    target = TARGETS[name]
    override = "" if target.study else os.environ.get("CONFIG") or target.configuration
    folder = Path("results") / (target.study or checked_name(name, override))
    command = snakemake(os.environ.get("PROFILE") or _PROFILE, os.environ.get("CORES", ""))
    given = ["--configfile", f"./{override}" if override.startswith("-") else override]
    given = given if override else []
    release_lock([*command, *given], request)
    log = folder / f"logs/make_{name.replace('-', '_')}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    print(f"The log is {log}", flush=True)
    log.write_text("")
    with open(log, "a", encoding="utf-8") as stream:
        for goal in target.goals:
            while True:
                words = [*command, *given, *planned(override, folder), "--", goal]
                status = follow(words, stream, log, request)
                if status:
                    return status
                if goal != "all" or not enlarged(override, folder):
                    break
    closures = folder / "tables/max_closure.csv"
    if "all" in target.goals and closures.exists():
        print("\n".join(closure_lines(read_csv(closures))))
    parts = [part for part in ("tables", "figures", "study.nc") if (folder / part).exists()]
    print(f"Results are in {folder}/ ({', '.join(parts)})")
    if target.page:
        print(f"The page is {folder / target.page}")
    return 0


def checked_name(name: str, override: str) -> str:
    """The name of the study of a file over the default configuration, if a target can do it."""
    if override and not Path(override).is_file():
        raise InputError(f"CONFIG={override}: there is no such file")
    target = TARGETS[name]
    told = configured(merged_study(*([Path(override)] if override else [])), read_csv)
    if target.section and not told.keys.get(target.section):
        raise InputError(
            f"{override}: has no section {target.section}, which make {name} needs "
            f"({target.configuration} has one)"
        )
    target.check(told)
    measured_curves(curve_settings(told.typed), read_text)
    return told.typed.study.name


PLAN = "accuracy_plan.yaml"
"""File in a study's folder: the surfaces that the accuracy wanted of it was found to need."""


def wish_of(override: str) -> Wanted | None:
    """The accuracy that a study wants of its results, if it wants any."""
    return wanted_of(merged_study(*([Path(override)] if override else [])))


def planned(override: str, folder: Path) -> list[str]:
    """Arguments for as many surfaces as were found to be needed for the accuracy wanted.

    The file follows that of the study after one --configfile, as Snakemake takes the last only.
    """
    wanted, plan = wish_of(override), folder / PLAN
    if wanted is None or not plan.is_file():
        return []
    found = wanted_of(read_plain(plan))
    if found is None or found._replace(surfaces=None) != wanted._replace(surfaces=None):
        plan.unlink()  # of another wish
        return []
    return [str(plan)]


def enlarged(override: str, folder: Path) -> bool:
    """Whether the accuracy wanted needs more surfaces: says what was reached, writes the plan."""
    wanted = wish_of(override)
    if wanted is None:
        return False
    table = read_csv(folder / "tables/accuracy_reached.csv")
    print(describe_reached(table, wanted), flush=True)
    surfaces = surfaces_next(table, wanted)
    if surfaces is None:
        return False
    print(f"accuracy: going on with {surfaces} surfaces a case", flush=True)
    plan = {"numerics": {"accuracy": wanted._replace(surfaces=surfaces)._asdict()}}
    write_text(yaml.safe_dump(plan), folder / PLAN)
    return True


def snakemake(profile: str, cores: str) -> list[str]:
    """The command, without goals and configuration."""
    file = Path(profile) / "config.yaml"
    if not file.is_file():
        raise InputError(f"PROFILE={profile}: has no config.yaml")
    if cores and cores != "all" and not (cores.isdecimal() and int(cores) > 0):
        raise InputError(f"CORES={cores}: must be a number from 1 on, or all")
    told = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
    for kind, name in (
        ("executor", told.get("executor")),
        ("storage", told.get("default-storage-provider")),
    ):
        plugin = f"snakemake_{kind}_plugin_{str(name).replace('-', '_')}"
        if name not in (None, "local") and not importlib.util.find_spec(plugin):
            advice = _ADVICE.get(told.get("executor"), f"install {plugin.replace('_', '-')}")
            raise InputError(f"PROFILE={profile}: needs {plugin}, which is not installed: {advice}")
    command = [sys.executable, "-m", "snakemake", "--workflow-profile", profile]
    return [*command, *(["--cores", cores] if cores else [])]


def release_lock(command: list[str], request: EndRequest) -> None:
    """After a kill: release the lock of a Snakemake that is no longer there."""
    if not any(Path(".snakemake/locks").glob("*")):
        return
    for process in psutil.process_iter():
        try:
            words = process.cmdline()
            here = "--workflow-profile" in words and Path(process.cwd()) == Path.cwd().resolve()
        except psutil.Error:
            continue
        if here and process.pid != os.getpid():
            raise InputError(f"another run is at work in this folder (process {process.pid})")
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    run_group([*command, "--unlock"], request, **quiet)
