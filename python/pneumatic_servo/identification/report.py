"""A fit as a page: tables, figures, and the treatment of the data, in one file."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from datetime import datetime, timezone
from html import escape
from io import BytesIO

from matplotlib.figure import Figure
from PIL import Image

from pneumatic_servo.identification.figures import against, friction_map, overlay, worst_misfit
from pneumatic_servo.identification.fitted import Fitted
from pneumatic_servo.identification.free_form import FreeForm
from pneumatic_servo.identification.regimes import regimes
from pneumatic_servo.identification.residuals import Residuals
from pneumatic_servo.identification.verdict import Verdict

STYLE = """body{font:15px/1.5 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#1d2733}
table{border-collapse:collapse;margin:.5em 0}td,th{padding:.2em .8em;border-bottom:1px solid #e3e7eb;text-align:right}
td:first-child,th:first-child{text-align:left}img{max-width:100%}.warning{color:#a33b00}
.green,.yellow,.red{border-left:.5em solid;padding-left:.8em}
.green{border-color:#2e8540}.yellow{border-color:#e0a100}.red{border-color:#b3261e}"""


def page(fit: Fitted, residuals: Residuals, verdict: Verdict, free_form: FreeForm | None) -> str:
    """Return the page."""
    search = "The fit has converged." if fit.converged else "<b class=warning>The fit has not converged.</b>"
    names = [free.name for free in fit.problem.free]
    correlation = fit.certainty.correlation
    friction, worst = friction_map(fit), worst_misfit(residuals)
    parts = [
        f"<h1>{escape(fit.law)}: fit to measured data</h1><p>{search} {escape(fit.message)}</p>",
        f"<p>Units are those {escape(fit.units.told)}.</p>" if fit.units.is_rotating else "",
        f"<p class={verdict.light}><b>{verdict.light.capitalize()}.</b> {escape(verdict.text)}</p>",
        "<h2>Parameters, with 95 % intervals</h2>",
        _table(
            ["parameter", "value", "low", "high", "unit"],
            ([n, f"{e.value:.6g}", f"{e.low:.6g}", f"{e.high:.6g}", e.unit] for n, e in fit.parameters.items()),
        ),
        *(f"<p class=warning>{escape(n)} is not identifiable: {escape(why)}.</p>"
          for n, why in fit.not_identifiable.items()),
        "<h2>What remains</h2>",
        _table(
            ["signal", "rms", "validation rms", "unit", "white"],
            (
                [s, f"{rms:.6g}", f"{fit.validation_rms[s]:.6g}" if s in fit.validation_rms else "", residuals.unit(s),
                 "yes" if residuals.is_white(s) else "no"]
                for s, rms in fit.rms.items()
            ),
        ),
        _table(
            ["by kind of motion", "signal", "samples", "rms", "unit", "white"],
            (
                [one.name, s, str(one.samples), f"{one.rms:.6g}", residuals.unit(s), "yes" if one.is_white else "no"]
                for s in fit.rms
                for one in regimes(residuals, s)
            ),
        ),
        _image(overlay(residuals), "measured and fitted signals"),
        "<h2>Largest residual</h2>" + _image(worst, "measured and fitted at the worst misfit") if worst else "",
        _image(against(residuals), "what remains against velocity, position and lag"),
        "<h2>Friction against velocity</h2>" + _image(friction, "friction against velocity") if friction else "",
        *_free_form(free_form),
        *_conditions(fit),
        "<h2>Correlations of the errors</h2>",
        _table(["", *names], ([n, *(f"{c:.2f}" for c in row)] for n, row in zip(names, correlation, strict=True))),
        "<h2>What was done to the data</h2>",
        "<ul>" + "".join(f"<li>{escape(note)}</li>" for note in fit.notes or ["Nothing."]) + "</ul>",
    ]  # fmt: skip
    head = f"<!doctype html><meta charset=utf-8><title>{escape(fit.law)}</title><style>{STYLE}</style>"
    return head + "\n".join(parts) + "\n"


def sections(fit: Fitted, residuals: Residuals, verdict: Verdict) -> str:
    """Return what the documentation page of an FMU says about the fit: a section of HTML."""
    friction = friction_map(fit)
    records = ", ".join(dict.fromkeys(window.record.name for window in fit.problem.windows))
    parts = [
        '<section id="fit">\n<h2>Fit to measured data</h2>',
        f"<p>Law {escape(fit.law)}, data {escape(records)}, exported {datetime.now(timezone.utc):%Y-%m-%d}.</p>",
        f"<p><b>{verdict.light.capitalize()}.</b> {escape(verdict.text)}</p>",
        _table(
            ["parameter", "value", "low", "high", "unit"],
            ([n, f"{e.value:.6g}", f"{e.low:.6g}", f"{e.high:.6g}", e.unit] for n, e in fit.parameters.items()),
        ),
        _table(
            ["signal", "rms", "validation rms", "unit"],
            (
                [s, f"{rms:.6g}", f"{fit.validation_rms[s]:.6g}" if s in fit.validation_rms else "", residuals.unit(s)]
                for s, rms in fit.rms.items()
            ),
        ),
        _small(overlay(residuals), "measured and fitted signals"),
        _small(friction, "friction against velocity") if friction else "",
        "</section>\n",
    ]
    return "\n".join(parts)


SMALL = 45
"""Resolution of figures inside an FMU, in dots per inch."""

COLOURS = 12
"""Colours of them: an FMU is to grow by little."""


def _free_form(found: FreeForm | None) -> list[str]:
    if found is None:
        return []
    rows = [["the law", f"{found.law:.4g}", ""]]
    rows += [[f"a free curve over {n}", f"{rms:.4g}", f"{found.gain(n):.0%}"] for n, rms in found.curves.items()]
    return [
        "<h2>What any law could still gain</h2>",
        _table(["friction in motion", f"rms ({found.unit})", "share of the law's residual that it removes"], rows),
    ]


def _conditions(fit: Fitted) -> list[str]:
    found = fit.cross_validation
    if found is None:
        return []
    beyond = [f"{case.condition.name}: {text}" for case in found.cases for text in case.beyond]
    return [
        "<h2>Each condition predicted by the others</h2>",
        _table(found.columns, found.texts()),
        *(f"<p>An extrapolation. {escape(text)}.</p>" for text in beyond),
        _image(found.plot(), "friction of each condition, predicted and measured"),
    ]


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    first = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    others = ("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{first}</tr>{''.join(others)}</table>"


def _small(figure: Figure, text: str) -> str:
    large, stream = BytesIO(), BytesIO()
    figure.savefig(large, format="png", dpi=SMALL, metadata={"Software": None})
    Image.open(large).convert("RGB").quantize(COLOURS).save(stream, format="png", optimize=True)
    return _embedded(stream, text)


def _image(figure: Figure, text: str) -> str:
    stream = BytesIO()
    figure.savefig(stream, format="png", metadata={"Software": None})
    return _embedded(stream, text)


def _embedded(stream: BytesIO, text: str) -> str:
    return f'<p><img alt="{escape(text)}" src="data:image/png;base64,{b64encode(stream.getvalue()).decode()}"></p>'
