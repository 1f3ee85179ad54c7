"""The picture of a plant in its environment: cylinder, pressures, target.

Matplotlib takes as long to import as all the rest, so only those who draw import it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Frame = NDArray[np.uint8]

INCHES, DOTS = (6.4, 1.8), 100
"""Size of a frame in inches, and dots per inch: 640 by 180 pixels."""
BARREL, PISTON = 0.5, 0.04
"""Height of the barrel and width of the piston, in units of the stroke and of the figure."""
FULL = 10e5
"""Pressure in Pa at which a chamber is drawn in full colour."""
AIR = "#1f77b4"


class Drawing:
    """A drawing that is moved, not made anew, from frame to frame.

    Parameters
    ----------
    figure : matplotlib.figure.Figure, optional
        The canvas, of a window; by default one without a window.
    """

    def __init__(self, figure: Any = None) -> None:
        from matplotlib.figure import Figure
        from matplotlib.patches import Rectangle

        self.figure: Any = Figure() if figure is None else figure
        self.figure.set_size_inches(*INCHES)
        self.figure.set_dpi(DOTS)
        axes: Any = self.figure.add_axes((0.02, 0.05, 0.96, 0.8))
        axes.set_xlim(-0.15, 2.3)
        axes.set_ylim(-0.5, 0.5)
        axes.set_axis_off()
        axes.add_patch(Rectangle((-PISTON, -BARREL / 2), 1.0 + 2 * PISTON, BARREL, fill=False, lw=2, ec="#333333"))
        self._a = axes.add_patch(Rectangle((-PISTON, -BARREL / 2), 0.1, BARREL, color=AIR, lw=0))
        self._b = axes.add_patch(Rectangle((0.0, -BARREL / 2), 1.0, BARREL, color=AIR, lw=0))
        self._rod = axes.add_patch(Rectangle((0.0, -0.04), 1.1, 0.08, color="#888888"))
        self._piston = axes.add_patch(Rectangle((0.0, -BARREL / 2), PISTON, BARREL, color="#333333"))
        self._load = axes.add_patch(Rectangle((1.0, -0.18), 0.12, 0.36, color="#555555"))
        [self._target] = axes.plot([0.0, 0.0], [-0.42, 0.42], color="#d62728", lw=2)
        self._title = self.figure.text(0.02, 0.88, "", family="monospace", size=9)

    def show(self, stroke: float, seen: NDArray[np.float64], target: float, law: str) -> None:
        """Move everything to where a plant is: position in m, velocity in m/s and both pressures in Pa are seen."""
        place, _, *pressures = (float(value) for value in seen)
        at = place / stroke
        self._a.set_width(max(at, 0.0) + PISTON / 2)
        self._b.set_x(at + PISTON / 2)
        self._b.set_width(max(1.0 + PISTON / 2 - at, 0.0))
        for chamber, pressure in zip((self._a, self._b), pressures, strict=True):
            chamber.set_alpha(min(max(pressure / FULL, 0.0), 1.0))
        self._piston.set_x(at - PISTON / 2)
        self._rod.set_x(at)
        self._load.set_x(at + 1.1)
        self._target.set_xdata([target / stroke + 1.1, target / stroke + 1.1])
        a, b = (1e-5 * pressure for pressure in pressures)
        self._title.set_text(
            f"{law}  position {1e3 * place:6.1f} mm, target {1e3 * target:6.1f} mm, A {a:4.2f} bar, B {b:4.2f} bar"
        )

    def frame(self) -> Frame:
        """Return the picture of shape (height, width, 3)."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        canvas: Any = FigureCanvasAgg(self.figure)
        canvas.draw()
        return np.asarray(canvas.buffer_rgba(), dtype=np.uint8)[..., :3].copy()


class Window:
    """A window that shows a drawing."""

    def __init__(self) -> None:
        import matplotlib.pyplot as plt

        self._figure: Any = plt.figure("pneumatic_servo/Positioning-v0")
        self.drawing = Drawing(self._figure)
        self._figure.show()

    def update(self) -> None:
        """Draw the moved parts."""
        self._figure.canvas.draw_idle()
        self._figure.canvas.flush_events()

    def close(self) -> None:
        """Close it."""
        import matplotlib.pyplot as plt

        plt.close(self._figure)
