// The search: sections ranked by MiniSearch (BM25), the best of each page with the words where they stand. It needs no server.
"use strict";

(() => {
  /** Synonyms of the field; a word also finds the others of its line. */
  const SYNONYMS = [
    ["stiction", "static friction", "break-away"],
    ["stick-slip", "stick slip", "stickslip", "jerky", "jerk", "staircase"],
    ["sticking", "stick", "stuck", "jam"],
    ["5/2", "3/2", "solenoid", "on-off", "switching valve"],
    ["pwm", "pulse width", "switching valve"],
    ["gravity", "vertical", "inclination", "incline", "weight"],
    ["cv", "kv", "conductance", "iso 6358"],
    ["single-acting", "spring return", "return spring"],
    ["hunting", "limit cycle", "steady-state error", "oscillation"],
    ["pid", "pi", "controller", "position controller"],
    ["deadband", "dead band", "dead zone", "overlap"],
    ["anti-windup", "windup", "integral"],
    ["backlash", "hysteresis"],
    ["solver", "integrator", "step size"],
    ["gradient", "sensitivity", "derivative", "adjoint", "autodiff"],
    ["matlab", "simulink"],
    ["rl", "reinforcement learning", "gym", "gymnasium", "environment", "stable baselines"],
    ["tuning", "gain", "autotune"],
    ["hose", "tube", "tubing", "pipe"],
    ["mpc", "optimal control", "predictive control"],
    ["kalman", "observer", "state estimation", "estimator"],
    ["uncertainty", "interval", "confidence"],
    ["identification", "fitting", "parameter estimation", "calibrate", "calibration"],
    ["install", "installation", "download", "pip"],
    ["license", "licence", "copyright", "commercial"],
    ["api", "reference", "python reference"],
    ["units", "unit", "bar", "psi"],
    ["windows", "linux", "macos", "mac", "platform"],
    ["hil", "hardware in the loop", "dspace", "speedgoat", "real time"],
    ["plc", "twincat", "codesys", "siemens"],
    ["microcontroller", "embedded", "c code", "cortex"],
    ["temperature", "thermal", "heat"],
    ["leak", "leakage"],
    ["cushion", "cushioning", "damper"],
    ["ssp", "ssv"],
    ["linearise", "linearize", "state space", "transfer function"],
    ["example", "tutorial", "getting started"],
    ["faq", "is there"],
    ["tanh", "regularised", "smooth", "creep"],
    ["presliding", "pre-sliding", "microslip"],
  ];
  /** Weight of a page relative to the documentation: changes and internals come later. */
  const WEIGHTS = [
    [/^docs\/(stick-slip|start\/install|questions)/, 1.6],
    [/^(CHANGELOG|RELEASING|CODE_OF_CONDUCT|SECURITY|tests\/)/, 0.25],
    [/^(CONTRIBUTING|README|python\/|reference\/rust|gallery)/, 0.25],
    [/^reference\//, 0.3],
    [/^docs\/(identification\/|playground|own|interfaces|testing|model-exchange|(solver|sensitivities)-)/, 0.5],
    [/^docs\/performance/, 0.35],
    [/^models\/PositionController/, 0.25],
    [/^models\//, 0.12],
    [/^docs\/(glossary|tutorial\/)/, 0.7],
    [/^laws\//, 0.3],
    [/^docs\/(start\/|friction-laws)/, 1.4],
  ];
  /** Most pages, sections below one, and characters of an excerpt. */
  const [PAGES, MORE, EXCERPT] = [20, 3, 220];

  /** Words, as they stand and in their parts: `deadZone` is `dead` and `zone`, too. */
  const tokens = (text) =>
    (text.match(/[\p{L}\p{N}_]+(?:\/\p{N}+)?/gu) ?? []).flatMap((word) => {
      const parts = word.split(/(?<=\p{Ll})(?=\p{Lu})|[_/]/u);
      return parts.length > 1 ? [word, ...parts] : [word];
    });
  const whole = (text) => text.match(/[\p{L}\p{N}_]+(?:\/\p{N}+)?/gu) ?? [];
  /** Without the ending of a plural, so that valve finds valves. */
  const stem = (word) => {
    const lower = word.toLowerCase();
    return lower.length > 3 && /[^su]s$/.test(lower) ? lower.slice(0, -1) : lower;
  };

  const index = new MiniSearch({
    fields: ["heading", "page", "names", "text"],
    idField: "id",
    tokenize: tokens,
    processTerm: stem,
    searchOptions: { boost: { heading: 3, page: 2, names: 2 }, bm25: { k: 1.2, b: 0.25, d: 0.1 }, tokenize: whole, processTerm: stem },
  });
  const sections = globalThis.SECTIONS;
  index.addAll(sections.map((section, id) => ({ id, ...section })));

  /** The word itself or, for less, one that means nearly the same: all words of it; with `likeness` one that is spelled nearly so. */
  function meant(words, likeness) {
    const plain = words.toLowerCase();
    const alike = SYNONYMS.filter((line) => line.some((entry) => stem(entry) === stem(plain)));
    const others = alike.flat().filter((entry) => stem(entry) !== stem(plain));
    return {
      combineWith: "OR",
      queries: [
        { queries: [plain], combineWith: "AND", prefix: (term) => term.length > 2, fuzzy: (term) => (likeness && term.length > 5 ? 0.15 : 0) },
        ...others.map((entry) => ({ queries: [entry], combineWith: "AND", boost: { heading: 1.2, page: 0.8, text: 0.4 } })),
      ],
    };
  }

  /** The pages that a query finds, best first: the sections of each, best first. */
  function find(query) {
    const words = query.trim().split(/\s+/).filter(Boolean);
    if (!words.length) return [];
    const phrases = SYNONYMS.flat().filter((entry) => entry.includes(" ") && query.toLowerCase().includes(entry));
    const left = phrases.reduce((rest, phrase) => rest.toLowerCase().replace(phrase, " "), query).split(/\s+/).filter(Boolean);
    const wanted = [...phrases, ...(phrases.length ? left : words)];
    const ranked = (combineWith, likeness = false) =>
      index.search({ combineWith, queries: wanted.map((each) => meant(each, likeness)) }, {
        boostDocument: (id) => WEIGHTS.find(([pattern]) => pattern.test(sections[id].address))?.[1] ?? 1,
      });
    // A word that is spelled wrong is looked for only where nothing has it as it stands.
    const tries = [() => ranked("AND"), () => ranked("AND", true), () => ranked("OR", true)];
    const all = tries.reduce((found, next) => (found.length ? found : next()), []);
    const pages = new Map();
    for (const { id, score, terms } of all) {
      const section = { ...sections[id], score, terms };
      pages.set(section.page, [...(pages.get(section.page) ?? []), section]);
    }
    // A page that has the words in many sections is about them.
    const score = (of) => of.slice(0, 6).reduce((sum, section, rank) => sum + section.score / (rank + 1) ** 1.5, 0);
    return [...pages.values()].sort((a, b) => score(b) - score(a)).slice(0, PAGES);
  }

  const make = (tag, attributes = {}, ...children) => {
    const made = Object.assign(document.createElement(tag), attributes);
    made.append(...children);
    return made;
  };

  /** A pattern of any of some words, at its beginning. */
  const any = (words) => {
    const parts = words.map((word) => word.replace(/[^\p{L}\p{N}_]/gu, "\\$&")).sort((a, b) => b.length - a.length);
    return new RegExp(`(?<![\\p{L}\\p{N}])(?:${parts.join("|")})s?`, "giu");
  };

  /** The text around the first of some words, in which each is marked; a word that was typed comes before one like it. */
  function excerpt(text, terms, typed) {
    const pattern = any(terms);
    const first = Math.max(text.search(any(typed)) >= 0 ? text.search(any(typed)) : text.search(pattern), 0);
    const begin = first < 60 ? 0 : text.indexOf(" ", first - 60) + 1;
    const cut = text.slice(begin, begin + EXCERPT);
    const made = make("p", { className: "excerpt" }, begin ? "… " : "");
    let end = 0;
    for (const match of cut.matchAll(pattern)) {
      made.append(cut.slice(end, match.index), make("mark", {}, match[0]));
      end = match.index + match[0].length;
    }
    made.append(cut.slice(end), begin + EXCERPT < text.length ? " …" : "");
    return made;
  }

  const root = document.documentElement.dataset.content_root ?? "";
  const link = ({ address }, text) => make("a", { href: root + address }, text);

  function show(query) {
    const found = find(query);
    document.getElementById("search-count").textContent = query.trim()
      ? `${found.length === PAGES ? `The best ${PAGES}` : found.length || "No"} ${found.length === 1 ? "page" : "pages"} for “${query.trim()}”`
      : "";
    const entry = ([best, ...others]) => {
      const title = best.heading === best.page ? best.page : `${best.page}: ${best.heading}`;
      const more = others.slice(0, MORE).map((section) => make("li", {}, link(section, section.heading)));
      const item = make("li", {}, link(best, title), excerpt(best.text, best.terms, whole(query)));
      if (more.length) item.append(make("ul", {}, ...more));
      return item;
    };
    document.getElementById("search-results").replaceChildren(...found.map(entry));
  }

  const field = document.getElementById("search-words");
  field.value = new URLSearchParams(location.search).get("q") ?? "";
  field.addEventListener("input", () => {
    history.replaceState(null, "", `?q=${encodeURIComponent(field.value)}`);
    show(field.value);
  });
  document.getElementById("search-form").addEventListener("submit", (event) => event.preventDefault());
  show(field.value);
})();
