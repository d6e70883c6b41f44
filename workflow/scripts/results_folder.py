"""Print the folder of a study's results, for the Makefile; refuse one that cannot be run."""

import sys
from pathlib import Path

from jointclosure.inputs import InputError
from jointclosure.storage.text import read_csv
from studies.frame.config.configuration import configured, merged_study


def main(override: str | None) -> str:
    """Folder of the study that the default configuration and an override name."""
    paths = [Path(override)] if override else []
    name = configured(merged_study(*paths), read_csv).typed.study.name
    return f"results/{name}/ (tables, figures, study.nc)"


if __name__ == "__main__":
    try:
        print(main(sys.argv[1] if len(sys.argv) > 1 else None))
    except InputError as error:
        sys.exit(str(error))
