#!/usr/bin/env bash
# cloudpickle 3.1.2 gives each function a cell of its own: two nested functions that share a `nonlocal` variable no longer share it in a
# copy. A controller of closures then runs without an error, and with another result, in processes that get it so.
. "$(dirname "$0")/common.sh"
pinned cloudpickle==3.1.2
cat >run.py <<'PROGRAM'
import pickle

import cloudpickle


def integrator():
    total = 0.0

    def add(error):
        nonlocal total
        total += error

    def law(error):
        add(error)
        return total

    return law


law = integrator()
copy = pickle.loads(cloudpickle.dumps(integrator()))
print([law(1.0), law(1.0)], [copy(1.0), copy(1.0)])
PROGRAM
python run.py | tee out
grep -qxF '[1.0, 2.0] [0.0, 0.0]' out
