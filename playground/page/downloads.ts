// What a visitor takes home.

import type { Context, Files } from "./context";
import { element } from "./dom";

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
          if (made) save(`${made.name}.${extension}`, made[key]);
        },
      },
      label,
    );
  const link = element(
    "button",
    { type: "button", title: "Copy a link that restores this setting", onclick: () => void copy(link, context) },
    "Copy link",
  );
  place.append(
    offer("CSV", "The run so far, in SI units", "csv", "csv"),
    offer("SSV", "The changed parameters, for the FMU", "ssv", "ssv"),
    offer("Python", "A program that repeats the run", "python", "py"),
    link,
  );
}

function save(name: string, text: string): void {
  const address = URL.createObjectURL(new Blob([text], { type: "text/plain;charset=utf-8" }));
  element("a", { href: address, download: name }).click();
  // The browser has the file once it has begun to save it.
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

async function copy(button: HTMLElement, context: Context): Promise<void> {
  const fragment = context.settings.fragment(context.library.tables);
  history.replaceState(null, "", fragment);
  try {
    await navigator.clipboard.writeText(location.href);
    button.textContent = "Copied";
  } catch {
    // A page that was opened as a file may not be allowed to; the link is in the address then.
    button.textContent = "It is in the address";
  }
  setTimeout(() => (button.textContent = "Copy link"), 2000);
}
