"""Derivatives of inputs and outputs."""

import numpy as np
from bounds import assert_close
from client import Client
from shared import run


def test_held_slope_continues_the_input(client: Client) -> None:
    """Setting the slope of the voltage equals setting it in small steps, in the limit."""
    slope = 20.0
    client.start({"valveVoltage": 5.0})
    reference = [client.variables["valveVoltage"].valueReference]
    client.slave.setRealInputDerivatives(reference, [1], [slope])
    client.advance(0.05)
    with_slope = client.get(["valve.spool", "chamberA.pressure"])
    client.slave.reset()
    client.start({"valveVoltage": 5.0})
    count = 5000
    for index in range(count):
        # The mean of the ramp over the step.
        client.set({"valveVoltage": 5.0 + slope * 0.05 * (index + 0.5) / count})
        client.advance(0.05 * (index + 1) / count)
    spool, pressure = client.get(["valve.spool", "chamberA.pressure"])
    assert_close(with_slope[0], spool, within=5e-7, what="spool")
    assert_close(with_slope[1], pressure, within=0.05, what="pressure")


def test_output_derivatives_match_the_outputs(client: Client) -> None:
    client.start({"friction.law": "LuGre"})
    for _ in run(client, 0.3, 1e-3):
        pass
    names = ["position", "chamberA.pressure", "chamberB.pressure", "valve.spool"]
    references = [client.variables[name].valueReference for name in names]
    slopes = list(client.slave.getRealOutputDerivatives(references, [1] * len(names)))
    before = np.array(client.get(names))
    step = 1e-6
    client.advance(client.time + step)
    estimates = (np.array(client.get(names)) - before) / step
    assert_close(slopes, estimates, within=1e-6, rel=1e-3, what="slopes")


def test_directional_derivative_of_acceleration(client: Client) -> None:
    """Sliding: a force on the carriage accelerates the moving mass and, at the first instant, nothing else."""
    client.start({"friction.law": "Stribeck", "velocity0": 0.3})
    client.advance(1e-3)
    assert client.get(["sticking"]) == [0.0]
    reference = {name: client.variables[name].valueReference for name in ("acceleration", "externalForce")}
    derivative = client.slave.getDirectionalDerivative([reference["acceleration"]], [reference["externalForce"]], [1.0])
    assert_close(derivative, [1.0 / 0.88], rel=1e-14, what="acceleration by force")
