// Tabs, moved between by the arrow keys.

import { element } from "./dom";
import type { View } from "./settings";

const TITLES: Record<View, string> = {
  "stick-slip": "Stick-slip",
  "two-laws": "Two laws",
  presliding: "Presliding",
  "closed-loop": "Closed loop",
  race: "Race",
  fit: "Fit",
};

/** Fills a list of tabs; returns what marks the present one. */
export function tabs(list: HTMLElement, views: readonly View[], choose: (view: View) => void): (view: View) => void {
  const buttons = views.map((view) =>
    element("button", { type: "button", role: "tab", "aria-controls": "page", onclick: () => choose(view) }, TITLES[view]),
  );
  list.append(...buttons);
  list.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const present = buttons.indexOf(document.activeElement as HTMLButtonElement);
    if (!step || present < 0) return;
    const next = (present + step + views.length) % views.length;
    buttons[next].focus();
    choose(views[next]);
  });
  return (view) => {
    views.forEach((candidate, index) => {
      buttons[index].setAttribute("aria-selected", String(candidate === view));
      buttons[index].tabIndex = candidate === view ? 0 : -1;
    });
  };
}
