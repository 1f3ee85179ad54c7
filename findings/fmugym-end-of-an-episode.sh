#!/usr/bin/env bash
# fmugym 0.2.0 looks for the end of an episode before it steps, and resets the FMU itself then: the step that reports `terminated` returns
# the first observation of the next episode. A loop that calls reset() after it, as Gymnasium asks for, simulates one action for nothing.
. "$(dirname "$0")/common.sh"
pinned fmugym==0.2.0 fmpy==0.3.32
probe 2 probe.fmu
python - <<'PROGRAM'
import numpy as np
from fmugym.fmugym import FMUGym
from fmugym.fmugym_config import FMUGymConfig, VarSpace


class Environment(FMUGym):
    def _noisy_init(self):
        return {}

    def compute_reward(self, *arguments):
        return 0.0


inputs, outputs, none = VarSpace("inputs"), VarSpace("outputs"), VarSpace("none")
inputs.add_var_box("u", -10.0, 10.0)
outputs.add_var_box("x", -100.0, 100.0)
env = Environment(FMUGymConfig(
    fmu_path="probe.fmu", start_time=0.0, stop_time=0.45, sim_step_size=0.125, action_step_size=0.125,
    inputs=inputs, outputs=outputs, random_vars=none, input_noise=none, output_noise=none,
))
env.reset(seed=1)
found = []
for _ in range(5):
    observation, _, terminated, _, _ = env.step(np.array([8.0]))
    found.append((float(observation[0]), bool(terminated)))
print(found)
assert found == [(1.0, False), (2.0, False), (3.0, False), (4.0, False), (1.0, True)]
PROGRAM
