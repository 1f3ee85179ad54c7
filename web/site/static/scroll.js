// Wide elements scroll by themselves, also by the keyboard.
"use strict";

(() => {
  const WIDE = 'pre, .table-wrapper, .scroll, .equations, .output, math[display="block"]';
  const mark = () => {
    for (const one of document.querySelectorAll(WIDE)) {
      if (one.scrollWidth > one.clientWidth) one.setAttribute("tabindex", "0");
      else one.removeAttribute("tabindex");
    }
  };
  addEventListener("load", mark);
  addEventListener("resize", mark);
})();
