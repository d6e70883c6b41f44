"""Products of a study: its tables and figures, and what each is made of."""

from studies.frame.products.frame import PRODUCTS, Product
from studies.paper import figures, tables

__all__ = ["PRODUCTS", "Product", "figures", "tables"]
