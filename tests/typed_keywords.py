"""Calls that only mypy checks: `make lint` fails if it overlooks a wrong keyword."""

import jointclosure as jc

walls = jc.wall_pair(8.0, (24, 24), 0.25e-3, seed=1)
scans = "upper.npz", "lower.npz"
jc.simulate(*walls, spacing=0.25e-3, rock="granite", max_normal_stress=1e6, cycles=3)
jc.simulate(*walls, spacing=0.25e-3, rok="granite")  # type: ignore[call-arg]
jc.simulate(*walls, spacing="fine")  # type: ignore[arg-type]
jc.simulate_ensemble([walls], rok="granite")  # type: ignore[call-arg]
jc.close(*scans, max_stress=1e6)  # type: ignore[call-arg]
jc.assess(walls, rok="granite")  # type: ignore[call-arg]
jc.choose_effects([walls], rok="granite")  # type: ignore[call-arg]
jc.fit("curve.csv", rock="granite", jrc=10.0, sise=0.02)  # type: ignore[call-arg]
jc.validate("curve.csv", jrc=10.0)  # type: ignore[call-arg]
