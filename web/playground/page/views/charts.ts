// Charts of several pages.

import { PathChart, TimeChart, type Line, type Look } from "../charts";

/** Departures from the usual look. */
type More = Partial<Look>;

export const position = (lines: Line[], more: More = {}): TimeChart =>
  new TimeChart({ title: "Position", up: "Position in mm", lines, span: 1, ...more });

export const friction = (lines: Line[], more: More = {}): TimeChart =>
  new TimeChart({ title: "Friction force", up: "Force in N", lines, span: 2, ...more });

export const frictionOverVelocity = (lines: Line[]): PathChart =>
  new PathChart({ title: "Friction over velocity", across: "Velocity in mm/s", up: "Friction force in N", lines, span: 2 });

/** The line of a single friction force. */
export const FRICTION: Line = { label: "friction force", colour: "--line-3" };
