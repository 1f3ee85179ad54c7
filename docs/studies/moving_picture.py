"""Draws the default experiment as a moving picture for the README: the carriage, its friction, and when it sticks.

python docs/studies/moving_picture.py docs/images/stick_slip.svg
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pneumatic_servo as ps

STOP = 3.0
"""In s, of the plant's time."""

SLOWER = 3
"""Factor by which the picture is slower than the plant."""

EVERY = 8
"""In ms, from one frame to the next; what is drawn in between lies on straight lines."""

STROKE = 0.5
"""In m."""

WIDTH, HEIGHT = 860, 372
LEFT, RIGHT, TOP, BOTTOM = 30, 430, 62, 132
"""The inside of the barrel."""

ROD = 215
"""From the piston to the carriage."""

PLOT = (70, 830, 216, 332)
"""Left, right, top and bottom of the curve."""

NEWTON = 4.5
"""Length of the arrow for 1 N."""

STYLE = """
text { font: 15px system-ui, "DejaVu Sans", sans-serif; fill: #1d2733 }
.small { font-size: 13px; fill: #4b5866 }
.stuck { font-weight: 700; font-size: 13px; fill: #b3261e; text-anchor: middle }
.line { fill: none; stroke: #5b6875; stroke-width: 3 }
.steel { fill: #8a97a4 }
.curve { fill: none; stroke: #0b62a4; stroke-width: 2 }
.rest { fill: #b3261e; opacity: 0.13 }
.axis { stroke: #d5dce3; stroke-width: 1 }
"""

Row = np.ndarray


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, help="the SVG to write")
    arguments = parser.parse_args()
    arguments.file.write_text(picture(run()), encoding="utf-8")
    return 0


def run() -> ps.Run:
    """The default experiment: 1 Hz, 5 V and 2 V to either side, at the default supply."""
    t = np.arange(0.0, STOP, 1e-3)
    voltage = 5.0 + 2.0 * np.sin(2.0 * np.pi * t)
    outputs = ["position", "velocity", "frictionForce", "chamberA.pressure", "chamberB.pressure", "sticking"]
    plant = ps.Model("PneumaticServoCylinder")
    return plant.simulate(
        {"friction.law": "Stribeck"}, inputs={"valveVoltage": (t, voltage)}, stop=STOP, outputs=outputs
    )


def picture(recorded: ps.Run) -> str:
    """The picture as SVG, animated by itself: no script, no style of the page around."""
    frames = slice(None, None, EVERY)
    piston = LEFT + 16 + (RIGHT - LEFT - 32) * recorded["position"][frames] / STROKE
    sticking = recorded["sticking"] > 0.5
    time = recorded.time
    across = PLOT[0] + (PLOT[1] - PLOT[0]) * time / STOP
    position = recorded["position"]
    low, high = 0.05 * np.floor(20 * position.min()), 0.05 * np.ceil(20 * position.max())
    up = PLOT[3] - (PLOT[3] - PLOT[2]) * (position - low) / (high - low)
    pressures = [recorded[f"chamber{name}.pressure"][frames] for name in "AB"]
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        'aria-label="The carriage of the cylinder moves back and forth, and sticks at each reversal">',
        f"<style>{STYLE}</style>",
        f'<rect width="{WIDTH}" height="{HEIGHT}" rx="12" fill="#fff"/>',
        f'<text x="{LEFT}" y="34">Law Stribeck, 5 ± 2 V at 1 Hz, {SLOWER} times slower than the plant</text>',
        rectangle(LEFT, piston - LEFT, pressures[0]),
        moving_rectangle(piston, RIGHT - piston, pressures[1]),
        f'<path class="line" d="M{LEFT} {TOP}H{RIGHT}V86M{RIGHT} 108V{BOTTOM}H{LEFT}V{TOP}"/>',
        f'<text x="{LEFT + 8}" y="{TOP + 20}">A</text><text x="{RIGHT - 18}" y="{TOP + 20}">B</text>',
        f'<path class="line" d="M{RIGHT + 26} 142H{WIDTH - 30}"/>',
        "<g>" + moves("transform", piston, "animateTransform", lambda x: f"{x:.1f} 0"),
        f'<rect class="steel" x="-9" y="{TOP}" width="18" height="{BOTTOM - TOP}" rx="2"/>',
        f'<rect class="steel" y="92" width="{ROD}" height="11"/>',
        f'<rect x="{ROD}" y="62" width="88" height="76" rx="7" fill="#dfe6ec" stroke="#5b6875" stroke-width="2">'
        + switches("stroke", sticking[frames], "#b3261e", "#5b6875")
        + "</rect>",
        f'<text class="stuck" x="{ROD + 44}" y="105">STUCK'
        + switches("opacity", sticking[frames], "1", "0")
        + "</text>",
        arrow(ROD + 44, recorded["frictionForce"][frames]),
        "</g>",
        *plot(across, up, sticking, low, high),
        '<circle r="6" fill="#c2540a">' + moves("cx", across[frames]) + moves("cy", up[frames]) + "</circle>",
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def rectangle(left: float, width: Row, pressure: Row) -> str:
    """A chamber that ends at the piston."""
    box = f'<rect x="{left}" y="{TOP}" height="{BOTTOM - TOP}">'
    return box + moves("width", width) + moves("fill", pressure, show=colour) + "</rect>"


