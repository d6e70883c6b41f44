"""Steps of the workflow: all files that a configuration has, and the functions that make them."""

import functools
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from jointclosure.engine.cache import digest
from jointclosure.walls.scans import files_of
from studies.commands.report import report_page
from studies.frame.cases import closed_keys, dataset_of, ensembles_of, wall_digests
from studies.frame.closing import Ensemble, close_ensemble, price_accuracy
from studies.frame.configuration import Configured
from studies.frame.experiments import cached, experiments_in, steps_of
from studies.frame.files import DEFAULT, PAPER_TABLE_3
from studies.frame.plan import steps_of_products
from studies.frame.products import EARLY, Step
from studies.frame.rocks import (
    ScannedWalls,
    check_files,
    measured_curves,
    wall_files,
)
from studies.frame.walls import prepare_walls
from studies.paper.products import PRODUCTS
from studies.paper.report.page import template_digest
from studies.verification import products as verification


class Pipeline:
    """Steps by the names of their rules, and targets: files that belong together, and a message.

    ``apart``: each file of the cache is a job of its own, on another machine. With ``check`` what
    is slow to check is checked, before any job.
    """

    def __init__(self, configured: Configured, apart: bool, check: bool):
        self.keys, self.typed = configured
        self.folder = f"results/{self.typed.study.name}"
        self._apart = apart
        check_files(self.typed.rocks)
        measured_curves(self.typed.curves)
        experiments = experiments_in(self.keys)
        for experiment in experiments.values() if check else ():
            experiment.check(configured)
        self.designs = {name: one.design(configured) for name, one in experiments.items()}
        self.ensembles = {name: Ensemble(self.typed, name) for name in ensembles_of(self.typed)}
        self.cached = functools.cache(functools.partial(cached, configured))
        kinds = self.ensembles | self.designs
        self.kernels = functools.cache(lambda kind: kinds[kind].kernels())
        scanned = (name for name, rock in self.typed.rocks.items() if rock.walls)
        self.walls = [f"{self.folder}/walls/{name}.nc" for name in scanned]
        products = steps_of_products("paper", configured)
        files = [f for name in products if not PRODUCTS[name].apart for f in products[name].files]
        joints = self._ensembles()
        self.steps = joints | {
            f"prepare_walls_{name}": self._scan(name, rock.walls)
            for name, rock in self.typed.rocks.items()
            if rock.walls
        }
        self.steps |= products | {"write_report": self._report(files)} | verification.steps()
        datasets = [f"{self.folder}/{dataset_of(name)}" for name in ("cases", "pool")]
        made = {file for step in joints.values() for file in step.files}
        study = [*files, *self.walls, *(file for file in datasets if file in made)]
        self.targets = {
            "all": (study, f"The study {self.typed.study.name} is complete"),
            "report": (self.steps["write_report"].files, "The report is {input[0]}"),
            "conclusions": (products["conclude"].files, "The judged conclusions are in {input[0]}"),
            "hard_cases": (verification.TARGET, "The hard cases are closed and judged"),
        }
        for name, experiment in experiments.items():
            key, closed = functools.partial(self._key, name), self._closed(name)
            steps = steps_of(configured, self.designs[name], closed, key)
            self.steps |= steps
            done = f"The experiment {name} is complete: {experiment.title}"
            self.targets[name] = ([file for step in steps.values() for file in step.files], done)

    def _key(self, *kinds: str) -> str:
        """Digest of all that the joints of some kinds depend on."""
        return digest(*(entry.key for kind in kinds for entry in self.cached(kind).values()))

    def closed_apart(self, *kinds: str) -> list[str]:
        """Files of the cache that are jobs of a cluster, whose nodes see no process of this one."""
        names = (name for kind in kinds for name in self.cached(kind)) if self._apart else ()
        return [f"{self.folder}/{name}.nc" for name in names]

    def _closed(self, *kinds: str) -> Callable[[Any], list[str]]:
        """Input function of these files, for Snakemake."""
        return lambda wildcards: self.closed_apart(*kinds)

    def _scan(self, rock: str, walls: ScannedWalls) -> Step:
        """Step of the scanned walls of a rock; contents of scans count, and not their times."""
        scans = [str(file) for scan in wall_files(walls).values() for file in files_of(scan)]
        settings = {
            "walls": walls,
            "digests": wall_digests(walls),
            "grid": self.typed.grid,
            "jrc_relation": self.typed.surface.jrc_relation,
            "unusual_values": self.typed.study.unusual_values == "allow",
            "realizations": max(
                one.configuration.study.realizations for one in self.ensembles.values()
            ),
        }
        output, inputs = [f"{self.folder}/walls/{rock}.nc"], {"scans": scans}
        return Step(prepare_walls, output, inputs, settings, untimed=inputs, priority=EARLY)

    def _ensembles(self) -> dict[str, Step]:
        """Steps of the datasets, and of the price of an accuracy; the pool, of all cores, last."""
        steps = {}
        for name in self.ensembles:
            file = dataset_of(name)
            steps[f"close_{Path(file).stem}"] = Step(
                close_ensemble,
                [
                    f"{self.folder}/{file}",
                    *([f"{self.folder}/first_walls.nc"] if name == "cases" else []),
                ],
                {"walls": self.walls, "closed": self._closed("effects_of", name)},
                {"name": name, "stated": closed_keys(self.keys)},
                functools.partial(self._key, "effects_of", name),
                priority=0 if name == "pool" else EARLY,
                all_cores=True,
                group="paper",
            )
        if "finest" in self.ensembles:
            firsts = [one for name in ("cases", "finest") for one in self.ensembles[name].firsts()]
            steps["price_accuracy"] = Step(
                price_accuracy,
                [f"{self.folder}/tables/accuracy_price.csv"],
                {"walls": self.walls},
                depends=lambda: digest(*(first.key for first in firsts)),
            )
        return steps

    def _report(self, files: list[str]) -> Step:
        """Step of the page of the study, with what other targets put into its folder."""
        figures = [file for file in files if file.endswith(".png")]
        beside = [
            f"{self.folder}/tables/{t}.csv" for t in ("assessment", "hardness", "conclusions")
        ]
        inputs = {
            "study": f"{self.folder}/study.nc",
            "tables": [file for file in files if Path(file).parent.name == "tables"],
            "figures": figures,
            "stated": [os.path.relpath(file) for file in (PAPER_TABLE_3, DEFAULT)],
            "beside": [table for table in beside if Path(table).exists()],
        }
        output = [f"{self.folder}/report.html"]
        return Step(report_page, output, inputs, depends=template_digest, untimed={"beside"})

    def kernels_file(self, kind: str) -> str:
        """File of compiled kernels of a kind; its name has their digest.

        A changed list must be a missing file: Snakemake plans only the maker of an ancient file
        that is there and was made with other parameters.
        """
        kind = kind.replace("effects_of", "cases")
        return f"{self.folder}/logs/{kind}_kernels_{digest(self.kernels(kind))[:8]}.txt"
