// The page in the frame of another one, `index.html?embed`: the plant alone, in the colours of that page and as high as
// it needs to be.

const asked = new URLSearchParams(location.search);
const root = document.documentElement;

/** Whether the address asks for it. */
export const isEmbedded = asked.has("embed") || asked.has("embedded");

/** Takes over a theme; anything else is left alone, since any page may write to a frame. */
function take(theme: unknown): void {
  if (theme !== "light" && theme !== "dark") return;
  root.dataset.theme = theme;
  dispatchEvent(new Event("themechange"));
}

/** Hides what is not the plant, and keeps in touch with the page around. */
export function embed(): void {
  if (!isEmbedded) return;
  root.dataset.embedded = "";
  take(asked.get("theme"));
  addEventListener("message", ({ source, data }) => {
    if (source === parent) take((data as { theme?: unknown } | null)?.theme);
  });
  // The page around may have no origin that could be named: it may be a file.
  new ResizeObserver(() => parent.postMessage({ height: root.scrollHeight }, "*")).observe(document.body);
}

/** Whether a run begins by itself: not where the visitor wants things that move only when he asks for them. */
export const startsByItself = !(isEmbedded && matchMedia("(prefers-reduced-motion: reduce)").matches);
