#!/usr/bin/env bash
# PythonFMU 0.7.0 and PythonFMU3 0.3.4 with `--handle-state` write into the FMU that its state can be saved and set. Saved are its registered
# variables and nothing else: the integral of a controller that is an attribute of the class goes on from where it was, and the step that
# is repeated differs from the first. An exception in `do_step` is status fatal, after which FMI allows no further call; the instance
# would go on undisturbed. A return value of None, as of a method without `return`, is status discard in the first and an error in the other.
. "$(dirname "$0")/common.sh"
pinned pythonfmu==0.7.0 pythonfmu3==0.3.4 fmpy==0.3.32 numpy==2.3.5
cat >two.py <<'CLASS'
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Controller(Fmi2Slave):
    def __init__(self, **options):
        super().__init__(**options)
        self.error, self.fault, self.command, self.shown, self.integral = 0.0, 0.0, 0.0, 0.0, 0.0
        for name in ("error", "fault"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("command", "shown"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        if self.fault == 1:
            raise ValueError("no sensor")
        self.shown += self.error * step_size
        self.integral += self.error * step_size
        self.command = self.integral
        if self.fault != 2:
            return True
CLASS
# FMI 3.0 wants a variable for the time, which the class registers itself.
cat >time <<'LINES'
        self.time = 0.0
        self.register_variable(Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous))
LINES
sed 's/pythonfmu/pythonfmu3/; s/Fmi2Slave, Real/Fmi2Slave, Fmi2Variability, Real/; s/Fmi2/Fmi3/g; s/Real/Float64/g; s/Controller/Controller3/' two.py |
    sed '/self.error, self.fault/r time' >three.py
pythonfmu build -f two.py --handle-state
pythonfmu3 build -f three.py --handle-state
python - <<'PROGRAM' 2>&1 | grep -v -e FATAL -e no.sensor
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave


def initialized(file):
    description = read_model_description(file)
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    kind = FMU2Slave if description.fmiVersion == "2.0" else FMU3Slave
    fmu = kind(guid=description.guid, unzipDirectory=extract(file), modelIdentifier=description.coSimulation.modelIdentifier, instanceName="c")
    fmu.instantiate()
    if kind is FMU2Slave:
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
    else:
        fmu.enterInitializationMode(startTime=0.0)
    fmu.exitInitializationMode()
    names = ("setReal", "getReal", "getFMUstate", "setFMUstate") if kind is FMU2Slave else ("setFloat64", "getFloat64", "getFMUState", "setFMUState")
    write, read, save, load = (getattr(fmu, name) for name in names)
    return fmu, lambda name, value: write([references[name]], [value]), lambda name: read([references[name]])[0], save, load


def outcome(call):
    try:
        call()
        return "ok"
    except FMICallException as error:
        return str(error).split(" with ")[1].rstrip(".")


for file in ("Controller.fmu", "Controller3.fmu"):
    fmu, write, read, save, load = initialized(file)
    write("error", 1.0)
    fmu.doStep(0, 0.1)
    state = save()
    fmu.doStep(0.1, 0.1)
    first = [round(read(name), 9) for name in ("shown", "command")]
    load(state)
    fmu.doStep(0.1, 0.1)
    again = [round(read(name), 9) for name in ("shown", "command")]
    print(file, "registered and unregistered integral at 0.2 s:", first, "- repeated from the state of 0.1 s:", again)
    assert first == [0.2, 0.2] and again == [0.2, 0.3]
    outcomes = []
    for fault in (1.0, 0.0, 2.0):
        write("fault", fault)
        outcomes.append(outcome(lambda: fmu.doStep(0.2, 0.1)))
    print(file, "exception, none, no return:", outcomes, "- integral", round(read("command"), 9))
    assert round(read("command"), 9) == 0.5
    assert outcomes == ["status 4 (fatal)", "ok", "status 2 (discard)"], outcomes
PROGRAM
