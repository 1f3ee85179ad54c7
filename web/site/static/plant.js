// The plant in its frame on the landing page: loaded once the page is there, as high as it needs to be, in the page's colours.
"use strict";

(() => {
  const frame = document.getElementById("plant");
  const dark = matchMedia("(prefers-color-scheme: dark)");

  /** Light or dark, as the button of the page says, or else the system. */
  const theme = () => {
    const chosen = document.body.dataset.theme;
    if (chosen === "light" || chosen === "dark") return chosen;
    return dark.matches ? "dark" : "light";
  };
  // A page that is opened from a folder has no origin that could be named.
  const tell = () => frame.contentWindow.postMessage({ theme: theme() }, "*");

  addEventListener("message", ({ source, data }) => {
    if (source !== frame.contentWindow || !Number.isFinite(data?.height)) return;
    frame.style.height = `${data.height}px`;
  });
  new MutationObserver(tell).observe(document.body, { attributeFilter: ["data-theme"] });
  dark.addEventListener("change", tell);
  addEventListener("load", () => {
    frame.addEventListener("load", tell);
    frame.src = `${frame.dataset.src}&theme=${theme()}`;
  });
})();
