// A race to 300 mm: the visitor's hand or program against the position controller, on equal cylinders.

import { TimeChart } from "../charts";
import { Clock } from "../clock";
import type { Context, Files, Page } from "../context";
import { Cylinder, SHOWN } from "../cylinder";
import { element, segments, slider } from "../dom";
import { filesOfRun } from "../exports";
import { lawChoice } from "../law-choice";
import { Refusal } from "../library";
import { oneModel } from "../python";
import { MM, thinning } from "../quantities";
import { raced } from "../race/code";
import { Judge, LONGEST, score, TARGET, tell, VOLTS, type Result } from "../race/rules";
import { Readouts } from "../readouts";
import { Recording } from "../record";
import { Run, STEP } from "../run";
import { CONTROLLER, CYLINDER, type Racer } from "../settings";
import { position } from "./charts";

const WATCHED = ["valveVoltage", ...SHOWN];
const CLOSED = (VOLTS[0] + VOLTS[1]) / 2;
const LINES = [
  { label: "target", colour: "--muted", dashed: true },
  { label: "you", colour: "--line-1" },
  { label: "PID", colour: "--line-2", dashed: true },
];

export class Race implements Page {
  readonly root = element("div", { class: "page" });
  readonly driven = [
    `${CYLINDER}.valveVoltage`,
    ...["referencePosition", "position", "velocity"].map((name) => `${CONTROLLER}.${name}`),
  ];
  private readonly cylinders = ["You", "PID"].map((title) => new Cylinder(title));
  private readonly readouts = new Readouts(["You", "PID", "Time", "Voltage"]);
  private readonly verdict = element("output", { class: "verdict", role: "status" });
  private readonly task = element("div", { class: "task" });
  private readonly position = position(LINES);
  private readonly voltage = new TimeChart({
    title: "Valve voltage",
    up: "Voltage in V",
    lines: LINES.slice(1),
    span: 0.5,
  });
  private readonly clock = new Clock(STEP);
  /** The run under the visitor's hand, and what is known of his run; with a program, all is known before it is shown. */
  private hand: Run | null = null;
  private own: Recording | null = null;
  /** The run of the controller, from its beginning to its end. */
  private rival: Recording | null = null;
  private results: [Result | null, Result | null] = [null, null];
  /** The rows that are shown of both runs: a run that is over stays where it ended. */
  private rows = [0, 0];
  private isRunning = false;
  private isStale = true;
  private volts = CLOSED;

  constructor(private readonly context: Context) {
    const law = lawChoice(context, CYLINDER, "Friction law");
    const racers = segments<Racer>("Racer", [["hand", "By hand"], ["code", "Your program"]], context.settings.racer, (racer) => {
      context.settings.racer = racer;
      context.changed();
      this.ready();
    });
    const sides = this.cylinders.map((cylinder, index) =>
      element("div", { class: `side side-${index + 1}` }, element("strong", { class: "choice" }, index ? "PID (PositionController)" : "You"), cylinder.root),
    );
    const intro = element("p", {}, "Bring the carriage to rest at 300.00 mm, and beat the controller. Less is better: the score is the distance in mm and a tenth of the time in s.");
    this.root.append(
      element("section", { class: "card scene" }, intro, law, element("div", { class: "sides" }, ...sides), this.readouts.root, this.verdict, racers, this.task),
      element("section", { class: "charts" }, this.position.root, this.voltage.root),
    );
    this.ready();
  }

  frame(now: number): void {
    if (this.isRunning) {
      try {
        this.clock.frame(now, () => this.step());
      } catch (error) {
        if (!(error instanceof Refusal)) throw error;
        this.isRunning = false;
        this.context.tell(error.message);
      }
      this.isStale = true;
    }
    if (this.isStale) this.show();
    this.isStale = false;
  }

  change(): void {
    this.ready();
  }

