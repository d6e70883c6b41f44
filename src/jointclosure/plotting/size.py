"""Closure, residual closure and stiffness against patch length and spacing."""

import pandas as pd
from matplotlib.figure import Figure


def size_figure(table: pd.DataFrame) -> Figure:
    raise NotImplementedError
