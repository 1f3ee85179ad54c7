"""Validates an FMU with FMPy; any finding is an error."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from fmpy.validation import validate_fmu


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fmu", type=Path)
    fmu: Path = parser.parse_args().fmu
    findings = validate_fmu(str(fmu))
    for finding in findings:
        print(f"{fmu.name}: {finding}", file=sys.stderr)
    print(f"{fmu.name}: {len(findings)} findings")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
