"""Statistics of a sensitivity study, Eqs. (24) to (29), independent of mechanics.

`indifference` and `paired` compute the intervals of one study. `bootstrap`, `standard_errors` and
`control_variates` estimate their precision. `drawn_studies` and `predictive` simulate what
repetitions of a study would publish, and test whether a published table is one of them. `verdicts`
judges claims.
"""
