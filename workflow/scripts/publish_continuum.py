"""Renew docs/continuum.md from results/continuum. Run by hand after `benchmarks/continuum.py`."""

import shutil
from pathlib import Path

import pandas as pd
from markers import fill
from publish_measured import markdown

from jointclosure.statistics.standard_errors import rounded
from jointclosure.storage.text import read_csv

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "results/continuum"
CLOSURES = {
    "closure_1_um": "closure, cycle 1 (µm)",
    "residual_um": "residual closure (µm)",
    "closure_2_um": "closure, cycle 2 (µm)",
    "contact_1_percent": "cells in contact at 30 MPa (%)",
    "contact_half_unloaded_percent": "the same unloaded to 15 MPa (%)",
}
STIFFNESSES = {
    f"stiffness_{branch}_MPa_per_mm": f"{branch} (MPa/mm)"
    for branch in ("loading", "unloading", "reloading")
}


def finding() -> str:
    """What was found, in a few sentences."""
    table = read_csv(RESULTS / "tables/continuum.csv").set_index(["model", "reading"])
    names = list(dict.fromkeys(table.index.get_level_values("model")))
    hard, tabor = (next(name for name in names if word in name) for word in ("at break", "2.8"))

    def told(model: str, reading: str) -> str:
        own = table.loc[(model, reading)]
        return rounded(own.ratio, own.ratio_error)

    return (
        "Pressed once, a continuum whose pressure is limited to that at which our asperities break "
        f"closes {told(hard, 'closure_1_um')} times as far as the asperity model, keeps "
        f"{told(hard, 'residual_um')} times its residual closure, and touches in "
        f"{told(hard, 'contact_1_percent')} times as many cells. Unloaded and pressed again it is "
        f"another model: its second closure is {told(hard, 'closure_2_um')} times ours, and "
        f"{told(tabor, 'closure_2_um')} times where the hardness is 2.8 σc.\n"
    )


def shown(columns: dict[str, str]) -> str:
    """Means of readings with errors, and their ratios to the asperity model's."""
    table = read_csv(RESULTS / "tables/continuum.csv")
    rows = []
    for model in dict.fromkeys(table.model):
        own = table[table.model == model].set_index("reading")
        row = {"model": model.replace("sigma_c", "σc").replace("contact_m", "ContactM")}
        row["joints"] = own.realizations.min()
        for reading, title in columns.items():
            mean, error, ratio, doubt = own.loc[reading, ["mean", "error", "ratio", "ratio_error"]]
            cell = rounded(mean, error) if mean == mean else ""
            told = model != table.model.iloc[0] and ratio == ratio and mean != 0.0
            row[title] = f"{cell} (x {rounded(ratio, doubt)})" if told else cell
        rows.append(row)
    return markdown(pd.DataFrame(rows))


def codes() -> str:
    """How far ContactMechanics and our own solution of the same law differ."""
    rows = read_csv(RESULTS / "tables/continuum_codes.csv").itertuples()
    told = [
        f"{_off(row.at_largest_stress)} at 30 MPa and {_off(row.anywhere)} at any stress of first "
        f"loading (hardness {row.hardness.replace('sigma_c', 'σc')}, {row.joints} joints)"
        for row in rows
    ]
    return f"On joints that both close the closures of the two differ by {'; by '.join(told)}.\n"


def _off(percent: float) -> str:
    """A largest difference in words."""
    return "less than 0.001 %" if percent < 1e-3 else f"at most {percent:.2g} %"


def read_to() -> str:
    """The stress to which the stiffness of loading is read."""
    table = read_csv(RESULTS / "tables/continuum.csv").set_index(["model", "reading"])
    own = table.loc[(table.index[0][0], "loading_read_to_MPa")]
    return f"It begins at {rounded(own['mean'], own.error)} MPa, the mean over the joints.\n"


def main() -> None:
    """Fill the document, and copy its figure."""
    parts = {
        "finding": finding(),
        "codes": codes(),
        "read to": read_to(),
        "closures": shown(CLOSURES),
        "stiffness": shown(STIFFNESSES),
    }
    fill(ROOT / "docs/continuum.md", parts)
    shutil.copy(RESULTS / "figures/continuum.png", ROOT / "docs/images/continuum.png")


if __name__ == "__main__":
    main()
