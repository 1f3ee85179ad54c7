#!/usr/bin/env bash
# component-model 0.4.0 makes an FMU from a class whose variables have values with units. Inside they are in SI units, and the description
# says so: a pressure of "7 bar" has a `unit` of base factor 1 and the `displayUnit` bar. Yet its `start` is 7, its `max` is 10, and the
# FMU takes and gives 7: through FMI it counts in display units, where FMI means `unit`. FMPy 0.3.32 that sets 6e5 for 6 bar has
# 6e10 Pa inside, far beyond `max`, which is logged and used. A variable in Pa and one in bar stand for two scales of the same `unit`.
. "$(dirname "$0")/common.sh"
pinned component-model==0.4.0 pythonfmu==0.7.0 pint==0.25.3 fmpy==0.3.32 numpy==2.3.5
cat >supply.py <<'CLASS'
from component_model.model import Model
from component_model.variable import Variable


class Supply(Model):
    def __init__(self, name="Supply", description="A pressure on an area", **options):
        super().__init__(name, description, **options)
        Variable(self, "pressure", "", causality="input", variability="continuous", start="7 bar", rng=("1 bar", "10 bar"))
        Variable(self, "area", "", causality="parameter", variability="fixed", start="800 mm**2")
        Variable(self, "inside", "", causality="output", variability="continuous", start="0 Pa")
        Variable(self, "force", "", causality="output", variability="continuous", start="0 N")

    def do_step(self, current_time, step_size):
        super().do_step(current_time, step_size)
        self.inside, self.force = self.pressure, self.pressure * self.area
        return True
CLASS
python -c 'from component_model.model import Model; Model.build("supply.py", dest=".")' >build.log 2>&1
python - 2>messages <<'PROGRAM'
from fmpy import read_model_description, simulate_fmu

description = read_model_description("Supply.fmu")
pressure, area, inside = (next(v for v in description.modelVariables if v.name == name) for name in ("pressure", "area", "inside"))
units = {unit.name: unit.baseUnit.factor for unit in description.unitDefinitions}
for variable in (pressure, area, inside):
    print(f"{variable.name}: start {variable.start}, max {variable.max}, unit {variable.unit} of factor {units[variable.unit]}, displayUnit {variable.displayUnit}")
assert abs(float(pressure.start) - 7) < 1e-9 and float(pressure.max) == 10 and pressure.displayUnit == "bar" and float(units[pressure.unit]) == 1
assert abs(float(area.start) - 800) < 1e-6 and float(units[area.unit]) == 1 and pressure.unit == inside.unit

for given, pascals in ((None, 7e5), (6.0, 6e5), (6e5, 6e10)):
    start = {} if given is None else {"pressure": given}
    last = simulate_fmu("Supply.fmu", stop_time=0.2, output_interval=0.1, start_values=start, output=["pressure", "inside", "force"])[-1]
    print(f"set {given}: pressure {last['pressure']:g}, inside {last['inside']:g} Pa, force {last['force']:g} N")
    assert abs(last["inside"] - pascals) < 1e-9 * pascals and abs(last["force"] - pascals * 8e-4) < 1e-9 * pascals
PROGRAM
grep -c "outside range" messages
