"""What the paper claims: one table of its claims, and how each is judged.

`table` has the claims: number, text, where the paper has it, and its statement. `statements` has
what a statement means: margins, numbers of a model that are large where it is true, and what a
study finds that is judged as the paper judges. `found` has such studies.
"""
