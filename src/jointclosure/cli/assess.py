"""Assess the joint of two scanned walls: what accuracy costs, how hard the joint is, and which
effects it needs. The joint is simulated with several numerical settings, without each effect, and
as copies that should give equal results. Simulated joints are kept in the folder, so that the same
command continues after an interruption.

example:
  jointclosure assess top.xyz bottom.xyz --units mm --rock granite --stress 10 --within 0.05
"""

import argparse
from pathlib import Path
from typing import Any

from jointclosure.assessment.assess import assess, assess_as_checked, checked_request
from jointclosure.cli import command_results, options
from jointclosure.execution.progress import bar
from jointclosure.execution.workers import number_of_workers
from jointclosure.joint.checked_conditions import on_grid
from jointclosure.joint.conditions import Conditions
from jointclosure.parameters import RESOLVED
from jointclosure.uncertainty.expected_cost import rough_time
from jointclosure.walls.wall_files import registered_walls


def declare(command: argparse.ArgumentParser) -> None:
    options.add_walls(command)
    options.add_conditions(command, RESOLVED, states=False)
    asked = command.add_argument_group("request")
    options.add_keywords(asked, assess, "within", "budget", "workers")
    text = "folder of the results (default assessed_joint)"
    in_python = ("--folder",)
    default = Path("assessed_joint")
    options.add_file_option(command, "--output", text, others=in_python, default=default)


def _announced(joints: int, seconds: float) -> None:
    """Print how many simulations follow, and a rough forecast of their processor time [s]."""
    print(
        f"- {joints} further simulations: about {rough_time(seconds)} of processor time together. "
        "If the joint takes long by the paper's steps, without gouge or without interaction, it is "
        "several times as much",
        flush=True,
    )


def run(arguments: argparse.Namespace) -> int:
    """Assess the joint, print the assessment and write its folder; return 1 if it is not stable."""
    _, stated = options.keywords(arguments, Conditions, RESOLVED, "max_normal_stress")
    asked = options.given(arguments, ("within", "budget"))
    workers = options.given(arguments, ("workers",))
    number_of_workers(workers.get("workers"))
    spacing = stated.pop("spacing", None)
    checked = checked_request(Conditions(spacing=spacing, **stated), **asked)
    scans, grid = (options.given(arguments, names) for names in (options.SCANS, options.PLACES))
    walls = arguments.upper, arguments.lower
    unusual = checked.unusual_values
    pair = registered_walls(*walls, scans, checked.spacing, unusual_values=unusual, **grid)
    print("\n".join(f"- {line}" for line in pair.remarks), flush=True)
    arguments.output.mkdir(exist_ok=True)
    with bar("simulating") as show:
        joint = [(pair.upper, pair.lower)]
        conditions = on_grid(checked, pair.spacing)
        kept = {"folder": arguments.output, "report": show, "forecast": _announced, **workers}
        assessment = assess_as_checked(joint, conditions, **asked, **kept)
    print(assessment)
    title = " on ".join(Path(wall).name for wall in walls)
    settings = {"upper": walls[0], "lower": walls[1], **scans, **grid, **stated, **asked}
    record = {
        "sentences": assessment.sentences,
        "conclusion": assessment.conclusion,
        "title": title,
    } | command_results.attributes(settings)
    written: dict[str, Any] = {
        "closures.csv": assessment.closures,
        "differences.csv": assessment.differences,
        "hardness.csv": assessment.hardness,
        "limits.csv": assessment.limits,
        "assessment.json": record,
    }
    if assessment.price.shape[0] > 1:
        from jointclosure.plotting.assessment import assessment_figure

        written["assessment.png"] = assessment_figure(assessment, title)
    print(command_results.write_folder(arguments.output, "assess", written))
    return int(assessment.hardness.verdict[0] == "not stable")
