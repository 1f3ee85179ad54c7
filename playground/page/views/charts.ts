// The charts that several pages have.

import { PathChart, TimeChart, type Line, type Look } from "../charts";

/** What differs from the usual look. */
type More = Partial<Look>;

export const position = (lines: Line[], more: More = {}): TimeChart =>
  new TimeChart({ title: "Position", up: "mm", lines, span: 1, ...more });

export const friction = (lines: Line[], more: More = {}): TimeChart =>
  new TimeChart({ title: "Friction force", up: "N", lines, span: 2, ...more });

export const frictionOverVelocity = (lines: Line[]): PathChart =>
  new PathChart({ title: "Friction over velocity", across: "v in mm/s", up: "N", lines, span: 2 });

/** The line of a single friction force. */
export const FRICTION: Line = { label: "friction force", colour: "--line-3" };
