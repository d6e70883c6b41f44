"""Statistics of a sensitivity study, Eqs. (24) to (29): no mechanics here."""