  files(): Files | null {
    const { settings, library } = this.context;
    if (!this.own) {
      this.context.tell("There is no run yet: race first.");
      return null;
    }
    if (this.isRunning) {
      this.context.tell("The race is on: export once it is over.");
      return null;
    }
    this.context.tell(null);
    const members = [{ model: CYLINDER, prefix: "", values: settings.values[CYLINDER] }];
    const ssv = library.ssv("Playground", "Set in the playground", members, new Date());
    const course = { members, changes: [], isPushed: false, isRedirected: false };
    const program = (csv: string) => oneModel(library.tables, course, ["run"], "valveVoltage", null, csv);
    return filesOfRun("race", this.own, program, { ssv, charts: [this.position, this.voltage] });
  }

  /** Puts both carriages at their beginning, and asks for what begins the race. */
  private ready(): void {
    this.isRunning = false;
    this.rows = [0, 0];
    this.volts = CLOSED;
    this.results = [null, null];
    this.own = null;
    this.verdict.textContent = this.toBeat();
    try {
      this.rival = this.controlled();
      this.hand = this.byHand();
      this.own = this.hand.recording;
      this.context.tell(null);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.context.tell(error.message);
    }
    this.task.replaceChildren(...(this.context.settings.racer === "hand" ? this.handTask() : this.codeTask()));
    this.isStale = true;
  }

  private handTask(): Node[] {
    const lever = slider({
      label: "Valve voltage",
      unit: "V",
      min: VOLTS[0],
      max: VOLTS[1],
      step: 0.05,
      value: CLOSED,
      onChange: (volts) => {
        this.volts = volts;
        if (this.rows[0] === 0 && !this.isRunning) this.begin();
      },
    });
    const again = element("button", { type: "button", "data-again": "", onclick: () => this.ready() }, "New attempt");
    const hint = element("span", { class: "muted" }, "The clock starts as you move the slider, by pointer or arrow keys; 5 V closes the valve.");
    return [lever, element("div", { class: "buttons" }, again, hint)];
  }

  private codeTask(): Node[] {
    const { settings } = this.context;
    const text = element("textarea", { class: "code", rows: "9", spellcheck: "false", "aria-label": "Your program", oninput: () => {
      settings.code = text.value;
      settings.isForeign = false;
      note.hidden = true;
      this.context.changed();
    } });
    text.value = settings.code;
    // No key begins this race: the program may come from somebody else.
    const start = element("button", { type: "button", class: "primary", onclick: () => void this.race(start) }, "Race");
    const note = element("p", { class: "problem", hidden: !settings.isForeign }, "This program came with the link. Read it before you let it run; it runs in a worker, without the page and without a network.");
    const hint = element("span", { class: "muted" }, "Values outside 0 to 10 V are limited to this range. let and const before the function keep their values from step to step.");
    return [text, note, element("div", { class: "buttons" }, start, hint)];
  }

  /** Runs the visitor's program, then shows the race. */
  private async race(button: HTMLButtonElement): Promise<void> {
    const { settings, library } = this.context;
    // A value that is changed meanwhile makes a new one.
    const { rival } = this;
    button.disabled = true;
    this.verdict.textContent = "The program runs";
    try {
      const columns = await raced(settings.code, { module: library.module, values: settings.values[CYLINDER], watched: WATCHED });
      if (!this.root.isConnected || this.rival !== rival) return;
      const own = new Recording(["time", ...WATCHED]);
      for (let row = 0; row < columns[0].length; row += 1) own.push(columns.map((column) => column[row]));
      this.hand = null;
      this.own = own;
      this.begin();
    } catch (error) {
      this.verdict.textContent = error instanceof Error ? error.message : String(error);
    } finally {
      button.disabled = false;
    }
  }

  private begin(): void {
    if (!this.own || !this.rival) return;
    this.rows = [0, 0];
    this.results = [null, null];
    this.judges = [new Judge(), new Judge()];
    this.verdict.textContent = "";
    this.clock.pause();
    this.isRunning = true;
  }

  private judges = [new Judge(), new Judge()];

