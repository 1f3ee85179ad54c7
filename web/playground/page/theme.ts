// The theme: the system's, until the visitor chooses light or dark.

import { isEmbedded } from "./embedded";

/** Under which the browser keeps the choice. */
const KEY = "pneumatic-servo-theme";

/** Makes a button switch between light and dark; charts hear of it by the event `themechange`. */
export function themeButton(button: HTMLElement): void {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const root = document.documentElement;
  try {
    const kept = localStorage.getItem(KEY);
    if (!isEmbedded && (kept === "dark" || kept === "light")) root.dataset.theme = kept;
  } catch {
    // A browser may keep nothing for a page that is a file.
  }
  const isDark = () => (root.dataset.theme ?? (system.matches ? "dark" : "light")) === "dark";
  const tell = () => {
    button.textContent = isDark() ? "Light" : "Dark";
    dispatchEvent(new Event("themechange"));
  };
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
    try {
      localStorage.setItem(KEY, root.dataset.theme);
    } catch {
      // Then it lasts until the page is loaded again.
    }
    tell();
  });
  system.addEventListener("change", tell);
  tell();
}

/** Makes a button show the page on the whole screen, where the browser can. */
export function screenButton(button: HTMLElement): void {
  button.hidden = !document.fullscreenEnabled;
  button.addEventListener("click", () => {
    void (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen());
  });
  addEventListener("fullscreenchange", () => (button.textContent = document.fullscreenElement ? "Window" : "Full screen"));
}
