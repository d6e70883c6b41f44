"""Results that an assessment compares."""

CLOSURE = "max_closure_seated_net"
"""Net closure since seating, at the maximum, by which copies of a joint are compared."""
GROSS = "max_closure"
"""Gross closure since first touch, at the maximum."""
STIFFNESS = "stiffness_net"
"""Net chord stiffness."""
JUDGED = (CLOSURE, GROSS)
"""Results to which a request applies."""
LIMITED = (*JUDGED, STIFFNESS)
"""Results of a lone joint whose errors have limits."""
ASSESSED = {
    CLOSURE: "net closure",
    GROSS: "gross closure",
    STIFFNESS: "net chord stiffness",
    "mean_aperture_at_max": "aperture",
}
"""Quantities that are compared, and their short titles."""
