"""Draw Snakemake's graph of the rules of the paper's study: docs/images/rules.svg.

`make docs` runs this. Without Graphviz (`apt-get install graphviz`) the stored picture is kept.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "docs/images/rules.svg"


def rule_graph() -> str:
    """Return the graph of the rules of the paper's study in the language of Graphviz."""
    command = [sys.executable, "-m", "snakemake", "--rulegraph", "--forceall"]
    ordered = os.environ | {"PYTHONHASHSEED": "0"}  # so that Snakemake's sets always have one order
    answer = subprocess.run(
        command, cwd=ROOT, env=ordered, capture_output=True, text=True, check=False
    )
    if answer.returncode:
        raise SystemExit(answer.stderr)
    return answer.stdout


if __name__ == "__main__":
    if shutil.which("dot"):
        command = ["dot", "-Tsvg", "-o", str(PICTURE)]
        subprocess.run(command, input=rule_graph(), text=True, check=True)
    else:
        print(f"{PICTURE}: kept, as Graphviz is not installed (apt-get install graphviz)")
