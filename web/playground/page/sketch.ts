// A curve that is drawn with a finger, a mouse, or the arrow keys.

import { element, shape } from "./dom";

const [WIDTH, HEIGHT] = [400, 110];

/** A pad with a curve from -1 to 1; `onChange` gets the curve while it is drawn. */
export function sketch(label: string, points: readonly number[], onChange: (points: number[]) => void): HTMLElement {
  const curve = points.slice();
  const end = curve.length - 1;
  let place = 0;
  const line = shape("polyline", { class: "curve" });
  const mark = element("span", { class: "mark" });
  const drawing = shape(
    "svg",
    { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", "aria-hidden": "true" },
    shape("path", { d: `M0 ${HEIGHT / 2} H${WIDTH}`, class: "middle" }),
    line,
  );
  const pad = element("div", { class: "sketch", tabindex: "0", role: "slider", "aria-label": label }, drawing, mark);
  const at = (index: number): [number, number] => [(index / end) * WIDTH, ((1 - curve[index]) / 2) * HEIGHT];

  const show = () => {
    line.setAttribute("points", curve.map((_, index) => at(index).join(",")).join(" "));
    const [x, y] = at(place);
    mark.style.left = `${(100 * x) / WIDTH}%`;
    mark.style.top = `${(100 * y) / HEIGHT}%`;
    pad.setAttribute("aria-valuemin", "-100");
    pad.setAttribute("aria-valuemax", "100");
    pad.setAttribute("aria-valuenow", String(Math.round(curve[place] * 100)));
    pad.setAttribute("aria-valuetext", `point ${place + 1} of ${curve.length}: ${Math.round(curve[place] * 100)} %`);
  };

  /** Moves to a point, and gives all points on the way there values on a straight line. */
  const draw = (to: number, value: number, from: number) => {
    const [low, high] = [Math.min(from, to), Math.max(from, to)];
    const first = from === to ? value : curve[from];
    for (let index = low; index <= high; index += 1) {
      const part = from === to ? 1 : (index - from) / (to - from);
      curve[index] = first + (value - first) * part;
    }
    place = to;
    show();
    onChange(curve.slice());
  };

  const target = (event: PointerEvent): [number, number] => {
    const box = pad.getBoundingClientRect();
    const index = Math.round(((event.clientX - box.left) / box.width) * end);
    const value = 1 - (2 * (event.clientY - box.top)) / box.height;
    return [Math.min(Math.max(index, 0), end), Math.min(Math.max(value, -1), 1)];
  };

  pad.addEventListener("pointerdown", (event) => {
    pad.setPointerCapture(event.pointerId);
    const [index, value] = target(event);
    draw(index, value, index);
  });
  pad.addEventListener("pointermove", (event) => {
    if (pad.hasPointerCapture(event.pointerId)) draw(...target(event), place);
  });
  pad.addEventListener("keydown", (event) => {
    const step = event.shiftKey ? 10 : 1;
    const moves: Record<string, () => void> = {
      ArrowLeft: () => (place = Math.max(place - step, 0)),
      ArrowRight: () => (place = Math.min(place + step, end)),
      ArrowUp: () => draw(place, Math.min(curve[place] + 0.02 * step, 1), place),
      ArrowDown: () => draw(place, Math.max(curve[place] - 0.02 * step, -1), place),
    };
    if (!moves[event.key]) return;
    event.preventDefault();
    moves[event.key]();
    show();
  });
  show();
  return pad;
}
