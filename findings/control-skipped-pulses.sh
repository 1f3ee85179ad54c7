#!/usr/bin/env bash
# python-control 0.10.2, input_output_response: the steps of its solver follow the state, not the times of the input. A cylinder that rests
# lets them grow tenfold each, and a command that begins and ends between two stages is never read: 5 V from 40 s to 80 s of 100 s,
# 40000 samples, move an integrator by exactly 0 by RK45, LSODA and BDF. Linear systems go the same way there; `forced_response`
# has 200 V s. A `max_step` of a sample reads all of it.
. "$(dirname "$0")/common.sh"
pinned control==0.10.2 scipy==1.17.1 numpy==2.3.5
python - <<'PROGRAM'
import control as ct
import numpy as np

piston = ct.ss([[0.0]], [[1.0]], [[1.0]], [[0.0]], name="integrator")
lag = ct.ss([[-20.0, 0], [1, 0]], [[20.0], [0]], [[0, 1.0]], [[0]], name="valve and integrator")


def reached(system, start, end, of, **options):
    """The last output after 5 V from start to end, with samples of 1 ms."""
    times = np.linspace(0, of, round(of * 1000) + 1)
    command = np.where((times >= start) & (times <= end), 5.0, 0.0)
    if options.pop("linear", False):
        return ct.forced_response(system, times, command).outputs[-1]
    return ct.input_output_response(system, times, command, **options).outputs[-1]


def show(text, seen, expected, tolerance):
    print(f"{text:42} {seen:.3f}")
    assert abs(seen - expected) <= tolerance, text


for system in (piston, lag):
    show(f"{system.name}: 40 s of 100 s", reached(system, 40, 80, 100), 0, 0)
    show(f"{system.name}: forced_response", reached(system, 40, 80, 100, linear=True), 200, 0.1)
show("50 ms of 1 s", reached(piston, 0.73, 0.78, 1), 0, 0)
for method in ("LSODA", "BDF"):
    show(f"40 s of 100 s, {method}", reached(piston, 40, 80, 100, solve_ivp_method=method), 0, 0)
show("50 ms of 1 s, max_step of 1 ms", reached(piston, 0.73, 0.78, 1, solve_ivp_kwargs={"max_step": 1e-3}), 0.255, 0.002)
PROGRAM
