// Hysteresis loops of a force over a displacement, and whether they close.

/** A loop that a displacement went around. */
export interface Loop {
  /** Displacements between which it lies. */
  from: number;
  to: number;
  /** Force on the way back to its beginning less the force there. */
  gap: number;
}

interface Turn {
  displacement: number;
  force: number;
}

/**
 * The closed loops of a displacement, innermost first: it turns, turns again, and comes back to where it turned first.
 * A law with non-local memory has the same force there again; then the loop is as good as forgotten.
 */
export function loops(displacements: ArrayLike<number>, forces: ArrayLike<number>): Loop[] {
  const found: Loop[] = [];
  const turns: Turn[] = [];
  let way = 0;
  for (let row = 1; row < displacements.length; row += 1) {
    const [before, now] = [displacements[row - 1], displacements[row]];
    const direction = Math.sign(now - before);
    if (direction === 0) continue;
    // Where it sets out from is no turn.
    if (direction !== way && way !== 0) turns.push({ displacement: before, force: forces[row - 1] });
    way = direction;
    while (turns.length >= 2) {
      const [first, second] = turns.slice(-2);
      if ((now - first.displacement) * direction < 0) break;
      const part = (first.displacement - before) / (now - before);
      // The loop ends where the displacement passes its beginning, between two rows.
      const force = forces[row - 1] + (forces[row] - forces[row - 1]) * Math.min(Math.max(part, 0), 1);
      const [from, to] = [first.displacement, second.displacement].sort((a, b) => a - b);
      found.push({ from, to, gap: force - first.force });
      turns.splice(-2);
    }
  }
  return found;
}
