#!/usr/bin/env bash
# CasADi 3.8.2, a measured friction force over velocity in a table, for a model that is to be optimised: `interpolant("linear")` goes on beyond
# the last velocity with the last slope, `interpolant("bspline")` is 0 there, force and slope, also with `degree` 1. A carriage that
# becomes faster than the table, 1 % are enough, has no friction left. Within it the cubic curve through a Stribeck table, all of whose
# forces are between 30 N and 80 N, is -24 N at 0.2 m/s, where it drives. `degree` 1 has the signs of the table.
. "$(dirname "$0")/common.sh"
pinned casadi==3.8.2 numpy==2.3.5
python - <<'PROGRAM'
import casadi as ca
import numpy as np

half = np.array([0.02, 0.1, 0.5, 1.0])
force = np.array([40.0, 30.0, 50.0, 80.0])
velocities, forces = np.concatenate([-half[::-1], [0], half]), np.concatenate([-force[::-1], [0], force])
kinds = {
    "linear": ca.interpolant("f", "linear", [velocities], forces),
    "bspline": ca.interpolant("f", "bspline", [velocities], forces),
    "bspline, degree 1": ca.interpolant("f", "bspline", [velocities], forces, {"degree": [1]}),
}
asked = np.array([0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 1.01, 1.5])
print(f"{'m/s':18}", asked)
seen = {}
for name, law in kinds.items():
    seen[name] = np.array([float(law(v)) for v in asked])
    slope = float(law.jacobian()(1.5, 0))
    print(f"{name:18}", seen[name].round(2), "N, slope at 1.5 m/s:", slope)
    assert abs(slope - (60 if name == "linear" else 0)) < 1e-9, name
    assert np.allclose(seen[name][[0, 2, 4, 5]], force), name
assert np.allclose(seen["linear"], [40, 36.25, 30, 35, 50, 80, 80.6, 110])
assert np.allclose(seen["bspline"][-2:], 0) and abs(seen["bspline"][3] + 24.26) < 0.01
assert np.allclose(seen["bspline, degree 1"], [40, 36.25, 30, 35, 50, 80, 0, 0])
PROGRAM
