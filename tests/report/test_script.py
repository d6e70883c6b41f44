"""The workflow's script: from the files of a study to the file of the page."""

import importlib.util
from pathlib import Path

import pandas as pd

from jointclosure.dataset import write_csv, write_netcdf

ROOT = Path(__file__).parents[2]
PATH = ROOT / "workflow/scripts/write_report.py"


def script():
    spec = importlib.util.spec_from_file_location("write_report", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


TABLES = ("closures", "intervals", "claims", "predictive", "joint", "elasticities")


def files_of(material, pictures, folder: Path) -> dict:
    """Inputs of the rule, written to a folder."""
    write_netcdf(material.study, folder / "study.nc")
    for name in TABLES:
        write_csv(getattr(material, name), folder / f"{name}.csv")
    for picture in pictures:
        (folder / f"{picture.name}.png").write_bytes(picture.png)
    return {
        "study": folder / "study.nc",
        **{name: folder / f"{name}.csv" for name in TABLES},
        "measured": [],
        "accuracy": [],
        "figures": [str(folder / f"{picture.name}.png") for picture in pictures],
        "captions": [str(ROOT / f"workflow/report/{picture.name}.rst") for picture in pictures],
        "paper": ROOT / "workflow/resources/paper_table_3.csv",
    }


def test_files_give_the_page_that_their_content_gives(
    material, page, pictures, configuration, tmp_path
):
    inputs = files_of(material, pictures, tmp_path)
    (tmp_path / "benchmarks/close_surfaces").mkdir(parents=True)
    for job in material.benchmarks.itertuples():
        rss = "-" if pd.isna(job.max_rss) else job.max_rss
        (tmp_path / f"benchmarks/close_surfaces/{job.job}.tsv").write_text(
            f"s\tmax_rss\n{job.s}\t{rss}\n"
        )
    settings = {"configuration": configuration, "benchmarks": tmp_path / "benchmarks"}
    lines = []
    script().main(inputs, settings, tmp_path / "report.html", lines.append)
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == page
    assert len(lines) == 1


def test_a_study_that_varies_nothing_has_a_page(material, pictures, configuration, tmp_path):
    inputs = files_of(material, pictures, tmp_path) | {name: [] for name in TABLES[1:]}
    settings = {"configuration": configuration, "benchmarks": tmp_path / "none"}
    script().main(inputs, settings, tmp_path / "report.html", lambda line: None)
    assert "No property was varied" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_study_whose_numerics_were_chosen_by_a_word_has_a_page(
    material, pictures, configuration, tmp_path
):
    numerics = configuration["numerics"] | {"preset": "accurate"}
    settings = {
        "configuration": configuration | {"numerics": numerics},
        "benchmarks": tmp_path / "none",
    }
    inputs = files_of(material, pictures, tmp_path)
    script().main(inputs, settings, tmp_path / "report.html", lambda line: None)
    assert (tmp_path / "report.html").is_file()
