"""Figures from datasets and tables; they read no files and compute no results of a study.

`jointclosure.plot` is the module ``plot``, which is imported when it is first used.
"""

import os

import lazy_loader

from jointclosure.compilation.cache_folder import has_home, temporary_cache
from jointclosure.inputs.extras import needs

if not has_home():  # without a home matplotlib does not start
    os.environ.setdefault("MPLCONFIGDIR", str(temporary_cache() / "matplotlib"))
with needs("figures", "a figure"):
    import matplotlib as _  # noqa: F401
    import seaborn as __  # noqa: F401

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["plot"])
