"""Run a target of the Makefile: Snakemake with its log in a file, and a line on how far it is.

`make` starts this with the name of the target and nothing else. What a user tells make
(CONFIG, PROFILE, CORES) comes through the environment and is data: no shell reads it.
"""

import importlib.util
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple, TextIO

import psutil
import yaml

from jointclosure.config.configuration import Configured, configured, merged_study
from jointclosure.config.files import read_plain
from jointclosure.config.wanted import Wanted, wanted_of
from jointclosure.experiments import experiment_named
from jointclosure.inputs import InputError
from jointclosure.logbook import failed_log
from jointclosure.progress import WorkflowProgress
from jointclosure.storage.text import read_csv, write_text
from jointclosure.studies.global_sensitivity import design as global_sensitivity
from jointclosure.studies.sensitivity.jrc_range import check_jrc_varies
from jointclosure.studies.sensitivity.reached import surfaces_next, told

SHOWN = "jointclosure: "
"""Lines of the log that start so are for the user."""
SECONDS, PART = 30.0, 0.1
"""Between two lines on progress where no terminal is: so long, or so much of all jobs."""
_PROFILE = "workflow/profiles/default"
_ADVICE = {
    "slurm": "make setup-slurm",
    "kubernetes": ".venv/bin/python -m pip install --no-deps --require-hashes "
    "--requirement requirements-kubernetes.lock",
}


class Target(NamedTuple):
    """What Snakemake is asked for: goals one after the other, and the usual configuration.

    ``section`` of a configuration that it needs; ``check`` refuses one that cannot be done.
    """

    goals: tuple[str, ...] = ("all",)
    configuration: str = ""
    study: str = ""
    section: str = ""
    check: Callable[[Configured], object] = lambda configured: None


TARGETS = {
    "study": Target(),
    "report": Target(("report",)),
    "hard-cases": Target(("hard_cases",), study="hard_cases"),
    "accuracy": Target(
        ("estimate_accuracy", "accuracy"), "config/accuracy.yaml", section="accuracy"
    ),
    "effects": Target(
        ("estimate_effects", "effects", "effects_auto"), "config/effects.yaml", section="ablation"
    ),
    "mismatch": Target(
        ("estimate_mismatch", "mismatch"), "config/mismatch.yaml", section="mismatch"
    ),
    "size": Target(("estimate_size", "size"), "config/size.yaml", section="size"),
    "misalignment": Target(
        ("estimate_misalignment", "misalignment"),
        "config/misalignment.yaml",
        section="misalignment",
        check=experiment_named("misalignment").design,
    ),
    "readings": Target(
        ("estimate_readings", "readings"), "config/readings.yaml", section="readings"
    ),
    "jrc-range": Target(("all", "jrc_range"), check=lambda told: check_jrc_varies(told.typed)),
    "conclusions": Target(("all", "conclusions"), check=lambda told: check_jrc_varies(told.typed)),
    "global-sensitivity": Target(
        ("estimate_together", "global_sensitivity"),
        "config/global_sensitivity.yaml",
        section="global_sensitivity",
        check=lambda told: global_sensitivity.design_of(told.keys),
    ),
}
TARGETS["global-sensitivity-estimate"] = TARGETS["global-sensitivity"]._replace(
    goals=("estimate_together",)
)


def main(name: str) -> int:
    """Run a target; the exit status of Snakemake, or 1 where the results are not as they should."""
    target = TARGETS[name]
    override = "" if target.study else os.environ.get("CONFIG") or target.configuration
    folder = Path("results") / (target.study or checked_name(name, override))
    command = snakemake(os.environ.get("PROFILE") or _PROFILE, os.environ.get("CORES", ""))
    given = ["--configfile", f"./{override}" if override.startswith("-") else override]
    given = given if override else []
    release_lock([*command, *given])
    log = folder / f"logs/make_{name.replace('-', '_')}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    print(f"The log is {log}", flush=True)
    log.write_text("")
    with open(log, "a", encoding="utf-8") as stream:
        for goal in target.goals:
            status = follow([*command, *given, *planned(override, folder), "--", goal], stream, log)
            while not status and goal == "all" and enlarged(override, folder):
                status = follow(
                    [*command, *given, *planned(override, folder), "--", goal], stream, log
                )
            if status:
                return status
    parts = [each for each in ("tables", "figures", "study.nc") if (folder / each).exists()]
    print(f"Results are in {folder}/ ({', '.join(parts)})")
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
    print(told(table, wanted), flush=True)
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


