"""Steps of the workflow: all files that a configuration has, and the functions that make them."""

import os
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

from jointclosure.engine.cache import digest
from jointclosure.walls.scans import files_of
from studies.commands.report import report_page
from studies.frame.cases import closed_keys, dataset_of, ensembles_of, wall_digests
from studies.frame.closing import Ensemble, close_ensemble
from studies.frame.configuration import Configuration
from studies.frame.experiments import cached, experiment_named, steps_of
from studies.frame.plan import steps_of_products
from studies.frame.products import EARLY, Step
from studies.frame.rocks import ScannedWalls, check_files, wall_files
from studies.frame.walls import prepare_walls
from studies.frame.yaml_files import DEFAULT, PAPER_TABLE_3
from studies.paper.measured import measured_curves
from studies.paper.needs import curve_settings
from studies.paper.price import price_accuracy
from studies.paper.products import PRODUCTS
from studies.paper.report.page import template_digest
from studies.verification import products as verification


class Pipeline:
    """Steps by the names of their rules, and targets: files that belong together, and a message.

    ``apart``: each file of the cache is a job of its own, on another machine. With ``check`` what
    is slow to check is checked, before any job.
    """

    def __init__(self, study: Configuration, apart: bool, check: bool):
        self.study, self._apart = study, apart
        self.folder = f"results/{study.study.name}"
        check_files(study.rocks)
        measured_curves(curve_settings(study))
        experiments = {name: experiment_named(name) for name in study.study_sections}
        for experiment in experiments.values() if check else ():
            experiment.check(study)
        self.designs = {name: one.design(study) for name, one in experiments.items()}
        self.ensembles = {name: Ensemble(study, name) for name in ensembles_of(study)}
        self.cached = cache(partial(cached, study))
        kinds = self.ensembles | self.designs
        self.kernels = cache(lambda kind: kinds[kind].kernels())
        scanned = {name: rock.walls for name, rock in study.rocks.items() if rock.walls}
        self.walls = [study.file(f"walls/{name}.nc") for name in scanned]
        products = steps_of_products("paper", study)
        files = [f for name in products if not PRODUCTS[name].apart for f in products[name].files]
        joints = self._ensembles()
        scans = {f"prepare_walls_{name}": self._scan(name, scan) for name, scan in scanned.items()}
        report = {"write_report": self._report(files)}
        self.steps = joints | scans | products | report | verification.steps()
        datasets = [study.file(dataset_of(name)) for name in self.ensembles if name != "finest"]
        self.targets = {
            "all": ([*files, *self.walls, *datasets], f"The study {study.study.name} is complete"),
            "report": (self.steps["write_report"].files, "The report is {input[0]}"),
            "conclusions": (products["conclude"].files, "The judged conclusions are in {input[0]}"),
            "hard_cases": (verification.TARGET, "The hard cases are closed and judged"),
        }
        for name, experiment in experiments.items():
            key, closed = partial(self._key, name), self._closed(name)
            steps = steps_of(study, self.designs[name], closed, key)
            self.steps |= steps
            done = f"The experiment {name} is complete: {experiment.title}"
            self.targets[name] = ([file for step in steps.values() for file in step.files], done)

    def _key(self, *kinds: str) -> str:
        """Digest of all that the joints of some kinds depend on."""
        return digest(*(entry.key for kind in kinds for entry in self.cached(kind).values()))

    def closed_apart(self, *kinds: str) -> list[str]:
        """Files of the cache that are jobs of a cluster, whose nodes see no process of this one."""
        names = (name for kind in kinds for name in self.cached(kind)) if self._apart else ()
        return [self.study.file(f"{name}.nc") for name in names]

    def _closed(self, *kinds: str) -> Callable[[Any], list[str]]:
        """Input function of these files, for Snakemake."""
        return lambda wildcards: self.closed_apart(*kinds)

    def _scan(self, rock: str, walls: ScannedWalls) -> Step:
        """Step of the scanned walls of a rock; contents of scans count, and not their times."""
        scans = [str(file) for scan in wall_files(walls).values() for file in files_of(scan)]
        closed = (one.configuration.study.realizations for one in self.ensembles.values())
        settings = {
            "walls": walls,
            "digests": wall_digests(walls),
            "grid": self.study.grid,
            "jrc_relation": self.study.surface.jrc_relation,
            "unusual_values": self.study.study.unusual_values == "allow",
            "realizations": max(closed),
        }
        output, inputs = [self.study.file(f"walls/{rock}.nc")], {"scans": scans}
        return Step(prepare_walls, output, inputs, settings, untimed=inputs, priority=EARLY)

    def _ensembles(self) -> dict[str, Step]:
        """Steps of the datasets, and of the price of an accuracy; the pool, of all cores, last."""
        steps = {}
        for name in self.ensembles:
            files = [dataset_of(name), *(["first_walls.nc"] if name == "cases" else [])]
            steps[f"close_{Path(files[0]).stem}"] = Step(
                close_ensemble,
                list(map(self.study.file, files)),
                {"walls": self.walls, "closed": self._closed("effects_of", name)},
                {"name": name, "stated": closed_keys(self.study.stated)},
                partial(self._key, "effects_of", name),
                priority=0 if name == "pool" else EARLY,
                all_cores=True,
                group="paper",
            )
        if "finest" in self.ensembles:
            firsts = [one for name in ("cases", "finest") for one in self.ensembles[name].firsts()]
            steps["price_accuracy"] = Step(
                price_accuracy,
                [self.study.file("tables/accuracy_price.csv")],
                {"walls": self.walls},
                depends=lambda: digest(*(first.key for first in firsts)),
            )
        return steps

    def _report(self, files: list[str]) -> Step:
        """Step of the page of the study, with what other targets put into its folder."""
        names = ("assessment", "hardness", "conclusions")
        beside = (self.study.file(f"tables/{name}.csv") for name in names)
        inputs = {
            "study": self.study.file("study.nc"),
            "tables": [file for file in files if Path(file).parent.name == "tables"],
            "figures": [file for file in files if file.endswith(".png")],
            "stated": [os.path.relpath(file) for file in (PAPER_TABLE_3, DEFAULT)],
            "beside": [table for table in beside if Path(table).exists()],
        }
        output = [self.study.file("report.html")]
        return Step(report_page, output, inputs, depends=template_digest, untimed={"beside"})

    def kernels_file(self, kind: str) -> str:
        """File of compiled kernels of a kind; its name has their digest.

        A changed list must be a missing file: Snakemake plans only the maker of an ancient file
        that is there and was made with other parameters.
        """
        kind = kind.replace("effects_of", "cases")
        return self.study.file(f"logs/{kind}_kernels_{digest(self.kernels(kind))[:8]}.txt")
