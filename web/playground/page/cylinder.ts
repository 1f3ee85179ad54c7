// The drawing of the cylinder: valve, chambers coloured by pressure, carriage, and the friction force on it.

import { shape } from "./dom";

/** Quantities of the drawing, named as in the model. */
export const SHOWN = [
  "position",
  "velocity",
  "frictionForce",
  "chamberA.pressure",
  "chamberB.pressure",
  "chamberA.massFlow",
  "chamberB.massFlow",
  "valve.spool",
  "sticking",
  "pressureForce",
  "acceleration",
] as const;

const [LEFT, RIGHT, TOP, BOTTOM] = [24, 264, 30, 82];
/** Where the piston is drawn at both ends of the stroke. */
const [FROM, TO] = [LEFT + 14, RIGHT - 14];
const ROD = 150;
/** Length in px of an arrow for 1 N, and the longest one. */
const NEWTON = 4;
const LONGEST = 64;

/** Pushing force in N of a pointer that is 1 px of the drawing away, and of an arrow key. */
const [PER_PX, BY_KEY] = [0.25, 15];

/** Fraction of a pressure in Pa between ambient air (0) and full supply (1), for its colour. */
const fullness = (pressure: number): number => Math.min(Math.max((pressure - 101_325) / 600_000, 0), 1);

export class Cylinder {
  readonly root: SVGElement;
  private readonly a = shape("rect", { x: LEFT, y: TOP, height: BOTTOM - TOP, class: "gas" });
  private readonly b = shape("rect", { y: TOP, height: BOTTOM - TOP, class: "gas" });
  private readonly moving = shape("g", {});
  private readonly carriage = shape("rect", { x: ROD - 4, y: 26, width: 58, height: 60, rx: 6, class: "carriage" });
  private readonly arrow = shape("path", { class: "friction" });
  private readonly label = shape("text", { class: "friction-label", y: 19 });
  private readonly stuck = shape("text", { x: ROD + 25, y: 60, class: "stuck" });
  private readonly spool = shape("g", {});
  private readonly flows: SVGElement[];
  private readonly push = shape("path", { class: "pushed" });
  private readonly newton = shape("text", { class: "newton", y: 46 });
  private readonly mark = shape("path", { class: "target" });
  private force = 0;

  /** `title` says which of several it is. */
  constructor(private readonly title: string) {
    const piston = shape("rect", { x: -8, y: TOP, width: 16, height: BOTTOM - TOP, rx: 2, class: "steel" });
    const rod = shape("rect", { x: 0, y: 50, width: ROD, height: 12, class: "steel" });
    this.moving.append(rod, piston, this.carriage, this.stuck);
    const pipe = (x: number, side: number) =>
      shape("path", { d: `M${x} ${BOTTOM + 4} V112 H${144 + side * 18} V126`, class: "pipe" });
    this.flows = [LEFT + 8, RIGHT - 8].map((x) => shape("path", { transform: `translate(${x} 103)`, class: "flow" }));
    const letter = (x: number, y: number, text: string) => {
      const made = shape("text", { x, y, class: "letter" });
      made.textContent = text;
      return made;
    };
    for (const x of [-16, 0, 16]) this.spool.append(shape("rect", { x: x - 4, y: 130, width: 8, height: 14, rx: 1.5, class: "steel" }));
    this.spool.append(shape("rect", { x: -16, y: 135.5, width: 32, height: 3, class: "steel" }));
    this.root = shape(
      "svg",
      { viewBox: "0 0 500 152", class: "cylinder", role: "group" },
      pipe(LEFT + 8, -1),
      pipe(RIGHT - 8, 1),
      shape("rect", { x: 104, y: 126, width: 80, height: 22, rx: 3, class: "valve" }),
      this.spool,
      this.a,
      this.b,
      shape("path", { d: `M${LEFT} ${TOP} H${RIGHT} V48 M${RIGHT} 64 V${BOTTOM} H${LEFT} V${TOP}`, class: "barrel" }),
      shape("path", { d: "M280 91 H488", class: "rail" }),
      this.mark,
      this.moving,
      this.arrow,
      this.label,
      this.push,
      this.newton,
      ...this.flows,
      letter(LEFT + 12, TOP + 16, "A"),
      letter(RIGHT - 12, TOP + 16, "B"),
      letter(88, 141, "5/3"),
    );
  }

