#!/usr/bin/env bash
# lmfit 1.3.4 turns a bounded parameter into an unbounded one, also for methods of SciPy that know bounds. The derivative of this map is 0
# at the bound: viscous friction that begins at its `min` of 0 has no slope there. L-BFGS-B, BFGS, CG, SLSQP, TNC and trust-constr leave
# it at 0 and report success; `leastsq` and `least_squares` leave the bound all the same, and Nelder-Mead is the other way round: it
# leaves 0 and stays at 1e-9. SciPy 1.17.1 with its own bounds, from the same start, finds 60 N s/m by each of its five.
. "$(dirname "$0")/common.sh"
pinned lmfit==1.3.4 scipy==1.17.1 numpy==2.3.5
python -W ignore - <<'PROGRAM'
import lmfit
import numpy as np
from scipy.optimize import minimize

velocity = np.linspace(-1, 1, 201)
force = 20 * np.tanh(velocity / 0.02) + 60 * velocity


def deviations(coulomb, viscous):
    return coulomb * np.tanh(velocity / 0.02) + viscous * velocity - force


def fitted(method, start):
    parameters = lmfit.Parameters()
    parameters.add("coulomb", value=10)
    parameters.add("viscous", value=start, min=0)
    return lmfit.minimize(lambda p: deviations(p["coulomb"].value, p["viscous"].value), parameters, method=method)


stay = {"lbfgsb", "bfgs", "cg", "slsqp", "tnc", "trust-constr"}
for method in ("leastsq", "least_squares", "nelder", "powell", *sorted(stay)):
    at_bound, above = fitted(method, 0.0), fitted(method, 1e-9)
    print(f"{method:13} from 0: {at_bound.params['viscous'].value:6.3f}, from 1e-9: {above.params['viscous'].value:6.3f}, success {at_bound.success}")
    assert at_bound.success and above.success, method
    assert abs(at_bound.params["viscous"].value - (0 if method in stay else 60)) < 1e-2, method
    assert abs(above.params["viscous"].value - (0 if method == "nelder" else 60)) < 1e-2, method

for method in ("L-BFGS-B", "SLSQP", "TNC", "trust-constr", "Nelder-Mead"):
    found = minimize(lambda p: np.sum(deviations(*p) ** 2), [10, 0], method=method, bounds=[(None, None), (0, None)]).x[1]
    print(f"{method:13} of SciPy from 0: {found:6.3f}")
    assert abs(found - 60) < 1e-2, method
PROGRAM
