// What the documentation page of an FMU says about a fit.

import { css } from "../charts";
import { element } from "../dom";
import { drawing } from "../svg";
import { lawName } from "../tables";
import { curves, estimateTable, residualTable, verdictLines } from "./result-card";
import type { FitContext, Found } from "./study";

/** Pixels between the points of a line: an FMU is to grow by little. */
const NEAR = 2;

/** A section of HTML, as the Python package writes it: record, date, verdict, values with intervals, residuals, curves. */
export function fitSection(context: FitContext, found: Found): string {
  const { question, answer } = found;
  const today = new Date().toISOString().slice(0, 10);
  const charts = curves(found).filter(({ look }) => look.lines.length > 1);
  const pictures = charts.map((chart) => {
    const picture = drawing([chart], (name) => css(name, "light"), NEAR);
    return element("img", { alt: chart.look.title, src: `data:image/svg+xml;charset=utf-8,${encodeURIComponent(picture)}` });
  });
  const section = element(
    "section",
    { id: "fit" },
    element("h2", {}, "Fit to measured data"),
    element("p", {}, `Law ${lawName(context.library.tables, question.law)}, data ${question.file}, exported ${today}.`),
    ...verdictLines(answer),
    estimateTable(context, answer),
    residualTable(answer),
    ...(answer.unitsTold === null ? [] : [element("p", {}, `Units are those ${answer.unitsTold}.`)]),
    ...pictures,
  );
  return `${section.outerHTML}\n`;
}
