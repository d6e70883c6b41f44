"""Ablation: contribution of each effect to closure, and its cost."""
