// Shows the laws that have everything that is wanted.
"use strict";

(() => {
  const chooser = document.getElementById("chooser");
  const boxes = [...chooser.querySelectorAll("input")];
  const rows = [...document.querySelectorAll("#laws tbody tr")];
  const choose = () => {
    const wanted = boxes.filter((box) => box.checked).map((box) => box.value);
    for (const row of rows) row.hidden = !wanted.every((one) => row.dataset.has.split(" ").includes(one));
    const count = rows.filter((row) => !row.hidden).length;
    chooser.querySelector("output").textContent = wanted.length ? `${count} of ${rows.length} laws` : "";
  };
  chooser.addEventListener("change", choose);
  chooser.hidden = false;
  choose();
})();
