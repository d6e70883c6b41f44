"""Print the folder of a study's results, for the Makefile."""

import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]


def main(override: str | None) -> str:
    """Folder of the study that the default configuration and an override name."""
    name = "paper"
    for path in (ROOT / "config/default.yaml", override):
        if path:
            settings = yaml.safe_load(Path(path).read_text(encoding="utf-8")) or {}
            name = settings.get("study", {}).get("name", name)
    return f"results/{name}/ (tables, figures, study.nc)"


if __name__ == "__main__":
    print(main(sys.argv[1] if len(sys.argv) > 1 else None))