  /** Lets a pointer that holds the carriage, or an arrow key, push it; `onPush` hears of the force in N. */
  letPush(onPush: (force: number) => void): void {
    let from: number | null = null;
    const pushed = (force: number) => {
      this.force = force;
      this.carriage.setAttribute("aria-valuenow", force.toFixed(0));
      onPush(force);
    };
    this.carriage.append(hint());
    this.carriage.classList.add("pushable");
    const place = (event: Event) => {
      const drawn = (this.root as SVGSVGElement).getScreenCTM();
      return drawn ? ((event as PointerEvent).clientX - drawn.e) / drawn.a : 0;
    };
    this.carriage.setAttribute("tabindex", "0");
    this.carriage.setAttribute("role", "slider");
    this.carriage.setAttribute("aria-label", "Push the carriage: hold an arrow key");
    this.carriage.setAttribute("aria-valuenow", "0");
    this.carriage.addEventListener("pointerdown", (event) => {
      this.carriage.setPointerCapture((event as PointerEvent).pointerId);
      from = place(event);
    });
    this.carriage.addEventListener("pointermove", (event) => {
      if (from !== null) pushed((place(event) - from) * PER_PX);
    });
    for (const kind of ["pointerup", "pointercancel"]) {
      this.carriage.addEventListener(kind, () => {
        from = null;
        pushed(0);
      });
    }
    this.carriage.addEventListener("keydown", (event) => {
      const side = { ArrowLeft: -1, ArrowRight: 1 }[(event as KeyboardEvent).key];
      if (!side) return;
      event.preventDefault();
      pushed(side * BY_KEY);
    });
    for (const kind of ["keyup", "blur"]) this.carriage.addEventListener(kind, () => pushed(0));
  }

  /** Marks where the middle of the carriage is at a position. */
  aim(position: number, stroke: number): void {
    this.mark.setAttribute("d", `M${(FROM + ((TO - FROM) * position) / stroke + ROD + 25).toFixed(2)} 4 V100`);
  }

  /** Shows values in the order of [`SHOWN`], for a stroke in m. */
  show(values: ArrayLike<number>, stroke: number): void {
    const [position, , friction, pressureA, pressureB, flowA, flowB, spool, sticking] = Array.from(values);
    const piston = FROM + ((TO - FROM) * position) / stroke;
    this.moving.setAttribute("transform", `translate(${piston.toFixed(2)} 0)`);
    this.a.setAttribute("width", String(Math.max(piston - LEFT, 0)));
    this.b.setAttribute("x", String(piston));
    this.b.setAttribute("width", String(Math.max(RIGHT - piston, 0)));
    this.a.style.setProperty("--fullness", `${(fullness(pressureA) * 100).toFixed(1)}%`);
    this.b.style.setProperty("--fullness", `${(fullness(pressureB) * 100).toFixed(1)}%`);
    this.spool.setAttribute("transform", `translate(${144 + 14 * Math.max(-1, Math.min(1, spool))} 0)`);
    this.carriage.classList.toggle("held", sticking === 1);
    this.stuck.textContent = sticking === 1 ? "STICKS" : "";
    // The force on the carriage points against the motion that it opposes.
    const [middle, side] = [piston + ROD + 25, Math.sign(this.force)];
    const opposing = arrow(middle, 14, -friction * NEWTON);
    this.arrow.setAttribute("d", opposing);
    // Behind its tail.
    this.label.setAttribute("x", String(middle + 6 * Math.sign(friction)));
    this.label.setAttribute("text-anchor", friction > 0 ? "start" : "end");
    this.label.textContent = opposing && "friction";
    this.push.setAttribute("d", arrow(middle + side * 32, 56, this.force * NEWTON));
    this.newton.setAttribute("x", String(middle + side * 70));
    this.newton.textContent = this.force === 0 ? "" : `${this.force.toFixed(0)} N`;
    [flowA, flowB].forEach((flow, index) => this.flows[index].setAttribute("d", wedge(flow)));
    const state = sticking === 1 ? "sticks" : "slides";
    this.root.setAttribute("aria-label", `${this.title}: carriage at ${(position * 1000).toFixed(1)} mm, ${state}`);
  }
}

function hint(): SVGElement {
  const title = shape("title", {});
  title.textContent = "Hold and pull to push the carriage; or focus it and hold an arrow key";
  return title;
}

/** An arrow from a point, of a length in px that may be negative. */
function arrow(x: number, y: number, wanted: number): string {
  const length = Math.max(-LONGEST, Math.min(LONGEST, wanted));
  if (Math.abs(length) < 3) return "";
  const head = Math.sign(length) * Math.min(8, Math.abs(length));
  const [end, neck] = [x + length, x + length - head];
  return `M${x} ${y - 2} H${neck} V${y - 6} L${end} ${y} L${neck} ${y + 6} V${y + 2} H${x} Z`;
}

/** A wedge that points up for flow into the chamber, as large as the flow. */
function wedge(flow: number): string {
  const size = Math.min(Math.abs(flow) * 6e3, 7);
  const tip = -Math.sign(flow) * size;
  return size < 0.7 ? "" : `M${-size} ${-tip} H${size} L0 ${tip} Z`;
}
