"""Check lists of contents against the schema of CycloneDX, and that each names the plant and all licences.

Usage: python sbom.py FILE...
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator


def problems(text: str) -> list[str]:
    """Return what is wrong with a list of contents."""
    error = JsonStrictValidator(SchemaVersion.V1_5).validate_str(text)
    if error is not None:
        return [f"it is not CycloneDX 1.5: {error}"]
    content = json.loads(text)
    parts = [content["metadata"]["component"], *content.get("components", [])]
    found = [f"{part['name']} has no licence" for part in parts if not part.get("licenses")]
    if not any(part["name"] == "pneumatic-servo" for part in parts):
        found.append("the plant is not in it")
    if "file:///" in text:
        found.append("it tells where it was made")
    return found


def main(files: list[Path]) -> int:
    """Check files, and tell how many parts each has."""
    failed = False
    for file in files:
        text = file.read_text(encoding="utf-8")
        for problem in problems(text):
            failed = True
            print(f"{file}: {problem}", file=sys.stderr)
        print(f"{file.name}: {len(json.loads(text).get('components', []))} parts")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main([Path(name) for name in sys.argv[1:]]))
