"""Figures from datasets and tables; they read no files and compute no results of a study."""

import os

from jointclosure.compilation.sources import has_home, temporary_cache
from jointclosure.inputs.extras import needs

if not has_home():  # without a home matplotlib does not start
    os.environ.setdefault("MPLCONFIGDIR", str(temporary_cache() / "matplotlib"))
with needs("figures", "a figure"):
    import matplotlib as _  # noqa: F401
    import seaborn as __  # noqa: F401
