#!/usr/bin/env bash
# SSP 2.0 keeps the namespaces of SSP 1.0 (.../SSP1/...); the attribute `version` alone tells them apart. FMPy 0.3.32 and ecospy 0.7.2
# refuse a system of version 2.0, pyssp-standard 0.9.1 reads it. ecospy takes FMUs for FMI 3.0, which SSP 1.0 does not know, from a
# system of version 1.0; FMPy takes each FMU for one of FMI 2.0. It needs the Debian package libtbb12.
. "$(dirname "$0")/common.sh"
pinned fmpy==0.3.32 ecospy==0.7.2 pyssp-standard==0.9.1
probe 3 probe.fmu
cat >write.py <<'PROGRAM'
import os
import zipfile

SSD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
    xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" version="{version}" name="One">
  <ssd:System name="One">
    <ssd:Elements>
      <ssd:Component name="plant" type="application/x-fmu-sharedlibrary" source="resources/probe.fmu"
          implementation="CoSimulation">
        <ssd:Connectors><ssd:Connector name="x" kind="output"><ssc:{real}/></ssd:Connector></ssd:Connectors>
      </ssd:Component>
    </ssd:Elements>
  </ssd:System>
</ssd:SystemStructureDescription>
"""
for version, real in (("1.0", "Real"), ("2.0", "Float64")):
    text = SSD.format(version=version, real=real)
    with zipfile.ZipFile(f"{version}.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", text)
        archive.write("probe.fmu", "resources/probe.fmu")
    zipfile.ZipFile(f"{version}.ssp").extractall(version)
PROGRAM
python write.py
cat >try.py <<'PROGRAM'
import sys

tool, version = sys.argv[1:]
if tool == "pyssp":
    from pyssp_standard.ssp import SSP

    with SSP(f"{version}.ssp", mode="r") as archive, archive.variants["SystemStructure"] as system:
        system.__check_compliance__()
        print("read", system.version)
elif tool == "ecos":
    from ecospy import EcosSimulation

    with EcosSimulation(ssp_path=version, step_size=0.1) as simulation:
        simulation.init()
        simulation.step(10)
        print(f"x = {simulation.get_real('plant::x'):.6g}")
else:
    from fmpy.ssp.simulation import simulate_ssp

    result = simulate_ssp(f"{version}.ssp", stop_time=1.0, step_size=0.1)
    print(result.dtype.names)
PROGRAM
expect() { # expect <tool> <version> <extended regular expression>
    python try.py "$1" "$2" >out 2>&1 || true
    echo "$1, SSP $2: $(grep -m1 -oE "$3" out || tail -1 out)"
    grep -qE "$3" out || { cat out; exit 1; }
}
expect pyssp 2.0 "read 2\.0"
expect ecos 2.0 "Unsupported SSP version: '2\.0'"
expect ecos 1.0 "x = [0-9.]+"
expect fmpy 2.0 "The value '2\.0' is not accepted by the pattern"
expect fmpy 1.0 "fmi2[A-Za-z]*"
