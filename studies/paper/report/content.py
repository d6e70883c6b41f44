"""Content of the page: values for the template, from a study and its tables."""

import json
from typing import NamedTuple

import pandas as pd
import xarray as xr

from jointclosure.cli.page import Picture, provenance_rows
from jointclosure.engine.aggregation import succeeded
from jointclosure.engine.progress import duration
from studies.frame.config.configuration import resolved
from studies.paper.claims import OURS, TOLERANCE
from studies.paper.report import findings, running, settings, summary


class Material(NamedTuple):
    """Material of a page.

    ``study``: the dataset, whose curves are read case by case. ``closures``, ``checks``,
    ``intervals``, ``claims`` with their ``margins``, ``predictive``, ``joint``, ``elasticities``:
    tables of the study; all except the first two are None if a study has none. ``paper``: the
    paper's Table 3. ``default`` and ``schema``: the paper's configuration, and descriptions of
    keys. ``pictures``. ``benchmarks``: those of the workflow's jobs. ``measured``: fits of measured
    curves, or None. ``accuracy``: the table of `make accuracy`, or None. ``presets``: errors of the
    presets of the numerics. ``flow``: hydraulic apertures, or None for a study without flow.
    ``conclusions``: the table of `make conclusions`, or None.
    """

    study: xr.Dataset
    closures: pd.DataFrame
    checks: pd.DataFrame
    intervals: pd.DataFrame | None
    claims: pd.DataFrame | None
    margins: pd.DataFrame | None
    predictive: pd.DataFrame | None
    joint: pd.DataFrame | None
    elasticities: pd.DataFrame | None
    paper: pd.DataFrame
    default: dict
    schema: dict
    pictures: list[Picture]
    benchmarks: pd.DataFrame
    measured: pd.DataFrame | None
    accuracy: pd.DataFrame | None
    presets: pd.DataFrame
    flow: pd.DataFrame | None = None
    conclusions: pd.DataFrame | None = None


def content(material: Material) -> dict:
    """Return names and values for the template."""
    study = material.study
    keys = json.loads(study.attrs["configuration"])
    configuration = resolved(keys)
    titles = {name: rock.title for name, rock in configuration.rocks.items()}
    of_paper = set(titles) & set(material.paper.rock)
    rows = settings.setting_rows(keys, material.default, material.schema)
    numbers = summary.summary_sheet(study, material.closures, titles)
    counts = outcome(study)
    return {
        "finding": summary.finding(numbers, material.elasticities, configuration),
        "validity": summary.validity(configuration, counts),
        "first_pictures": [
            picture
            for picture in material.pictures
            if picture.name in summary.FIRST_PICTURES[configuration.study.draws]
        ],
        "configuration": configuration,
        "rocks": configuration.rocks,
        "cases": study.sizes["case"],
        "outcome": counts,
        "verdicts": {} if material.claims is None else _counts(_of_paper(material.claims).verdict),
        "tolerance": TOLERANCE,
        "compared": [titles[name] for name in titles if name in of_paper],
        "not_compared": [titles[name] for name in titles if name not in of_paper],
        "departures": settings.departures(rows),
        "failed_checks": int((~material.checks.passed).sum()),
        "pictures": material.pictures,
        "provenance": provenance_rows(study.attrs),
        "median_time": duration(float(study.timing_simulation.median())),
        "job_time": duration(float(material.benchmarks.s.sum())),
        "sheets": _sheets(material, titles, of_paper, rows) | {numbers.name: numbers},
    }


def outcome(study: xr.Dataset) -> dict:
    """Count simulations: all, used, failed, and those with each remark or failure."""
    good = succeeded(study)
    flags = {
        name: int(((study.status & mask) > 0).sum())
        for mask, name in running.flag_names(study).items()
    }
    used = good.sum("realization")
    return {
        "simulations": good.size,
        "used": int(good.sum()),
        "failed": int((~good).sum()),
        "least_used": int(used.min()),
        "most_used": int(used.max()),
        "flags": flags,
    }


def _of_paper(claims: pd.DataFrame) -> pd.DataFrame:
    """Return the claims of the paper, without variants added here."""
    return claims[claims.section != OURS] if "section" in claims else claims


def _counts(words: pd.Series) -> dict[str, int]:
    return words.value_counts(sort=False).to_dict()


def _sheets(material: Material, titles: dict, of_paper: set, rows: pd.DataFrame) -> dict:
    """Return all tables of the page by name."""
    study, intervals = material.study, material.intervals
    sheets = [
        findings.closure_sheet(material.closures, titles),
        running.check_sheet(material.checks),
        running.preset_sheet(
            material.presets, json.loads(study.attrs["configuration"]), material.default
        ),
        running.status_sheet(study, titles),
        running.failure_sheet(study),
        running.simulation_time_sheet(study, titles),
        running.job_time_sheet(material.benchmarks),
        settings.setting_sheet(rows),
    ]
    if material.claims is not None:
        sheets.append(findings.claim_sheet(material.claims, bool(of_paper)))
    if material.claims is not None and material.margins is not None:
        sheets.append(
            findings.evidence_sheet(material.claims, material.margins, titles, bool(of_paper))
        )
    if material.conclusions is not None:
        sheets.append(findings.conclusion_sheet(material.conclusions))
        sheets.append(findings.moved_sheet(material.conclusions))
    if material.flow is not None:
        sheets.append(findings.flow_sheet(material.flow, titles))
    if material.measured is not None:
        sheets.append(findings.measured_sheet(material.measured, titles))
    if intervals is not None and len(intervals) and "percent" in intervals:
        sheets += [
            findings.layout_sheet(intervals, titles, of_paper),
            findings.interval_sheet(intervals, titles, of_paper),
        ]
    if material.predictive is not None and len(material.predictive):
        sheets.append(findings.predictive_sheet(material.predictive, titles, bool(of_paper)))
    if material.joint is not None and len(material.joint):
        sheets.append(findings.joint_sheet(material.joint))
    if material.elasticities is not None and len(material.elasticities):
        sheets.append(findings.ranking_sheet(material.elasticities, titles))
        sheets.append(findings.elasticity_sheet(material.elasticities, titles))
    if material.accuracy is not None:
        sheets.append(running.accuracy_sheet(material.accuracy))
    return {sheet.name: sheet for sheet in sheets}
