// The page: loads the plant, and shows the chosen view.

import "./language"; // first: modules loaded after it ask for the language
import type { Page } from "./context";
import { byId } from "./dom";
import { offerFiles } from "./downloads";
import { embed } from "./embedded";
import { offerFmu } from "./fmu";
import { FrictionCurve } from "./friction-curve";
import { Library, Refusal, TRIAL } from "./library";
import { Parameters } from "./parameters";
import { Settings, VIEWS, type View } from "./settings";
import { storyLinks, tellStory } from "./stories";
import { tabs } from "./tabs";
import { isLive, model, variable } from "./tables";
import { screenButton, themeButton } from "./theme";
import { Study, type FitContext } from "./fit/study";
import { ClosedLoop } from "./views/closed-loop";
import { Fit } from "./views/fit";
import { Presliding } from "./views/presliding";
import { Race } from "./views/race";
import { StickSlip } from "./views/stick-slip";
import { TwoLaws } from "./views/two-laws";

const PAGES: Record<View, new (context: FitContext) => Page> = {
  "stick-slip": StickSlip,
  "two-laws": TwoLaws,
  presliding: Presliding,
  "closed-loop": ClosedLoop,
  race: Race,
  fit: Fit,
};

class Playground implements FitContext {
  readonly settings: Settings;
  readonly study: Study = new Study(this);
  private page: Page | null = null;
  private readonly parameters: Parameters;
  private readonly curve: FrictionCurve;
  private readonly showTab: (view: View) => void;
  private link = 0;

  constructor(readonly library: Library) {
    this.settings = new Settings(library.tables);
    this.parameters = new Parameters(
      this,
      (of, { name }, value) => this.change(of, name, value),
      () => this.reset(),
    );
    byId("parameters").replaceWith(this.parameters.root);
    this.curve = new FrictionCurve(this);
    byId("friction-curve").replaceWith(this.curve.root);
    this.showTab = tabs(byId("tabs"), VIEWS, (view) => {
      // The view before stays in the history, so that Back goes to it.
      this.address("replaceState");
      this.settings.view = view;
      this.settings.story = null;
      this.open();
      this.address("pushState");
    });
    byId("stories").append(...storyLinks());
    screenButton(byId("screen"));
    themeButton(byId("theme"));
    offerFiles(byId("files"), () => this.page?.files() ?? null, this);
    offerFmu(byId("fmu"), this);
    addEventListener("hashchange", () => this.follow());
    // A file that is dropped beside the place for it would be opened instead of the page.
    for (const kind of ["dragover", "drop"]) addEventListener(kind, (event) => event.preventDefault());
    addEventListener("keydown", (event) => this.key(event));
    this.follow();
    const frame = (now: number) => {
      this.page?.frame(now);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  tell(problem: string | null): void {
    const bar = byId("problem");
    bar.textContent = problem ?? "";
    bar.hidden = problem === null;
  }

  change(of: string, name: string, value: number): void {
    const entry = variable(model(this.library.tables, of), name);
    this.library.start(TRIAL, of, new Map([...this.settings.values[of], [name, value]]));
    this.settings.give(of, entry, value);
    this.page?.change(of, name, value, isLive(entry));
    this.parameters.put(of, entry, value);
    for (const slider of document.querySelectorAll(`[data-parameter="${of}.${name}"]`)) slider.dispatchEvent(new CustomEvent("put", { detail: value }));
    if (name === "friction.law") this.lawChanged(of, value);
    if (name.startsWith("friction.")) this.curve.show();
    this.changed();
  }

  changeAll(of: string, values: ReadonlyMap<string, number>): void {
    this.library.start(TRIAL, of, new Map([...this.settings.values[of], ...values]));
    for (const [name, value] of values) this.settings.give(of, variable(model(this.library.tables, of), name), value);
    this.open();
    this.changed();
  }

  changed(): void {
    clearTimeout(this.link);
    // Browsers limit how often a page may change its address.
    this.link = setTimeout(() => this.address("replaceState"), 300);
  }

  /** Writes the settings into the address, in the place of what is there or after it. */
  private address(how: "replaceState" | "pushState"): void {
    clearTimeout(this.link);
    history[how](null, "", this.settings.fragment());
  }

  /** Shows the page of the present settings. */
  open(): void {
    this.tell(null);
    byId("essentials").replaceChildren();
    this.page = new PAGES[this.settings.view](this);
    byId("page").replaceChildren(this.page.root);
    this.showTab(this.settings.view);
    tellStory(byId("watch"), this.settings.story);
    this.parameters.show(this.page.driven);
    this.curve.show();
  }

  /** Takes over the link in the address, but for values that the library refuses. */
  private follow(): void {
    const problems = this.settings.restore(location.hash);
    for (const of of this.settings.models) {
      try {
        this.library.start(TRIAL, of, this.settings.values[of]);
      } catch (error) {
        if (!(error instanceof Refusal)) throw error;
        problems.push(error.message);
        this.settings.forget(of);
      }
    }
    this.open();
    if (problems.length) this.tell(`The link is not followed: ${problems.join("; ")}`);
  }

  private reset(): void {
    for (const of of this.settings.models) this.settings.forget(of);
    this.open();
    this.changed();
  }

  private lawChanged(of: string, law: number): void {
    for (const select of document.querySelectorAll<HTMLSelectElement>(`select[data-of="${of}.friction.law"]`)) {
      select.value = String(law);
    }
    this.parameters.show();
  }

  private key(event: KeyboardEvent): void {
    const on = event.target as HTMLElement;
    const isTaken = on.matches("input, select, textarea, button, summary, a, [role=slider]");
    if (isTaken || event.ctrlKey || event.metaKey || event.altKey) return;
    const button = { " ": ".transport .primary", ".": "[data-step]", r: "[data-again]" }[event.key];
    const found = button && document.querySelector<HTMLButtonElement>(button);
    if (!found) return;
    event.preventDefault();
    found.click();
  }
}

embed();
const plant = byId("plant").textContent ?? "";
Library.load(plant.trim()).then(
  (library) => {
    new Playground(library);
    // For the console.
    Object.assign(globalThis, { pneumaticServo: library });
    document.documentElement.dataset.ready = "";
  },
  (error: unknown) => {
    byId("problem").hidden = false;
    byId("problem").textContent = `The plant cannot be loaded: ${String(error)}`;
  },
);