def moving_rectangle(left: Row, width: Row, pressure: Row) -> str:
    """A chamber that begins at the piston."""
    box = f'<rect y="{TOP}" height="{BOTTOM - TOP}">'
    return box + moves("x", left) + moves("width", width) + moves("fill", pressure, show=colour) + "</rect>"


def arrow(middle: float, force: Row) -> str:
    """The friction force on the carriage, which points against the motion that it opposes."""
    tip = middle - NEWTON * force
    line = f'<line x1="{middle}" x2="{middle}" y1="50" y2="50" stroke="#0f7b5f" stroke-width="5">' + moves("x2", tip)
    head = "<path fill='#0f7b5f' d='M0 41L{0} 50L0 59Z'>"
    sides = "".join(
        head.format(13 * side)
        + moves("transform", tip, "animateTransform", lambda x: f"{x:.1f} 0")
        + switches("opacity", -side * force > 0.5, "1", "0")
        + "</path>"
        for side in (-1, 1)
    )
    return line + "</line>" + sides


def plot(across: Row, up: Row, sticking: Row, low: float, high: float) -> Iterable[str]:
    """Position over time, with the rests shaded."""
    left, right, top, bottom = PLOT
    yield f'<text class="small" x="{left}" y="{top - 14}">position in mm; shaded: the carriage is stuck</text>'
    for share, value in ((0.0, low), (0.5, (low + high) / 2), (1.0, high)):
        height = bottom - share * (bottom - top)
        yield f'<path class="axis" d="M{left} {height:g}H{right}"/>'
        yield f'<text class="small" x="{left - 8}" y="{height + 5:g}" text-anchor="end">{1e3 * value:.0f}</text>'
    for second in range(int(STOP) + 1):
        place = left + (right - left) * second / STOP
        yield f'<text class="small" x="{place:.0f}" y="{bottom + 22}" text-anchor="middle">{second} s</text>'
    edges = np.flatnonzero(np.diff(np.concatenate([[0], sticking.astype(int), [0]])))
    for begin, end in edges.reshape(-1, 2):
        x, width = across[begin], across[end - 1] - across[begin]
        yield f'<rect class="rest" x="{x:.1f}" y="{top}" width="{width:.1f}" height="{bottom - top}"/>'
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across[::4], up[::4], strict=True))
    yield f'<polyline class="curve" points="{points}"/>'


def colour(pressure: float) -> str:
    """From the colour of ambient air to the colour of full supply."""
    full = min(max((pressure - 101_325) / 500_000, 0.0), 1.0)
    shades = [
        round(empty + full * (filled - empty)) for empty, filled in zip((238, 243, 247), (47, 134, 198), strict=True)
    ]
    return "#" + "".join(f"{shade:02x}" for shade in shades)


def moves(name: str, values: Row, kind: str = "animate", show: Callable[[float], str] = "{:.1f}".format) -> str:
    """An attribute that follows values, from frame to frame along straight lines."""
    listed = ";".join(show(float(value)) for value in values)
    what = ' type="translate"' if kind == "animateTransform" else ""
    return f'<{kind} attributeName="{name}"{what} dur="{SLOWER * STOP:g}s" repeatCount="indefinite" values="{listed}"/>'


def switches(name: str, is_on: Row, on: str, off: str) -> str:
    """An attribute with one of two values, listed where it changes."""
    changes = [0, *(np.flatnonzero(np.diff(is_on.astype(int))) + 1)]
    values = ";".join(on if is_on[index] else off for index in changes)
    times = ";".join(f"{index / (len(is_on) - 1):.4g}" for index in changes)
    if len(changes) == 1:
        return f'<set attributeName="{name}" to="{values}"/>'
    timing = f'dur="{SLOWER * STOP:g}s" repeatCount="indefinite" calcMode="discrete" keyTimes="{times}"'
    return f'<animate attributeName="{name}" {timing} values="{values}"/>'


if __name__ == "__main__":
    sys.exit(main())