  /** Goes on by one row of the runs that are not over. */
  private step(): void {
    if (!this.isRunning || !this.own || !this.rival) return;
    if (!this.results[0]) this.hand?.step();
    [this.own, this.rival].forEach((recording, index) => {
      if (this.results[index]) return;
      const row = (this.rows[index] += 1);
      this.judges[index].note(recording.at("time", row), recording.at("position", row), recording.at("velocity", row));
      this.results[index] = this.judges[index].result;
    });
    if (this.results[0] && this.results[1]) this.end(this.results[0], this.results[1]);
  }

  private end(own: Result, rival: Result): void {
    const { settings } = this.context;
    this.isRunning = false;
    const before = settings.best ?? settings.toBeat;
    const isRecord = before !== null && score(own) < score(before);
    if (!settings.best || score(own) < score(settings.best)) settings.best = own;
    const won = score(own) < score(rival) ? "You win." : "The PID wins.";
    const record = isRecord ? " That is the best so far." : before ? ` The best so far: ${score(before).toFixed(2)}.` : "";
    this.verdict.textContent = `${won} You: ${tell(own)}. PID: ${tell(rival)}.${record} The link has your score.`;
    this.context.changed();
  }

  private toBeat(): string {
    const { toBeat, best } = this.context.settings;
    if (best) return `Your best: ${tell(best)}.`;
    return toBeat ? `To beat: ${tell(toBeat)}.` : "";
  }

  /** The run under the visitor's hand. */
  private byHand(): Run {
    const values = this.context.settings.values[CYLINDER];
    const member = { prefix: "", model: CYLINDER, values, first: new Map([["valveVoltage", CLOSED]]), watched: WATCHED };
    return new Run(this.context.library, [member], (_, run) => run.set(0, new Map([["valveVoltage", this.volts]])));
  }

  /** The run of the controller. */
  private controlled(): Recording {
    const { settings, library } = this.context;
    const members = [
      { prefix: "", model: CYLINDER, values: settings.values[CYLINDER], first: new Map(), watched: WATCHED },
      { prefix: "controller.", model: CONTROLLER, values: settings.values[CONTROLLER], first: new Map([["referencePosition", TARGET]]), watched: ["valveVoltage"] },
    ];
    // Slots from 1 on: the visitor's cylinder has slot 0.
    const run = new Run(library, members, (_, running) => {
      const values = running.read(0);
      const inputs = ["position", "velocity"].map((name) => [name, values[WATCHED.indexOf(name)]] as const);
      running.set(1, new Map([["referencePosition", TARGET], ...inputs]));
      running.set(0, new Map([["valveVoltage", running.read(1)[0]]]));
    }, 1);
    while (run.time < LONGEST) run.step();
    return run.recording;
  }

  private show(): void {
    const { own, rival, rows } = this;
    if (!own || !rival) return;
    const stroke = this.context.settings.values[CYLINDER].get("cylinder.stroke") ?? 0.5;
    [own, rival].forEach((recording, index) => {
      this.cylinders[index].aim(TARGET, stroke);
      this.cylinders[index].show(SHOWN.map((name) => recording.at(name, rows[index])), stroke);
    });
    // Both runs have the same time grid; the rival's covers every row.
    const last = Math.max(...rows);
    const time = rival.at("time", last);
    this.readouts.show("You", `${(own.at("position", rows[0]) * MM).toFixed(2)} mm`);
    this.readouts.show("PID", `${(rival.at("position", rows[1]) * MM).toFixed(2)} mm`);
    this.readouts.show("Time", `${time.toFixed(2)} s`);
    this.readouts.show("Voltage", `${own.at("valveVoltage", rows[0]).toFixed(2)} V`);
    const column = thinning(rival, 0, last + 1);
    const times = column("time");
    const line = (index: 0 | 1, name: string, factor?: number) =>
      times.map((_, place) => {
        const row = Math.round(times[place] / STEP);
        return row > rows[index] ? NaN : [own, rival][index].at(name, row) * (factor ?? 1);
      });
    const range: [number, number] = [0, Math.max(time, 4)];
    this.position.show({ times, lines: [times.map(() => TARGET * MM), line(0, "position", MM), line(1, "position", MM)] }, range);
    this.voltage.show({ times, lines: [line(0, "valveVoltage"), line(1, "valveVoltage")] }, range);
  }
}
