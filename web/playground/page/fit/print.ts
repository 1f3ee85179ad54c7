// A report of a fit on one page, to print.

import { css } from "../charts";
import { element } from "../dom";
import { drawing } from "../svg";
import { lawName, model, short } from "../tables";
import { curves, estimateTable, noted, residualTable, verdictLines } from "./result-card";
import type { FitContext, Found } from "./study";

/** Prints a page with the verdict, the values, what was known, and the curves. */
export function printReport(context: FitContext, found: Found): void {
  const made = report(context, found);
  document.body.append(made);
  addEventListener("afterprint", () => made.remove(), { once: true });
  print();
}

function report(context: FitContext, found: Found): HTMLElement {
  const { question, answer } = found;
  const { library, study } = context;
  const { tables } = library;
  const of = model(tables, study.modelName);
  const known = [...question.known].filter(([name]) => !question.free.includes(name));
  const given = known.map(([name, value]) => {
    const unit = found.units[name] ?? of.variables.find((entry) => entry.name === name)?.of ?? "1";
    return `${name} = ${short(value, 6)}${unit === "1" ? "" : ` ${unit}`}`;
  });
  const charts = curves(found);
  const figure = element("div", { class: "figures" });
  // One below the other, the signals on the left and their residuals on the right.
  for (const chart of charts) {
    const picture = element("img", { alt: chart.look.title });
    picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(drawing([chart], (name) => css(name, "light")))}`;
    figure.append(picture);
  }
  return element(
    "section",
    { class: "report", "aria-label": "Report" },
    element("h1", {}, `${lawName(tables, question.law)} fitted to ${question.file}`),
    ...verdictLines(answer),
    estimateTable(context, answer),
    residualTable(answer),
    element("p", {}, `Known: ${given.join(", ") || "nothing"}.`),
    ...noted(found).map((note) => element("p", {}, note)),
    figure,
  );
}
