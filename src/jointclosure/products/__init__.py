"""Products of a study: its tables and figures, and what each is made of."""

from jointclosure.products import figures, tables
from jointclosure.products.frame import PRODUCTS, Product

__all__ = ["PRODUCTS", "Product", "figures", "tables"]
