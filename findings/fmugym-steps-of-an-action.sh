#!/usr/bin/env bash
# fmugym 0.2.0 adds up its time in floating point and compares with `<`: an action of 0.3 s with steps of 0.1 s takes three steps, then
# four and four; one of 0.1 s with steps of 0.01 s eleven the first time. 1 ms in 10 ms comes out even over the first 15 actions.
. "$(dirname "$0")/common.sh"
pinned fmugym==0.2.0 fmpy==0.3.32
probe 2 probe.fmu
cat >environment.py <<'PROGRAM'
import numpy as np
from fmugym.fmugym import FMUGym
from fmugym.fmugym_config import FMUGymConfig, VarSpace


class Environment(FMUGym):
    def _noisy_init(self):
        return {}

    def compute_reward(self, *arguments):
        return 0.0


def environment(step, action, stop=100.0):
    inputs, outputs, none = VarSpace("inputs"), VarSpace("outputs"), VarSpace("none")
    inputs.add_var_box("u", -10.0, 10.0)
    outputs.add_var_box("x", -100.0, 100.0)
    return Environment(FMUGymConfig(
        fmu_path="probe.fmu", start_time=0.0, stop_time=stop, sim_step_size=step, action_step_size=action,
        inputs=inputs, outputs=outputs, random_vars=none, input_noise=none, output_noise=none,
    ))
PROGRAM
python - <<'PROGRAM'
import numpy as np
from environment import environment

for step, action, expected in ((0.1, 0.3, [3, 4, 4]), (0.01, 0.1, [11, 10, 10]), (0.001, 0.01, [10] * 15)):
    env = environment(step, action)
    env.reset(seed=1)
    found = []
    for _ in expected:
        open("calls", "w").close()
        env.step(np.array([1.0]))
        found.append(open("calls").read().count("step from"))
    print("action of", action, "s, steps of", step, "s:", found)
    assert found == expected
PROGRAM
