#!/usr/bin/env bash
# estim8 0.1.6 takes every variable with initial="exact" for a parameter: the output x, a state with an exact start value, is among the
# parameters and not among the observables, as are inputs and, as numbers, enumerations. An FMU with a Boolean parameter cannot be
# loaded (float('false')). Every run passes a relative tolerance of 1e-4, whatever the FMU's default experiment says (1e-6 here).
. "$(dirname "$0")/common.sh"
pinned estim8==0.1.6 fmpy==0.3.32
probe 2 probe.fmu
probe 2 boolean.fmu 's|</ModelVariables>|<ScalarVariable name="fast" valueReference="101" causality="parameter" variability="fixed" initial="exact"><Boolean start="false"/></ScalarVariable>&|'
python -W ignore - <<'PROGRAM'
from estim8.models import FmuModel

model = FmuModel("probe.fmu", fmi_type="CoSimulation")
print("parameters", model.parameters, "observables", model.observables)
assert model.parameters == {"u": 5.0, "x": 0.0, "gain": 1.0, "mode": 2.0, "modeNumber": 0.0}
assert model.observables == ["der(x)", "moving"]
model.simulate(0, 1, 0.1, observe=["x"])
calls = open("calls").read()
assert "tolerance 0.0001" in calls and "set real 2 0" in calls, calls
try:
    FmuModel("boolean.fmu", fmi_type="CoSimulation")
except ValueError as error:
    print("with a Boolean:", error)
    assert "could not convert string to float: 'false'" in str(error)
else:
    raise SystemExit("the Boolean was read")
PROGRAM
