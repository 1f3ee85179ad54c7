#!/usr/bin/env bash
# FMPy 0.3.19 and 0.3.20 refuse FMI 3.0 FMUs with a description in a type definition, which the standard allows (TypeError of their
# parser); 0.3.32 reads them. It matters since other packages pin the old ones: gemseo-fmu 3.1.1 asks for at most 0.3.19.
. "$(dirname "$0")/common.sh"
probe 3 plain.fmu
probe 3 described.fmu 's/<EnumerationType name="Mode">/<EnumerationType name="Mode" description="How fast it integrates">/'
probe 2 described2.fmu 's/<SimpleType name="Mode">/<SimpleType name="Mode" description="How fast it integrates">/'
for version in 0.3.19 0.3.20 0.3.32; do
    pinned fmpy==$version
    python - <<'PROGRAM'
import fmpy

fmpy.read_model_description("plain.fmu")
fmpy.read_model_description("described2.fmu")
try:
    fmpy.read_model_description("described.fmu")
    answer = "read"
except TypeError as error:
    answer = f"TypeError: {error}"
print(fmpy.__version__, answer)
assert ("unexpected keyword argument 'description'" in answer) == (fmpy.__version__ != "0.3.32"), answer
PROGRAM
done
