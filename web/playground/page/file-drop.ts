// A place where a file is dropped or chosen.

import { element } from "./dom";

/** Endings and types of tables. */
const TABLES = ".csv,.txt,.tsv,.dat,.lvm,.gz,text/csv,text/plain";

/** Fills a place with a text, a button for files and further buttons; `open` hears of the file. */
export function fileDrop(options: { label: string; text: string; accept?: string; open: (file: File) => void }, ...buttons: HTMLElement[]): HTMLElement {
  const { label, text, accept = TABLES, open } = options;
  const input = element("input", {
    type: "file",
    accept,
    class: "hidden-input",
    "aria-label": label,
    onchange: () => {
      const [file] = input.files ?? [];
      if (file) open(file);
      input.value = "";
    },
  });
  const zone = element(
    "div",
    { class: "drop" },
    element("p", {}, element("strong", {}, text)),
    element("div", { class: "buttons" }, element("label", { class: "button" }, "Choose a file", input), ...buttons),
  );
  for (const kind of ["dragover", "dragenter"] as const) {
    zone.addEventListener(kind, (event) => {
      event.preventDefault();
      zone.classList.add("over");
    });
  }
  zone.addEventListener("dragleave", () => zone.classList.remove("over"));
  zone.addEventListener("drop", (event) => {
    event.preventDefault();
    zone.classList.remove("over");
    const file = event.dataTransfer?.files[0];
    if (file) open(file);
  });
  return zone;
}
