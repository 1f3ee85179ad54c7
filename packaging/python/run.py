"""What an experiment gave, with its units."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from fmpy.model_description import ModelDescription

EXPERIMENTS = json.loads((Path(__file__).parents[2] / "modelDescription" / "experiments.json").read_text("utf-8"))
"""The default experiment of every model, as the plant states it."""


@dataclass(frozen=True)
class Units:
    """In which unit each variable is shown."""

    scales: dict[str, tuple[str, float, float]]
    """Unit, factor and offset by variable."""

    @staticmethod
    def of(description: ModelDescription) -> Units:
        """The display unit of each variable where it has one, else its unit."""
        displays = {
            (unit.name, display.name): display for unit in description.unitDefinitions for display in unit.displayUnits
        }
        scales = {}
        for variable in description.modelVariables:
            display = displays.get((variable.unit, variable.displayUnit))
            if display is None:
                scales[variable.name] = (variable.unit or "", 1.0, 0.0)
            else:
                scales[variable.name] = (display.name, float(display.factor), float(display.offset))
        return Units(scales)

    def label(self, text: str, variable: str) -> str:
        return f"{text} ({self.scales[variable][0]})"

    def shown(self, run: Run, variable: str) -> np.ndarray:
        _, factor, offset = self.scales[variable]
        return run.columns[variable] * factor + offset


@dataclass
class Run:
    """What an experiment gave: one column per variable, one row per communication point."""

    model: str
    law: str
    columns: dict[str, np.ndarray]
    units: Units

    @property
    def name(self) -> str:
        return f"{self.model}_{self.law}" if self.law else self.model
