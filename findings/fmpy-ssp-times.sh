#!/usr/bin/env bash
# FMPy 0.3.32, simulate_ssp: the row of a time has the outputs of one step later, and the row of the stop time is missing. During the
# first step every connected input is 0, not the start value of its source: nothing is passed on before or during initialization.
. "$(dirname "$0")/common.sh"
pinned fmpy==0.3.32 numpy==2.3.5
probe 2 probe.fmu
cat >SystemStructure.ssd <<'XML'
<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="1.0" name="Two">
  <ssd:System name="Two">
    <ssd:Connectors><ssd:Connector name="x" kind="output"><ssc:Real/></ssd:Connector></ssd:Connectors>
    <ssd:Elements>
      <ssd:Component name="first" type="application/x-fmu-sharedlibrary" source="resources/probe.fmu">
        <ssd:Connectors>
          <ssd:Connector name="u" kind="output"><ssc:Real/></ssd:Connector>
          <ssd:Connector name="x" kind="output"><ssc:Real/></ssd:Connector>
        </ssd:Connectors>
      </ssd:Component>
      <ssd:Component name="second" type="application/x-fmu-sharedlibrary" source="resources/probe.fmu">
        <ssd:Connectors>
          <ssd:Connector name="u" kind="input"><ssc:Real/></ssd:Connector>
          <ssd:Connector name="x" kind="output"><ssc:Real/></ssd:Connector>
        </ssd:Connectors>
      </ssd:Component>
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startElement="first" startConnector="u" endElement="second" endConnector="u"/>
      <ssd:Connection startElement="second" startConnector="x" endConnector="x"/>
    </ssd:Connections>
  </ssd:System>
</ssd:SystemStructureDescription>
XML
mkdir resources && cp probe.fmu resources && python3 -m zipfile -c two.ssp SystemStructure.ssd resources
python - <<'PROGRAM'
import os
from pathlib import Path

import numpy as np
from fmpy.ssp.simulation import simulate_ssp

rows = simulate_ssp("two.ssp", stop_time=0.3, step_size=0.1)
for name in rows.dtype.names:
    print(f"{name:9}", rows[name])
given = [line for line in Path(os.environ["PROBE_CALLS"]).read_text().splitlines() if line.startswith("second: set real 1 ")]
print(given)
assert np.allclose(rows["time"], [0, 0.1, 0.2])
# der(x) = u with u = 5: x is 0, 0.5, 1, 1.5 at 0, 0.1, 0.2, 0.3 s.
assert np.allclose(rows["first.x"], [0.5, 1, 1.5])
# The second integrator is at rest for a step, then the same.
assert np.allclose(rows["second.x"], [0, 0.5, 1]) and np.allclose(rows["x"], [0, 0.5, 1])
assert given == ["second: set real 1 0", "second: set real 1 5", "second: set real 1 5"]
PROGRAM
