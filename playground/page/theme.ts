// The theme: the system's, until the visitor chooses light or dark.

/** Makes a button switch between light and dark; charts hear of it by the event `themechange`. */
export function themeButton(button: HTMLElement): void {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const root = document.documentElement;
  const isDark = () => (root.dataset.theme ?? (system.matches ? "dark" : "light")) === "dark";
  const tell = () => {
    button.textContent = isDark() ? "Light" : "Dark";
    dispatchEvent(new Event("themechange"));
  };
  button.addEventListener("click", () => {
    root.dataset.theme = isDark() ? "light" : "dark";
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
