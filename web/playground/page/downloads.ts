// Downloads: the run, the parameters, a program.

import type { Context, Files } from "./context";
import { css } from "./charts";
import { element } from "./dom";
import { Refusal } from "./library";
import { drawing } from "./svg";

/** Fills a place with buttons for the files of the present page and for its link. */
export function offerFiles(place: HTMLElement, files: () => Files | null, context: Context): void {
  const offer = (label: string, title: string, key: "csv" | "ssv" | "python", extension: string) =>
    element(
      "button",
      {
        type: "button",
        title,
        onclick: () => {
          const made = files();
          if (!made) return;
          try {
            save(`${made.name}.${extension}`, made[key]);
          } catch (error) {
            if (!(error instanceof Refusal)) throw error;
            context.tell(error.message);
          }
        },
      },
      label,
    );
  const svg = element(
    "button",
    {
      type: "button",
      title: "The charts as they are, for reports and slides",
      onclick: () => {
        const made = files();
        if (made) save(`${made.name}.svg`, drawing(made.charts, (name) => css(name, "light")));
      },
    },
    "SVG",
  );
  const link = copier("Copy link", "Copy a link that restores this setting", context, (address) => address);
  place.append(
    offer("CSV", "The run so far, in SI units", "csv", "csv"),
    offer("SSV", "The changed parameters, for the FMU", "ssv", "ssv"),
    offer("Python", "A program that repeats the run", "python", "py"),
    svg,
    link,
    copier("Copy frame", "Copy the text that shows this setting in another page", context, (address) => {
      const [page, fragment] = address.split("#");
      return `<iframe title="Pneumatic servo cylinder" src="${page.split("?")[0]}?embed#${fragment.replaceAll("&", "&amp;")}" width="100%" height="680"></iframe>`;
    }),
  );
}

/** Gives the visitor a file. */
export function save(name: string, content: BlobPart, type = "text/plain;charset=utf-8"): void {
  const address = URL.createObjectURL(new Blob([content], { type }));
  element("a", { href: address, download: name }).click();
  // The browser has the file once it has begun to save it.
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** A button that copies a text with the address of the present setting. */
function copier(label: string, title: string, context: Context, text: (address: string) => string): HTMLElement {
  const copy = async () => {
    history.replaceState(null, "", context.settings.fragment());
    try {
      await navigator.clipboard.writeText(text(location.href));
      button.textContent = "Copied";
    } catch {
      // A page that was opened as a file may not be allowed to.
      prompt(`${label}: Ctrl+C`, text(location.href));
    }
    setTimeout(() => (button.textContent = label), 2000);
  };
  const button = element("button", { type: "button", title, onclick: () => void copy() }, label);
  return button;
}
