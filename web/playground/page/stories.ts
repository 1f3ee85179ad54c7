// Stories: settings that each show one thing, and what to watch.

import { element } from "./dom";

export interface Story {
  key: string;
  title: string;
  watch: string;
  /** Title of the chart to look at. */
  chart: string;
  /** Fragment of the link, without the story. */
  link: string;
}

const CYLINDER = "PneumaticServoCylinder";
const GAIN = "PositionController.gain.integral";
const FRICTION = `${CYLINDER}.friction`;
/** A slow ramp, and a step to 300 mm, under the position controller. */
const RAMP = `view=closed-loop&signal=ramp&level=0.25&amplitude=0.02&period=20&${GAIN}=0`;
const STEP = "view=closed-loop&signal=constant&level=0.3&amplitude=0.04&period=8";

export const STORIES: readonly Story[] = [
  {
    key: "push",
    title: "Push it",
    watch: "pull the carriage to the right: up to 11 N the force stays inside the band and nothing moves; beyond 11 N it goes.",
    chart: "Position",
    link: "view=stick-slip&signal=constant&level=5&amplitude=0.6&period=4",
  },
  {
    key: "reversal",
    title: "It sticks at every reversal",
    watch: "at each reversal the curve is flat and red, until the force has crossed the band from one end to the other.",
    chart: "Position",
    link: "view=stick-slip&signal=sine&level=5&amplitude=0.6&period=4&centring=1",
  },
  {
    key: "staircase",
    title: "A slow ramp becomes a staircase",
    watch: "the reference rises by 4 mm/s, the carriage in steps of about 2 mm: it rests, breaks away, and rests again.",
    chart: "Position",
    link: RAMP,
  },
  {
    key: "equal",
    title: "Fs = Fc: no staircase",
    watch: "static friction is now as small as Coulomb friction, and the steps are gone but for the reversals.",
    chart: "Position",
    link: `${RAMP}&${FRICTION}.stribeck.Fs=8.3`,
  },
  {
    key: "short",
    title: "P alone stops short",
    watch: "after the move the error stays at 0.67 mm: the controller asks for less force than friction holds.",
    chart: "Position error",
    link: `${STEP}&${GAIN}=0`,
  },
  {
    key: "hunt",
    title: "Add I: it hunts",
    watch: "the integral part grows until the carriage breaks away and overshoots, again and again; the error swings by more than 1 mm.",
    chart: "Position error",
    link: `${STEP}&${GAIN}=60`,
  },
  {
    key: "cures",
    title: "Cures of hunting",
    watch: "dither moves the valve to and fro, and the error shrinks to 0.01 mm; switch it off, try the others, or press Compare.",
    chart: "Position error",
    link: `${STEP}&${GAIN}=10&dither=1`,
  },
  {
    key: "smooth",
    title: "A smooth law hides it",
    watch: "SmoothCoulomb has no static friction: the same loop swings less and never rests, so the break-aways are missing.",
    chart: "Position error",
    link: `${STEP}&${GAIN}=60&${FRICTION}.law=4`,
  },
  {
    key: "creep",
    title: "A smooth law creeps",
    watch: "both carriages carry 8 N with open chambers: under Stribeck it rests, under SmoothCoulomb it creeps away by 2 mm/s.",
    chart: "Position",
    link: `view=two-laws&signal=constant&level=5&amplitude=0.5&period=8&second=4&${CYLINDER}.chamberA.open=1&${CYLINDER}.chamberB.open=1&${CYLINDER}.externalForce=8`,
  },
  {
    key: "memory",
    title: "LuGre's loops do not close",
    watch: "small loops inside the large one: those of springs and sliders close, those of a single bristle drift.",
    chart: "Friction over displacement",
    link: "view=presliding&FrictionBench.friction.law=14",
  },
  { key: "race", title: "Stop at 300.00 mm by hand", watch: "drag the slider to start; the carriage sticks just before you want it to.", chart: "Position", link: "view=race" },
  { key: "fit", title: "Parameters from a table", watch: "press Try the example, then Fit: friction comes out of measured motion, with its uncertainty.", chart: "position", link: "view=fit" },
];

/** Links to all stories, each of which opens its settings. */
export const storyLinks = (): HTMLElement[] =>
  STORIES.map(({ key, title, link }) => element("a", { href: `#story=${key}&${link}`, "data-story": key }, title));

/** What to watch in a story, with a button to the next one; marks its chart in the page. */
export function tellStory(place: HTMLElement, key: string | null): void {
  const at = STORIES.findIndex((story) => story.key === key);
  place.hidden = at < 0;
  for (const link of document.querySelectorAll<HTMLElement>("[data-story]")) {
    const isPresent = link.dataset.story === key;
    link.toggleAttribute("aria-current", isPresent);
    if (isPresent) link.scrollIntoView({ block: "nearest", inline: "nearest" });
  }
  if (at < 0) return;
  const next = STORIES[(at + 1) % STORIES.length];
  const forward = element("a", { class: "next", href: `#story=${next.key}&${next.link}`, title: next.title }, "Next");
  place.replaceChildren(element("span", {}, element("strong", {}, "Watch: "), STORIES[at].watch), forward);
  for (const chart of document.querySelectorAll(".chart")) chart.classList.toggle("watched", chart.getAttribute("aria-label") === STORIES[at].chart);
}
