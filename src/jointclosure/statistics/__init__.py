"""Statistics of a sensitivity study, Eqs. (24) to (29): no mechanics here.

`indifference` and `paired` have the intervals of one study, `monotone` those without a
polynomial; `bootstrap`, `standard_errors` and `control_variates` their precision;
`drawn_studies`, `predictive` and `joint_tests` what repetitions of a study would publish, and
whether a table is one of them; `verdicts` what follows for a claim.
"""
