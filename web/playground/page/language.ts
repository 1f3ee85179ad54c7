// A language that this browser can write numbers in. Where the locale is C.UTF-8, WebKit names "C" as the user's
// language, which its own `Intl` refuses with a RangeError. uPlot asks for that language as soon as it is loaded, so this
// module comes before it.

try {
  new Intl.NumberFormat(navigator.language);
} catch {
  Object.defineProperty(navigator, "language", { value: "en-US", configurable: true });
}

export {};