def release_lock(command: list[str]) -> None:
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
    subprocess.run([*command, "--unlock"], capture_output=True, check=False)


def follow(command: list[str], stream: TextIO, log: Path) -> int:
    """Run Snakemake with its log in a file, and say how far it is; its exit status."""
    start = log.stat().st_size
    process = subprocess.Popen(command, stdout=stream, stderr=stream, stdin=subprocess.DEVNULL)
    signal.signal(signal.SIGTERM, lambda *_: process.terminate())
    progress, console = WorkflowProgress(), Console()
    try:
        for line in lines_of(log, start, process):
            progress.read(line)
            if line.startswith(SHOWN):
                console.say(line.removeprefix(SHOWN).rstrip())
            console.show(progress)
        status = process.wait()
    except KeyboardInterrupt:
        console.say("interrupted: waiting for the jobs to end (Ctrl-C again ends them at once)")
        ended(process)
        console.say("interrupted: what was finished stays; the same command goes on from there")
        return 130
    console.clear()
    if status:
        said = log.read_bytes()[start:].decode(errors="replace")
        print(failures(said), file=sys.stderr)
        print(f"The run failed or was ended; all that was said is in {log}", file=sys.stderr)
    elif progress.total:
        console.say(f"{progress.done} of {progress.total} jobs done")
        for line in repeated(log.read_bytes()[start:].decode(errors="replace")):
            console.say(line)
    else:
        console.say("nothing was left to do")
    return 128 - status if status < 0 else status


def ended(process: subprocess.Popen) -> None:
    """Wait for a process that was interrupted with this one."""
    try:
        process.wait()
    except KeyboardInterrupt:
        process.terminate()
        process.wait()


def lines_of(log: Path, start: int, process: subprocess.Popen) -> Iterator[str]:
    """Lines that a process writes to a file, as they come, and "" where none came for a while."""
    with open(log, encoding="utf-8", errors="replace") as written:
        written.seek(start)
        part = ""
        while True:
            over = process.poll() is not None
            while piece := written.readline():
                part += piece
                if part.endswith("\n"):
                    yield part
                    part = ""
            if over:
                return
            yield ""
            time.sleep(0.2)


class Console:
    """A line that is renewed on a terminal; elsewhere a line now and then."""

    def __init__(self, stream: TextIO | None = None):
        self._stream = sys.stdout if stream is None else stream
        self._renewed = self._stream.isatty()
        self._shown, self._at, self._part = "", time.monotonic(), 0.0

    def show(self, progress: WorkflowProgress) -> None:
        """Say how far it is, if it is time to."""
        if not progress.total:
            return
        now, part = time.monotonic(), progress.done / progress.total
        late, far = now - self._at > SECONDS, part >= self._part + PART
        if self._renewed and (now - self._at > 0.5):
            self._at = now
            self._renew(progress.text())
        elif not self._renewed and (late or far):
            self._at, self._part = now, part
            print(progress.text(), file=self._stream, flush=True)

    def say(self, text: str) -> None:
        """A line that stays."""
        self.clear()
        print(text, file=self._stream, flush=True)

    def clear(self) -> None:
        """Take the renewed line away."""
        if self._shown:
            self._renew("")

    def _renew(self, text: str) -> None:
        print("\r" + text.ljust(len(self._shown)), end="", file=self._stream, flush=True)
        if not text:
            print("\r", end="", file=self._stream, flush=True)
        self._shown = text


def failures(said: str) -> str:
    """What went wrong, of all that Snakemake said: each failed rule, and the end of its log."""
    found = dict.fromkeys(_FAILED.findall(said))
    parts = [
        f"{rule} failed; the end of {log}:\n{_end(Path(log).read_text(errors='replace'), 12)}"
        for rule, log in found
        if Path(log).is_file()
    ]
    return "\n\n".join(parts) or _end(said, 40)


def repeated(said: str) -> list[str]:
    """A line for each job that failed, of all that Snakemake said in a run that went well."""
    found = dict.fromkeys(_FAILED.findall(said))
    return [
        f"a job of {rule} failed and was repeated; its log is {failed_log(log)}"
        for rule, log in found
    ]


_FAILED = re.compile(
    r"^Error in rule (\w+):\n(?:    .*\n)*?    log: (.+?)(?:, .*)? \(check", re.MULTILINE
)
"""A failed job and its own log; a cluster's log may stand after it."""


def _end(text: str, lines: int) -> str:
    return "\n".join(f"    {line[:300]}" for line in text.splitlines()[-lines:])


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1]))
    except (InputError, OSError) as error:
        sys.exit(str(error))
