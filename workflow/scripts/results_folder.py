"""Print the folder of a study's results, for the Makefile; refuse a file that is not plain data."""

import sys
from pathlib import Path

from jointclosure.config.configuration import ConfigurationError, read_plain

ROOT = Path(__file__).parents[2]


def main(override: str | None) -> str:
    """Folder of the study that the default configuration and an override name."""
    name = "paper"
    for path in (ROOT / "config/default.yaml", override):
        if path:
            name = read_plain(path).get("study", {}).get("name", name)
    return f"results/{name}/ (tables, figures, study.nc)"


if __name__ == "__main__":
    try:
        print(main(sys.argv[1] if len(sys.argv) > 1 else None))
    except ConfigurationError as error:
        sys.exit(str(error))
