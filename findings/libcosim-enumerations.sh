#!/usr/bin/env bash
# libcosimpy 0.0.6 knows no enumerations: setting one by its value reference as an integer answers False, without an exception, and the run
# goes on with the default. FMI 2.0 alone.
. "$(dirname "$0")/common.sh"
pinned libcosimpy==0.0.6
probe 2 two.fmu
python - <<'PROGRAM' 2>log || { cat log; exit 1; }
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

for reference, accepted, expected in ((6, False, 5.0), (7, True, 10.0)):
    execution = CosimExecution.from_step_size(step_size=100_000_000)
    plant = execution.add_local_slave(CosimLocalSlave(fmu_path="two.fmu", instance_name="plant"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    answer = execution.integer_initial_value(plant, reference, 3)
    for _ in range(10):
        execution.step()
    x = observer.last_real_values(plant, [2])[0]
    print("value reference", reference, "accepted:", answer, "x =", x)
    assert answer is accepted and abs(x - expected) < 1e-9
PROGRAM
