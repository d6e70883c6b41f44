# Tables of other studies that conclusions rest on, where those were run.
from jointclosure.config.files import DEFAULT, read_plain

BESIDE = {
    "readings": ("readings", "readings.csv", "tabulate_readings"),
    "margins": (
        "global_sensitivity",
        "global_sensitivity_margins.csv",
        "tabulate_global_sensitivity",
    ),
    "choices": (
        "global_sensitivity",
        "global_sensitivity_conclusions.csv",
        "tabulate_global_sensitivity",
    ),
}


def beside(name):
    """A table of another study and its seal, where it was run and is about this study's model."""
    if STUDY != read_plain(DEFAULT)["study"]["name"]:
        return [], []
    folder, table, job = BESIDE[name]
    path = f"results/{folder}/tables/{table}"
    seals = seals_of(job, study=f"results/{folder}")
    return (
        (path, seals)
        if all(Path(each).exists() for each in [path, *seals])
        else ([], [])
    )
