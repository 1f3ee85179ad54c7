// Parameters from a measured table: the fit of the Python package, in the browser.

import type { Chart } from "../charts";
import type { Files, Page } from "../context";
import { element } from "../dom";
import { columnTable, dropZone, experimentChoice } from "../fit/data-card";
import { filesOf } from "../fit/files";
import { findingList, sensorList } from "../fit/findings";
import { choices, freeList } from "../fit/free-card";
import { curves, preview, resultTables } from "../fit/result-card";
import { machine } from "../fit/machine-card";
import { printReport } from "../fit/print";
import type { FitContext, Study } from "../fit/study";
import { lawChoice } from "../law-choice";
import { BENCH, CYLINDER } from "../settings";

/** Measured inputs, which are no parameters. */
const DRIVEN = [
  `${CYLINDER}.valveVoltage`,
  ...["bench.drive", "driveVelocity", "prescribedPosition", "friction.level", "position0"].map((name) => `${BENCH}.${name}`),
];

export class Fit implements Page {
  readonly root = element("div", { class: "page fit" });
  readonly driven = DRIVEN;
  private readonly study: Study;
  private charts: readonly Chart<never>[] = [];
  private readonly bar = element("progress", { max: "1", "aria-label": "Progress" });
  private readonly findings = element("div");
  private readonly start = element("div");
  private readonly told = element("output", { class: "status", "data-progress": "" });

  constructor(private readonly context: FitContext) {
    this.study = context.study;
    this.study.shown = () => this.show();
    this.study.informed = () => this.inform();
    this.study.progressed = () => this.tell();
    this.show();
  }

  frame(): void {}

  change(_: string, name: string): void {
    if (name === "friction.law") this.study.lawChanged();
    this.show();
  }

  files(): Files | null {
    if (!this.study.found) this.context.tell("There is no fit yet: start one first.");
    return this.study.found && Object.assign(filesOf(this.context, this.study.found), { charts: this.charts });
  }

  /** Shows everything anew; what has the focus keeps it. */
  private show(): void {
    const { context, study } = this;
    study.check();
    const focused = document.activeElement?.getAttribute("aria-label");
    const law = lawChoice(context, study.modelName, "Law");
    const { found } = study;
    this.charts = found ? curves(found) : preview(context);
    this.inform();
    this.root.replaceChildren(
      element("section", { class: "card scene" }, dropZone(context), this.findings, experimentChoice(context), columnTable(context), sensorList(context)),
      element("section", { class: "card scene" }, law, machine(context) ?? "", freeList(context), choices(context), this.start),
      found ? resultTables(context, found, () => printReport(context, found)) : "",
      this.charts.length ? element("section", { class: "charts" }, ...this.charts.map(({ root }) => root)) : "",
    );
    this.tell();
    if (focused && !document.activeElement?.getAttribute("aria-label")) {
      this.root.querySelector<HTMLElement>(`[aria-label="${CSS.escape(focused)}"]`)?.focus();
    }
  }

  /** Shows the findings about the record, and whether a fit may start: alone, so that a text that is being typed stays. */
  private inform(): void {
    this.findings.replaceChildren(findingList(this.context) ?? "");
    this.start.replaceChildren(this.transport());
  }

  private transport(): HTMLElement {
    const { study } = this;
    const isBusy = study.work.kind !== "none";
    const button = isBusy
      ? element("button", { type: "button", class: "primary", "aria-label": "Fit or cancel", onclick: () => study.cancel() }, "Cancel")
      : element("button", { type: "button", class: "primary", "aria-label": "Fit or cancel", onclick: () => study.start() }, "Fit");
    const obstacle = isBusy ? null : study.obstacle;
    button.disabled = obstacle !== null;
    const why = obstacle && study.table ? element("p", { class: "muted" }, obstacle) : null;
    const problem = study.problem ? element("p", { class: "problem", role: "alert", "data-problem": "" }, study.problem) : null;
    this.bar.hidden = !isBusy;
    return element("div", {}, element("div", { class: "transport" }, button, this.bar, this.told), why, problem);
  }

  /** Shows how far the work has come. */
  private tell(): void {
    const { work } = this.study;
    if (work.kind === "none") {
      this.told.textContent = "";
    } else if (work.kind === "reading") {
      this.bar.removeAttribute("value");
      this.told.textContent = "Reading";
    } else if (!work.progress) {
      this.bar.removeAttribute("value");
      this.told.textContent = "The fit begins";
    } else {
      const { stage, runs, share, misfit } = work.progress;
      this.bar.value = share;
      const residual = misfit === null ? "" : `; the residual is ${Number(misfit.toPrecision(3))} times the noise`;
      this.told.textContent = `${stage}: run ${runs}${residual}`;
    }
  }
}
